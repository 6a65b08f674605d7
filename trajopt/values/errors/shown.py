"""Values, names and paths in messages, shortened to a bounded length."""

from collections.abc import Mapping, Sequence
from reprlib import Repr
from typing import Any

LISTED = 12
"""Largest number of names in a message."""


def listed(names: Sequence[str]) -> str:
    """Return names for a message; only the first ones if there are many."""
    return ", ".join(end_of(name) for name in names[:LISTED]) + (", ..." if len(names) > LISTED else "")


SHOWN_LENGTH = 80
"""Characters of a value in a message."""
VECTOR = 8
"""Largest vector that is written out in a message."""


class _Short(Repr):
    """Visits only a few members of a few levels, so that large values are never printed."""

    def __init__(self) -> None:
        super().__init__()
        self.maxlevel = 3
        self.maxtuple = self.maxlist = self.maxdict = self.maxset = self.maxfrozenset = self.maxarray = 4
        self.maxstring = self.maxother = self.maxlong = SHOWN_LENGTH

    def repr_int(self, x: int, level: int) -> str:
        """Show a whole number; Python refuses to print one of thousands of digits."""
        return repr(x) if x.bit_length() < 200 else f"a whole number of {x.bit_length()} bits"

    def repr_ndarray(self, x: Any, level: int) -> str:
        if x.ndim == 1 and x.size <= VECTOR and x.dtype.kind == "f":
            return "[" + ", ".join(f"{value:.4g}" for value in x.tolist()) + "]"
        return f"array of shape {x.shape}"

    def repr_bytes(self, x: bytes, level: int) -> str:
        return repr(x[:SHOWN_LENGTH])


def shown(value: object) -> str:
    """Return the repr of a value, shortened before it is built.

    Args:
        value: Any value, however large, deep or recursive.

    Returns:
        At most `SHOWN_LENGTH` characters.
    """
    text = _Short().repr(value)
    return text if len(text) <= SHOWN_LENGTH else f"{text[: SHOWN_LENGTH - 3]}..."


PATH_LENGTH = 200
"""Characters of a path in a message."""


def end_of(path: str) -> str:
    """Return a path, or only its end if it is very long."""
    return path if len(path) <= PATH_LENGTH else f"...{path[3 - PATH_LENGTH :]}"


def unknown_attribute(owner: object, name: str, other_names: Mapping[str, str]) -> AttributeError:
    """Return the error of an unknown attribute, with the name to use if it is known.

    Args:
        owner: The object.
        name: The attribute.
        other_names: Name in another library -> the expression to use here.
    """
    words = f"{type(owner).__name__!r} object has no attribute {name!r}"
    hint = other_names.get(name)
    return AttributeError(f"{words}: use {hint}" if hint else words, name=name, obj=owner)
