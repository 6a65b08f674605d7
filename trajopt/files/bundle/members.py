"""Members: the documents, arrays and meshes of a stored value, wherever they are stored."""

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
"""Largest unpacked size of all members together, equal to the limit of other files [bytes]."""
LARGEST_ARRAY = 2**26
"""Largest size of an array, eight million numbers; checks make copies of it [bytes]."""
LARGEST_DOCUMENT = 2**24
"""Largest size of a JSON document without its arrays and meshes, which are separate members. Parsing takes up
to
thirty times as much memory [bytes].
"""
_TYPES = ("<f8", "<i8", "<i4", "|b1")


class Members(ABC):
    """Members by name, read one by one.

    Attributes:
        path: Their location, used in error messages.
    """

    def __init__(self, path: Path) -> None:
        """Store the location."""
        self.path = path

    @property
    @abstractmethod
    def names(self) -> tuple[str, ...]:
        """The names of the members."""

    @abstractmethod
    def read(self, name: str, *, most: int = LARGEST) -> bytes:
        """Return the bytes of a member.

        Args:
            name: Its name.
            most: Largest size allowed [bytes].

        Raises:
            FileFormatError: If the member is missing, too large or damaged.
        """

    def error(self, reason: str) -> FileFormatError:
        """Return an error about the file."""
        return FileFormatError(str(self.path), reason)

    def array(self, name: str) -> NDArray[np.generic]:
        """Return an array, read-only.

        Raises:
            FileFormatError: If the member is not an array of numbers, or its size differs from the declared
                size.
        """
        data = self.read(name, most=LARGEST_ARRAY)
        stream, layout = io.BytesIO(data), cast("Any", np.lib.format)
        try:
            version = layout.read_magic(stream)
            if version != (1, 0):
                raise self.error(f"{name} is an array of format {version}, known: (1, 0)")
            header: tuple[tuple[int, ...], bool, np.dtype[Any]] = layout.read_array_header_1_0(stream)
        except (ValueError, TypeError, SyntaxError, TokenError, RecursionError, MemoryError) as error:
            raise self.error(f"{name} is not an array: {error}") from error
        shape, fortran, kind = header
        rest = len(data) - stream.tell()
        if fortran or kind.str not in _TYPES:
            raise self.error(f"{name} is an array of a kind that no bundle has: {kind.str}")
        count = 1
        for size in shape:
            count *= size
        if any(size < 0 for size in shape) or count * kind.itemsize != rest:
            raise self.error(f"{name} declares shape {shape}, but has {rest} bytes")
        return cast("NDArray[np.generic]", np.frombuffer(data, kind, count, stream.tell()).reshape(shape))


def array_bytes(array: NDArray[np.generic]) -> bytes:
    """Return an array in numpy's own format, without objects."""
    stream = io.BytesIO()
    layout = cast("Any", np.lib.format)
    layout.write_array(stream, np.ascontiguousarray(array), version=(1, 0), allow_pickle=False)
    return stream.getvalue()


def digest(data: bytes) -> str:
    """Return the SHA-256 of a member, in hexadecimal digits."""
    return sha256(data).hexdigest()
