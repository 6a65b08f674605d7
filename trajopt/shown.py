"""How a value that somebody gave is shown in a message: short, however large the value is."""

from reprlib import Repr

LONGEST = 80
"""Characters of a value in a message."""


class _Short(Repr):
    """Looks at a few members of a few levels only, so that nothing large is ever written out."""

    def __init__(self) -> None:
        super().__init__()
        self.maxlevel = 3
        self.maxtuple = self.maxlist = self.maxdict = self.maxset = self.maxfrozenset = self.maxarray = 4
        self.maxstring = self.maxother = self.maxlong = LONGEST

    def repr_int(self, x: int, level: int) -> str:
        """Show a whole number; Python itself refuses to write one of thousands of digits."""
        return repr(x) if x.bit_length() < 200 else f"a whole number of {x.bit_length()} bits"

    def repr_bytes(self, x: bytes, level: int) -> str:
        """Show the beginning of bytes."""
        return repr(x[:LONGEST])


def shown(value: object) -> str:
    """Return a value as Python writes it, cut short before it is written: for messages.

    Args:
        value: Anything, however large, deep or tangled.

    Returns:
        At most `LONGEST` characters.
    """
    text = _Short().repr(value)
    return text if len(text) <= LONGEST else f"{text[: LONGEST - 3]}..."
