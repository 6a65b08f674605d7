"""What goes over the wire: the operations of the rosbridge protocol, version 2, as JSON."""

from collections.abc import Iterator, Mapping
from math import ceil
from typing import Any

import msgspec

from trajopt.values.errors import TrajoptError, shown

RAW = msgspec.Raw
NOTHING = RAW(b"{}")
LARGEST_ID = 1000
"""Characters of an id, a topic or another name."""


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
_ENCODER = msgspec.json.Encoder()


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
