"""What the server and its workers say to each other: one message after the other, each with its length."""

from collections.abc import Mapping
from struct import Struct as Layout
from typing import TypeAlias

import msgspec

LENGTH = Layout(">I")
"""Before each message: how many bytes it has."""


class Hello(msgspec.Struct, tag=True, frozen=True):
    """The first message to a worker.

    Attributes:
        robots: The robots by name, pickled.
        modules: Modules that hold the operations.
        memory: What one request may take beyond what the worker has then [bytes].
        triangles: Of the meshes of a request.
        points: Of a trajectory in a request.
        cloud: Points of a cloud in a request.
    """

    robots: Mapping[str, bytes]
    modules: tuple[str, ...]
    memory: int
    triangles: int
    points: int
    cloud: int


class Request(msgspec.Struct, tag=True, frozen=True):
    """A request to a worker; it has one at a time.

    Attributes:
        number: Told by everything that the worker says about it.
        operation: What is to be done.
        robot: Name of the robot.
        scene: The scene, packed.
        key: Its key.
        stamps: When clouds in it were measured, by name.
        positions: Of all joints [rad | m].
        body: The arguments, JSON.
        attachment: What came beside them, as it came.
        seconds: Time that it may take [s].
        feedback: Whether somebody listens.
        driven: Whether the session's robot is being driven by another request.
    """

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


class Ready(msgspec.Struct, tag=True, frozen=True):
    """A worker has loaded its robots.

    Attributes:
        memory: What it has of memory [bytes].
    """

    memory: int


class Feedback(msgspec.Struct, tag=True, frozen=True):
    """How far a request is: JSON, and where the robot stands if that changed."""

    number: int
    body: bytes
    positions: list[float] | None = None


class Answered(msgspec.Struct, tag=True, frozen=True):
    """A request is done.

    Attributes:
        number: Of the request.
        body: The answer, JSON.
        scene: The new scene, packed, where there is one.
        positions: Where the robot stands now, where that changed [rad | m].
        stamps: When clouds in the scene were measured, by name.
        cpu: Processor time that it took [s].
        memory: What the worker has of memory now [bytes].
    """

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
FromWorker: TypeAlias = Ready | Feedback | Answered | Rejected

_ENCODER = msgspec.msgpack.Encoder()
FROM_WORKER: msgspec.msgpack.Decoder[FromWorker] = msgspec.msgpack.Decoder(FromWorker)
TO_WORKER: msgspec.msgpack.Decoder[ToWorker] = msgspec.msgpack.Decoder(ToWorker)


def framed(message: ToWorker | FromWorker) -> bytes:
    """Return a message with its length before it."""
    body = _ENCODER.encode(message)
    return LENGTH.pack(len(body)) + body
