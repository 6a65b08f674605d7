"""Limits: what one client, one request and all sessions together may take of the server."""

import os
from dataclasses import dataclass, field

from trajopt.values.arrays import Value, number
from trajopt.values.errors import ProblemError, shown
from trajopt.values.errors.arguments import checked

MEGABYTE = 2**20


def _cores() -> int:
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


@checked
@dataclass(frozen=True, kw_only=True)
class Limits(Value):
    """What the server lets its clients take.

    Attributes:
        workers: Processes that plan; as many as the machine has cores.
        runs: Robots that may be driven at the same time; each has a process of its own while it is.
        views: 3-D pages that may be open at the same time; each has a process of its own while it is.
        waiting: Requests that may wait for a process; one more is refused, with when to try again.
        waiting_per_session: The same of one session, so that one alone cannot keep all others out.
        seconds: Time that a request may take, waiting included [s]; it may ask for less.
        run_seconds: The same while a robot is driven [s].
        view_seconds: The same while a 3-D page is open [s].
        grace: A process that does not end so long after it was told to is killed [s].
        memory: What one request may take of memory beyond what its process has taken before it [bytes].
        body: Size of a request [bytes].
        bodies: Size of all requests that are under way at a time, together [bytes].
        triangles: Of all meshes of a request.
        points: Of a trajectory in a request.
        cloud: Points of a cloud in a request; a depth camera of 640 x 480 pixels measures 307,200.
        sessions: Sessions at a time.
        idle: When there are so many, the one unused for longest goes, if it is unused for so long [s].
        session_bytes: Size of what a session holds [bytes].
    """

    workers: int = field(default_factory=_cores)
    runs: int = 4
    views: int = 4
    waiting: int = 64
    waiting_per_session: int = 32
    seconds: float = 60.0
    run_seconds: float = 300.0
    view_seconds: float = 86_400.0
    grace: float = 2.0
    memory: int = 1024 * MEGABYTE
    body: int = 16 * MEGABYTE
    bodies: int = 128 * MEGABYTE
    triangles: int = 50_000
    points: int = 20_000
    cloud: int = 400_000
    sessions: int = 256
    idle: float = 600.0
    session_bytes: int = 64 * MEGABYTE

    def __post_init__(self) -> None:
        """Check that each is positive, and that a request of the largest size has room.

        Raises:
            ProblemError: If that is not so.
        """
        for name, value in vars(self).items():
            if not number(name, value) > 0.0:
                raise ProblemError(f"limits: {name} must be positive, is {shown(value)}")
        if self.bodies < self.body:
            raise ProblemError(f"limits: bodies ({self.bodies}) must be at least body ({self.body})")
