"""Messages between the server and its workers, each with its length."""

from collections.abc import Mapping
from struct import Struct as Layout
from typing import TypeAlias

import msgspec

LENGTH = Layout(">I")
"""Prefix of each message: its number of bytes."""


class Hello(msgspec.Struct, tag=True, frozen=True):
    """The first message to a worker: robots, and the memory that a request may add [bytes]."""

    robots: Mapping[str, bytes]
    modules: tuple[str, ...]
    memory: int
    triangles: int
    points: int
    cloud: int


class Request(msgspec.Struct, tag=True, frozen=True):
    """A request to a worker, which has one at a time."""

    number: int
    operation: str
    robot: str
    scene: bytes
    key: bytes
    stamps: dict[str, float]
    positions: list[float]
    body: bytes
    attachment: bytes
    seconds: float
    feedback: bool
    driven: bool


class Cancel(msgspec.Struct, tag=True, frozen=True):
    """End a request soon."""

    number: int


class Changed(msgspec.Struct, tag=True, frozen=True):
    """The scene of a session has changed while a robot is driven in it."""

    number: int
    robot: str
    scene: bytes
    key: bytes


class WorkerReady(msgspec.Struct, tag=True, frozen=True):
    """A worker has loaded its robots; `memory` is its own [bytes]."""

    memory: int


class Feedback(msgspec.Struct, tag=True, frozen=True):
    """Progress of a request: JSON, and the robot's positions if they changed."""

    number: int
    body: bytes
    positions: list[float] | None = None


class Answered(msgspec.Struct, tag=True, frozen=True):
    """A request is done."""

    number: int
    body: bytes
    scene: bytes | None
    positions: list[float] | None
    stamps: dict[str, float]
    cpu: float
    memory: int


class Rejected(msgspec.Struct, tag=True, frozen=True):
    """A request cannot be answered: the kind and the reason."""

    number: int
    why: str
    reason: str
    cpu: float
    memory: int


ToWorker: TypeAlias = Hello | Request | Cancel | Changed
FromWorker: TypeAlias = WorkerReady | Feedback | Answered | Rejected

_ENCODER = msgspec.msgpack.Encoder()
FROM_WORKER: msgspec.msgpack.Decoder[FromWorker] = msgspec.msgpack.Decoder(FromWorker)
TO_WORKER: msgspec.msgpack.Decoder[ToWorker] = msgspec.msgpack.Decoder(ToWorker)


def framed(message: ToWorker | FromWorker) -> bytes:
    body = _ENCODER.encode(message)
    return LENGTH.pack(len(body)) + body
