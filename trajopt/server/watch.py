"""Watch: limits, cancellation and progress of a running operation."""

import time
from collections.abc import Callable, Mapping
from threading import Event, Lock

from trajopt.optimise.solvers import Iteration
from trajopt.planning.result import Result
from trajopt.scene.scene import Scene
from trajopt.values.errors.arguments import checked

SPACING = 0.05
"""Shortest interval between progress messages of solver steps [s]."""
ATTEMPT = "optimise"
"""The first long stage of each attempt."""


class Watch:
    """Limits, cancellation and listener of a request.

    Attributes:
        cancel: Set when the answer is no longer needed.
        heard: Whether there is a listener.
        triangles: Most triangles of all meshes in a request.
        points: Most points of a trajectory in a request.
        cloud: Most points of a cloud in a request.
        attachment: Bytes of the request in addition to its arguments.
        driven: Whether another request drives the session's robot and determines its positions.
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
        """Start the clock.

        Args:
            seconds: Time limit of the request [s].
            tell: Sends progress and robot positions; None without a listener.
            triangles: Most triangles of all meshes in a request.
            points: Most points of a trajectory in a request.
            cloud: Most points of a cloud in a request.
            attachment: Bytes of the request in addition to its arguments.
            driven: Whether another request drives the session's robot.
        """
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
        """Send progress.

        Args:
            document: Plain data.
            positions: New positions of all joints of the session's robot, if they changed [rad | m].
        """
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
