"""Operations of the rosbridge protocol, version 2, as JSON, and messages in fragments."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from math import ceil
from typing import Any, Protocol

import msgspec

from trajopt.values.errors import TrajoptError, shown

RAW = msgspec.Raw
NOTHING = RAW(b"{}")
LARGEST_ID = 1000
"""Most characters of an id, a topic or another name."""
_ENCODER = msgspec.json.Encoder()
MESSAGES = 8
"""Most incomplete messages of a client at a time."""
PIECES = 10_000


class Incoming(msgspec.Struct):
    """An operation sent by a client; fields of other operations have their defaults.

    Attributes:
        values: Response of a client's service, or feedback or result of a client's action.
        latch: Whether the last message is kept for later subscribers.
        throttle_rate: Least time between two messages [ms].
        fragment_size: Largest message that the client accepts in one piece [bytes].
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


class BridgeClient(Protocol):
    """A connection, as seen by topics, services and actions."""

    def offer(self, message: bytes, fragment_size: int | None = None) -> None:
        """Queue a message, or drop it if the client is too slow."""
        ...

    async def call(self, message: bytes) -> None:
        """Send a message that must arrive."""
        ...


class Unusable(TrajoptError):
    """A client's message cannot be processed; the client receives the reason."""


_DECODER = msgspec.json.Decoder(Incoming)


def parsed(text: str | bytes) -> Incoming:
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
    return _ENCODER.encode(operation)


def plain(raw: msgspec.Raw) -> object:
    try:
        return msgspec.json.decode(raw)
    except RecursionError as error:
        raise Unusable("it is nested too deeply") from error
    except msgspec.MsgspecError as error:
        raise Unusable(f"is not JSON: {error}") from error


def status(level: str, reason: str, name: str | int | None) -> bytes:
    told: dict[str, object] = {"op": "status", "level": level, "msg": reason}
    return written(told if name is None else {**told, "id": name})


def named(name: str | None, what: str) -> str:
    """Return the full name of a topic, service or action; a missing leading slash is added."""
    if not name:
        raise Unusable(f"it names no {what}")
    if not all(each.isalnum() or each in "_/~{}-.:" for each in name):
        raise Unusable(f"{shown(name)} is not a name of a {what}")
    return name if name.startswith("/") else f"/{name}"


def pieces(text: bytes, size: int | None, name: str) -> Iterator[bytes]:
    """Yield a message in pieces of a client's fragment size [bytes], or whole if None."""
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
    """Fragments of incomplete messages of a client."""

    def __init__(self, largest: int) -> None:
        self._largest, self._size = largest, 0
        self._parts: dict[str | int | None, _Parts] = {}

    def add(self, fragment: Incoming) -> str | None:
        name, total = fragment.id, fragment.total
        if not 0 < total <= PIECES or not 0 <= fragment.num < total:
            raise Unusable(f"fragment {fragment.num} of {total}: needs 1 to {PIECES} pieces, counted from 0")
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
