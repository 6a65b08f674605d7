"""Members: the documents, arrays and meshes that something kept is made of, wherever they lie."""

import io
from abc import ABC, abstractmethod
from hashlib import sha256
from pathlib import Path
from tokenize import TokenError
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from trajopt.values.errors import FileFormatError

LARGEST = 2**28
"""Bytes of all members together when unpacked: as many as of one file elsewhere."""
LARGEST_ARRAY = 2**26
"""Bytes of an array: eight million numbers. Code makes copies of what it checks."""
LARGEST_DOCUMENT = 2**24
"""Bytes of a JSON document, which takes up to thirty times as much memory once it is parsed; arrays and
meshes have members of their own."""
_TYPES = ("<f8", "<i8", "<i4", "|b1")


class Members(ABC):
    """Members by name, read one by one.

    Attributes:
        path: Where they lie, as messages say it.
    """

    def __init__(self, path: Path) -> None:
        """Note where they lie."""
        self.path = path

    @property
    @abstractmethod
    def names(self) -> tuple[str, ...]:
        """The names of the members."""

    @abstractmethod
    def read(self, name: str, *, most: int = LARGEST) -> bytes:
        """Return what a member holds.

        Args:
            name: Its name.
            most: Bytes that it may hold.

        Raises:
            FileFormatError: If there is none of that name, or it holds more, or is damaged.
        """

    def error(self, reason: str) -> FileFormatError:
        """Return the error that says what is wrong with the file."""
        return FileFormatError(str(self.path), reason)

    def array(self, name: str) -> NDArray[np.generic]:
        """Return an array, read-only.

        Raises:
            FileFormatError: If the member is no array of numbers, or not of the size that it states.
        """
        data = self.read(name, most=LARGEST_ARRAY)
        stream, layout = io.BytesIO(data), cast("Any", np.lib.format)
        try:
            version = layout.read_magic(stream)
            if version != (1, 0):
                raise self.error(f"{name} is an array of format {version}, known: (1, 0)")
            header: tuple[tuple[int, ...], bool, np.dtype[Any]] = layout.read_array_header_1_0(stream)
        except (ValueError, TypeError, SyntaxError, TokenError, RecursionError, MemoryError) as error:
            raise self.error(f"{name} is no array: {error}") from error
        shape, fortran, kind = header
        rest = len(data) - stream.tell()
        if fortran or kind.str not in _TYPES:
            raise self.error(f"{name} is an array of a kind that no bundle has: {kind.str}")
        count = 1
        for size in shape:
            count *= size
        if any(size < 0 for size in shape) or count * kind.itemsize != rest:
            raise self.error(f"{name} says that it has shape {shape}, and holds {rest} bytes")
        return cast("NDArray[np.generic]", np.frombuffer(data, kind, count, stream.tell()).reshape(shape))


def array_bytes(array: NDArray[np.generic]) -> bytes:
    """Return an array as a member holds it: numpy's own format, without objects."""
    stream = io.BytesIO()
    layout = cast("Any", np.lib.format)
    layout.write_array(stream, np.ascontiguousarray(array), version=(1, 0), allow_pickle=False)
    return stream.getvalue()


def digest(data: bytes) -> str:
    """Return the SHA-256 of a member, in hexadecimal digits."""
    return sha256(data).hexdigest()
