"""Operations of the rosbridge protocol, version 2, as JSON, and messages in fragments."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from math import ceil
from typing import Any

import msgspec

from trajopt.values.errors import TrajoptError, shown

RAW = msgspec.Raw
NOTHING = RAW(b"{}")
LARGEST_ID = 1000
"""Characters of an id, a topic or another name."""
_ENCODER = msgspec.json.Encoder()
MESSAGES = 8
"""Messages of a client that may be incomplete at a time."""
PIECES = 10_000
"""Pieces of one message."""


class Incoming(msgspec.Struct):
    """An operation that a client sends; what other operations have is at its default.

    Attributes:
        op: Which operation.
        id: The client's own name for it.
        topic: Of a topic.
        service: Of a service.
        action: Of an action.
        type: Type of a topic or service.
        action_type: Type of an action.
        msg: What is published.
        args: What is asked of a service or an action.
        values: Answer of a service, or feedback or result of an action, that a client offers.
        result: Whether the service or the goal succeeded.
        status: How a goal ended (`action_msgs/GoalStatus`).
        latch: Whether the last message is kept for who subscribes later.
        throttle_rate: Least time between two messages [ms].
        compression: How messages are written.
        fragment_size: Largest message that the client takes in one piece [bytes].
        timeout: Time that a call may take [s].
        data: A fragment.
        num: Its place.
        total: How many there are.
        level: Of what the client wants to be told.
    """

    op: str
    id: str | int | None = None
    topic: str | None = None
    service: str | None = None
    action: str | None = None
    type: str | None = None
    action_type: str | None = None
    msg: msgspec.Raw = NOTHING
    args: msgspec.Raw = NOTHING
    values: msgspec.Raw = NOTHING
    result: bool = True
    status: int = 0
    latch: bool | None = None
    throttle_rate: float | None = None
    compression: str | None = None
    fragment_size: int | None = None
    timeout: float | None = None
    data: str = ""
    num: int = 0
    total: int = 0
    level: str = ""


class Unusable(TrajoptError):
    """A message of a client cannot be done; the reason is told to it."""


_DECODER = msgspec.json.Decoder(Incoming)


def parsed(text: str | bytes) -> Incoming:
    """Return the operation that a client sent.

    Raises:
        Unusable: If it is none.
    """
    try:
        incoming = _DECODER.decode(text)
    except (msgspec.MsgspecError, ValueError) as error:
        raise Unusable(f"no operation of rosbridge: {error}") from error
    except RecursionError as error:
        raise Unusable("no operation of rosbridge: it is nested too deeply") from error
    names = (incoming.op, incoming.topic, incoming.service, incoming.action, incoming.type, incoming.id)
    if any(isinstance(name, str) and len(name) > LARGEST_ID for name in names):
        raise Unusable(f"a name has {LARGEST_ID} characters at most")
    return incoming


def written(operation: Mapping[str, Any]) -> bytes:
    """Return an operation as JSON."""
    return _ENCODER.encode(operation)


def plain(raw: msgspec.Raw) -> object:
    """Return a part of an operation as plain data.

    Raises:
        Unusable: If it is nested too deeply.
    """
    try:
        return msgspec.json.decode(raw)
    except RecursionError as error:
        raise Unusable("it is nested too deeply") from error
    except msgspec.MsgspecError as error:
        raise Unusable(f"is not JSON: {error}") from error


def status(level: str, reason: str, name: str | int | None) -> bytes:
    """Return what tells a client of something: that an operation was not done, and why."""
    told: dict[str, object] = {"op": "status", "level": level, "msg": reason}
    return written(told if name is None else {**told, "id": name})


def named(name: str | None, what: str) -> str:
    """Return the full name of a topic, service or action, with the slash that some leave out.

    Raises:
        Unusable: If there is none.
    """
    if not name:
        raise Unusable(f"it names no {what}")
    if not all(each.isalnum() or each in "_/~{}-.:" for each in name):
        raise Unusable(f"{shown(name)} is not a name of a {what}")
    return name if name.startswith("/") else f"/{name}"


def pieces(text: bytes, size: int | None, name: str) -> Iterator[bytes]:
    """Yield a message in pieces that are no larger than a client takes.

    Args:
        text: The message.
        size: The largest piece [bytes]; None for any.
        name: Of the message.
    """
    if size is None or size < 1 or len(text) <= size:
        yield text
        return
    whole = text.decode()
    total = ceil(len(whole) / size)
    for num in range(total):
        data = whole[num * size : (num + 1) * size]
        yield written({"op": "fragment", "id": name, "data": data, "num": num, "total": total})


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
