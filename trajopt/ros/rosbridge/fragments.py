"""Fragments: a message of a client that comes in pieces."""

from dataclasses import dataclass, field

from trajopt.ros.rosbridge.wire import Incoming, Unusable

MESSAGES = 8
"""Messages of a client that may be incomplete at a time."""
PIECES = 10_000
"""Pieces of one message."""


@dataclass
class _Parts:
    total: int
    pieces: dict[int, str] = field(default_factory=dict[int, str])


class Fragments:
    """The pieces that a client has sent of messages that are not complete."""

    def __init__(self, largest: int) -> None:
        """Bound the size of all of them together [bytes]."""
        self._largest, self._size = largest, 0
        self._parts: dict[str | int | None, _Parts] = {}

    def add(self, fragment: Incoming) -> str | None:
        """Keep a piece; return the whole message once it is complete.

        Raises:
            Unusable: If the piece has no place in its message, or they are too many or too large.
        """
        name, total = fragment.id, fragment.total
        if not 0 < total <= PIECES or not 0 <= fragment.num < total:
            raise Unusable(f"fragment {fragment.num} of {total}: of 1 to {PIECES} pieces, counted from 0")
        parts = self._parts.setdefault(name, _Parts(total))
        size = self._size + len(fragment.data) - len(parts.pieces.get(fragment.num, ""))
        if parts.total != total or len(self._parts) > MESSAGES or size > self._largest:
            self._drop(name)
            raise Unusable(f"fragments: {MESSAGES} messages and {self._largest} bytes in all at most")
        parts.pieces[fragment.num], self._size = fragment.data, size
        if len(parts.pieces) < total:
            return None
        whole = "".join(parts.pieces[num] for num in range(total))
        self._drop(name)
        return whole

    def _drop(self, name: str | int | None) -> None:
        gone = self._parts.pop(name)
        self._size -= sum(len(piece) for piece in gone.pieces.values())
