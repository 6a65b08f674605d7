"""Answering: standard input of a script that nobody sits in front of."""

import io
import sys
from typing import TextIO


class Answering(io.TextIOBase):
    """Says Enter to every question of `input()` that the source has no line for.

    Reading in other ways (`for line in sys.stdin`, `sys.stdin.read()`) ends where the source ends.
    """

    def __init__(self, source: TextIO | None = None) -> None:
        """Choose where answers come from first; from nowhere when None."""
        self._source = source

    def readable(self) -> bool:
        """Say that it can be read."""
        return True

    def readline(self, size: int | None = -1, /) -> str:  # type: ignore[override]
        """Return the next line, or an empty one."""
        line = self._line()
        if not line:
            sys.stdout.write("\n")  # As a terminal would show Enter, so that what follows has its own line.
        return line or "\n"

    def read(self, size: int | None = -1, /) -> str:
        """Return what is left of the source."""
        return "" if self._source is None else self._source.read(-1 if size is None else size)

    def __next__(self) -> str:  # type: ignore[override]
        """Return the next line of the source."""
        line = self._line()
        if not line:
            raise StopIteration
        return line

    def _line(self) -> str:
        return "" if self._source is None else self._source.readline()
