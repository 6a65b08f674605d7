"""Watch: what an operation is told while it works, and tells of itself."""

import time
from collections.abc import Callable, Mapping
from threading import Event, Lock

from trajopt.optimise.solvers import Iteration
from trajopt.planning.result import Result
from trajopt.scene.scene import Scene
from trajopt.values.errors.arguments import checked

SPACING = 0.05
"""Steps of a solver are told at most so often [s]: a reader takes in no more, and each costs the planner."""
ATTEMPT = "optimise"
"""The stage with which each attempt begins in earnest."""


class Watch:
    """What a request may take, whether it is still wanted, and who listens.

    Attributes:
        cancel: Set once nobody wants the answer any more.
        heard: Whether anybody listens.
        triangles: Most triangles of all meshes in a request.
        points: Most points of a trajectory in a request.
        cloud: Most points of a cloud in a request.
        attachment: What came with the request beside its arguments, as it came.
        driven: Whether the session's robot is being driven by another request: then that says where it is.
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
            seconds: Time that the request may take [s].
            tell: Sends feedback, and where the robot stands; None where nobody listens.
            triangles: Most triangles of all meshes in a request.
            points: Most points of a trajectory in a request.
            cloud: Most points of a cloud in a request.
            attachment: What came with the request beside its arguments.
            driven: Whether the session's robot is being driven by another request.
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
        """Tell whoever listens.

        Args:
            document: Plain data.
            positions: Where all joints of the session's robot are now, if that changed [rad | m].
        """
        if self._tell is not None:
            self._tell(document, positions)

    def progress(self, stage: str, step: Iteration | None) -> None:
        """Tell the stage of planning and the solver's step; `plan` calls it."""
        now = time.monotonic()
        if stage == ATTEMPT and step is None:
            self._attempt += 1
        if stage == self._stage and now - self._last < SPACING:
            return
        self._stage, self._last = stage, now
        numbers = {} if step is None else {"cost": step.cost, "violation": step.violation}
        self.tell({"stage": stage, "attempt": self._attempt, **numbers, "best": self._best})

    def incumbent(self, result: Result) -> None:
        """Tell that there is a motion, or a better one; `plan` calls it."""
        self._best = result.cost
        self.tell({"stage": self._stage, "attempt": self._attempt, "best": self._best})

    @checked
    def change(self, scene: Callable[[], Scene]) -> None:
        """Take note of a new scene, which is read when it is asked for; any thread may call it."""
        with self._lock:
            self._scene = scene

    def changed(self) -> Scene | None:
        """Return the scene that the session has got since the last call; None where it is as it was."""
        with self._lock:
            scene, self._scene = self._scene, None
        return None if scene is None else scene()
