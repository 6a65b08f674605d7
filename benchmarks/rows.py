"""Rows of a long run on disk: one line a problem, written whole or not at all."""

import json
import os
from pathlib import Path


class Rows:
    """The rows of a file.

    Attributes:
        done: Key -> row.
    """

    def __init__(self, file: Path) -> None:
        """Read the existing rows; an incomplete last line is cut away."""
        file.parent.mkdir(parents=True, exist_ok=True)
        self._file = file
        text = file.read_bytes() if file.exists() else b""
        whole = text[: text.rfind(b"\n") + 1]
        if len(whole) < len(text):
            os.truncate(file, len(whole))
        rows = [json.loads(line) for line in whole.splitlines()]
        self.done: dict[str, dict[str, object]] = {str(row["key"]): row for row in rows}

    def append(self, row: dict[str, object]) -> None:
        """Add a row, on disk when this returns."""
        line = (json.dumps(row) + "\n").encode()
        handle = os.open(self._file, os.O_WRONLY | os.O_APPEND | os.O_CREAT, 0o644)
        try:
            os.write(handle, line)
            os.fsync(handle)
        finally:
            os.close(handle)
        self.done[str(row["key"])] = row
