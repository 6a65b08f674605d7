"""Operations of the server: functions of a session's content, a request's arguments and its watch."""

import pickle
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from enum import Enum, auto
from hashlib import blake2b
from importlib import import_module
from io import BytesIO
from threading import Event, Lock
from typing import Any, TypeAlias, cast

from trajopt.optimise.solvers import Iteration
from trajopt.planning.result import Result
from trajopt.robot.robot import Robot
from trajopt.scene.scene import Scene
from trajopt.values.arrays import Floats, Value
from trajopt.values.documents.document import Node
from trajopt.values.errors.arguments import checked


@checked
@dataclass(frozen=True, eq=False)
class SessionState(Value):
    """A robot among objects, and its positions."""

    robot: str
    scene: Scene
    positions: Floats
    stamps: Mapping[str, float] = field(default_factory=dict[str, float])

    @property
    def named_positions(self) -> dict[str, float]:
        """Positions of all joints, by name [rad | m]."""
        return dict(zip(self.scene.robot.joint_names, self.positions.tolist(), strict=True))


@dataclass(frozen=True)
class PackedScene(Value):
    """A scene as bytes, with the name by which the server knows the robot."""

    robot: str
    data: bytes
    key: bytes

    @staticmethod
    def of(robot: str, data: bytes) -> "PackedScene":
        return PackedScene(robot, data, blake2b(data, digest_size=16).digest())


def packed(state: SessionState, robots: Mapping[str, Robot]) -> PackedScene:
    names = {id(robot): name for name, robot in robots.items()}

    class Pickler(pickle.Pickler):
        def persistent_id(self, obj: Any) -> str | None:
            return names.get(id(obj)) if isinstance(obj, Robot) else None

    buffer = BytesIO()
    Pickler(buffer, pickle.HIGHEST_PROTOCOL).dump(state.scene)
    return PackedScene.of(state.robot, buffer.getvalue())


def unpacked(scene: PackedScene, robots: Mapping[str, Robot]) -> Scene:
    class Unpickler(pickle.Unpickler):
        def persistent_load(self, pid: Any) -> Robot:
            return robots[pid]

    return cast(Scene, Unpickler(BytesIO(scene.data)).load())


SPACING = 0.05
"""Shortest interval between progress messages of solver steps [s]."""
ATTEMPT = "optimise"


class Watch:
    """Limits, cancellation and listener of a request.

    Attributes:
        attachment: Bytes of the request beyond its arguments.
        driven: Whether another request drives the session's robot.
    """

    def __init__(
        self,
        seconds: float,
        tell: Callable[[Mapping[str, object], list[float] | None], None] | None = None,
        *,
        triangles: int = 50_000,
        points: int = 20_000,
        cloud: int = 400_000,
        attachment: bytes = b"",
        driven: bool = False,
    ) -> None:
        self.cancel, self.heard = Event(), tell is not None
        self.triangles, self.points, self.cloud = triangles, points, cloud
        self.attachment, self.driven = attachment, driven
        self._until, self._tell = time.monotonic() + seconds, tell
        self._stage, self._last, self._attempt = "", 0.0, 0
        self._best: float | None = None
        self._lock = Lock()
        self._scene: Callable[[], Scene] | None = None

    @property
    def seconds_left(self) -> float:
        """Time until the answer must be there [s]."""
        return self._until - time.monotonic()

    @checked
    def tell(self, document: Mapping[str, object], positions: list[float] | None = None) -> None:
        """Send progress, plain data, and the positions of the session's robot if they changed [rad | m]."""
        if self._tell is not None:
            self._tell(document, positions)

    def progress(self, stage: str, step: Iteration | None) -> None:
        """Send the stage of planning and the solver's step; called by `plan`."""
        now = time.monotonic()
        if stage == ATTEMPT and step is None:
            self._attempt += 1
        if stage == self._stage and now - self._last < SPACING:
            return
        self._stage, self._last = stage, now
        numbers = {} if step is None else {"cost": step.cost, "violation": step.violation}
        self.tell({"stage": stage, "attempt": self._attempt, **numbers, "best": self._best})

    def incumbent(self, result: Result) -> None:
        """Report a motion, or a better one; called by `plan`."""
        self._best = result.cost
        self.tell({"stage": self._stage, "attempt": self._attempt, "best": self._best})

    @checked
    def change(self, scene: Callable[[], Scene]) -> None:
        """Store a new scene, which is unpacked on demand; callable from any thread."""
        with self._lock:
            self._scene = scene

    def changed(self) -> Scene | None:
        """Return the session's scene if it changed since the last call, else None."""
        with self._lock:
            scene, self._scene = self._scene, None
        return None if scene is None else scene()


class Lane(Enum):
    """Group of processes: planning, fast operations, driving, 3-D pages (one each), storage."""

    PLANNING = auto()
    QUICK = auto()
    DRIVING = auto()
    VIEWING = auto()
    KEEPING = auto()

    @property
    def takes_robot(self) -> bool:
        """Whether the robot of the session belongs to the request while it lasts."""
        return self in (Lane.DRIVING, Lane.VIEWING)


@checked
@dataclass(frozen=True)
class Answer(Value):
    """Result of an operation."""

    document: object
    state: SessionState | None = None


Run: TypeAlias = Callable[[SessionState, Node, Watch], Answer]
"""Content of the session, arguments, and the watch -> the answer.

It raises a `TrajoptError` for invalid arguments, whose message is sent to the client.
"""


@checked
@dataclass(frozen=True)
class Operation(Value):
    """An operation of the server; `attached` if it accepts bytes beyond its arguments."""

    run: Run
    lane: Lane = Lane.PLANNING
    edits: bool = False
    attached: bool = False


def operations_of(modules: tuple[str, ...]) -> Mapping[str, Operation]:
    found: dict[str, Operation] = {}
    for module in modules:
        found.update(cast("Mapping[str, Operation]", import_module(module).OPERATIONS))
    return found
