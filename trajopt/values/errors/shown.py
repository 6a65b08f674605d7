"""How values, names and paths are written in messages: cut short, however large they are."""

from collections.abc import Mapping, Sequence
from reprlib import Repr
from typing import Any

LISTED = 12
"""Names that a message lists."""


def listed(names: Sequence[str]) -> str:
    """Return names, the first of them where they are many: for messages."""
    return ", ".join(end_of(name) for name in names[:LISTED]) + (", ..." if len(names) > LISTED else "")


SHOWN_LENGTH = 80
"""Characters of a value in a message."""
VECTOR = 8
"""Numbers of a vector that is written out in a message."""


class _Short(Repr):
    """Looks at a few members of a few levels only, so that nothing large is ever written out."""

    def __init__(self) -> None:
        super().__init__()
        self.maxlevel = 3
        self.maxtuple = self.maxlist = self.maxdict = self.maxset = self.maxfrozenset = self.maxarray = 4
        self.maxstring = self.maxother = self.maxlong = SHOWN_LENGTH

    def repr_int(self, x: int, level: int) -> str:
        """Show a whole number; Python itself refuses to write one of thousands of digits."""
        return repr(x) if x.bit_length() < 200 else f"a whole number of {x.bit_length()} bits"

    def repr_ndarray(self, x: Any, level: int) -> str:
        """Show the numbers of a short vector, and the shape of anything larger."""
        if x.ndim == 1 and x.size <= VECTOR and x.dtype.kind == "f":
            return "[" + ", ".join(f"{value:.4g}" for value in x.tolist()) + "]"
        return f"array of shape {x.shape}"

    def repr_bytes(self, x: bytes, level: int) -> str:
        """Show the beginning of bytes."""
        return repr(x[:SHOWN_LENGTH])


def shown(value: object) -> str:
    """Return a value as Python writes it, cut short before it is written: for messages.

    Args:
        value: Anything, however large, deep or tangled.

    Returns:
        At most `SHOWN_LENGTH` characters.
    """
    text = _Short().repr(value)
    return text if len(text) <= SHOWN_LENGTH else f"{text[: SHOWN_LENGTH - 3]}..."


PATH_LENGTH = 200
"""Characters of a path in a message."""


def end_of(path: str) -> str:
    """Return a path as it is, or only its end where it is very long: for messages."""
    return path if len(path) <= PATH_LENGTH else f"...{path[3 - PATH_LENGTH :]}"


def unknown_attribute(owner: object, name: str, other_names: Mapping[str, str]) -> AttributeError:
    """Return the error of an attribute that does not exist, with the name that is meant if it is known.

    Args:
        owner: The object.
        name: The attribute.
        other_names: Name in another library -> the expression to use here.
    """
    words = f"{type(owner).__name__!r} object has no attribute {name!r}"
    hint = other_names.get(name)
    return AttributeError(f"{words}: use {hint}" if hint else words, name=name, obj=owner)
