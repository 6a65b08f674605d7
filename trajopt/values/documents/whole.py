"""Atomic writing: a reader finds the old or the new content of a file."""

import os
from collections.abc import Generator
from contextlib import contextmanager, suppress
from pathlib import Path
from secrets import token_hex

from trajopt.values.errors import FileFormatError, TrajoptError


@contextmanager
def written_whole(path: Path | str, *, durable: bool = False) -> Generator[Path]:
    """Yield the name of a temporary file, which replaces the file if the block succeeds.

    Each call has its own temporary file, so processes and threads may write one file simultaneously: the last
    to finish wins. Missing folders are created; a failed block leaves nothing.

    Args:
        path: The file.
        durable: Whether to flush the file to disk, so that it survives a power failure; takes some
            milliseconds.

    Raises:
        FileFormatError: If the file cannot be written.
    """
    try:
        target = Path(path)
        draft = target.with_name(f".trajopt-{token_hex(8)}")
        target.parent.mkdir(parents=True, exist_ok=True)
        try:
            yield draft
            if durable:
                _to_disk(draft)
            draft.replace(target)
            if durable:
                _to_disk(target.parent)  # which has the name
        finally:
            with suppress(OSError):
                draft.unlink()
    except TrajoptError:
        raise
    except (OSError, ValueError) as error:
        raise FileFormatError(str(path), f"cannot be written: {error}") from error


def _to_disk(path: Path) -> None:
    """Flush a file, or the names in a folder, to disk."""
    opened = os.open(path, os.O_RDONLY)
    try:
        os.fsync(opened)
    finally:
        os.close(opened)
