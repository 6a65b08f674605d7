"""Limits on the resources of clients, requests, sessions and processes, and refusals beyond them."""

import os
import resource
import sys
from dataclasses import dataclass, field
from enum import Enum
from pathlib import Path
from typing import cast

from trajopt.server.operation import Watch
from trajopt.values.arrays import Value, positive
from trajopt.values.errors import ProblemError, TrajoptError
from trajopt.values.errors.arguments import checked
from trajopt.values.processes import cores

MEGABYTE = 2**20


@checked
@dataclass(frozen=True, kw_only=True)
class Limits(Value):
    """Limits on the resources of clients.

    Attributes:
        workers: Planning processes; by default the number of cores.
        runs: Simultaneously driven robots; each has its own process.
        waiting: Requests that may wait for a process; further ones are refused.
        waiting_per_session: Likewise for one session, so that it cannot block the others.
        seconds: Time limit of a request, waiting included [s]; a request may set a shorter one.
        grace: Time that a process has to end before it is killed [s].
        memory: Memory of one request, beyond the present memory of its process [bytes].
        bodies: Total size of all requests in progress [bytes].
        idle: Idle time after which the longest unused session is removed if there are too many [s].
    """

    workers: int = field(default_factory=cores)
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
        for name, value in vars(self).items():
            positive(f"limits: {name}", value)
        if self.bodies < self.body:
            raise ProblemError(f"limits: bodies ({self.bodies}) must be at least body ({self.body})")


class Why(Enum):
    """Kinds of refusals; each value is its name in messages."""

    MALFORMED = "malformed"
    UNKNOWN = "unknown"
    TOO_LARGE = "too large"
    BUSY = "busy"
    FULL = "full"
    OUT_OF_TIME = "out of time"
    OUT_OF_MEMORY = "out of memory"
    WORKER_LOST = "worker lost"
    CANCELLED = "cancelled"
    CLOSING = "closing"
    FAILED = "failed"


class RequestRefused(TrajoptError):
    """A refused request.

    Attributes:
        retry_after: Delay before a sensible retry [s]; None without one.
    """

    def __init__(self, why: Why, reason: str, *, retry_after: float | None = None) -> None:
        self.why, self.reason, self.retry_after = why, reason, retry_after
        super().__init__(f"{why.value}: {reason}")

    def as_dict(self) -> dict[str, object]:
        """Return plain JSON data."""
        return {"error": {"kind": self.why.value, "reason": self.reason}}


def memory_used(pid: int | None = None) -> int:
    """Return the resident memory of a process, by default this one [bytes]; 0 if unknown."""
    return _pages(pid or os.getpid(), 1)


def limit_memory(more: int) -> None:
    """Limit the further memory of this process [bytes], on Linux; beyond it a `MemoryError` is raised.

    Each call replaces the previous limit.
    """
    if sys.platform == "linux":
        # What is only reserved, as by the stacks of threads, does not count: so data, not address space.
        bound, (_, hard) = _pages(os.getpid(), 5) + more, resource.getrlimit(resource.RLIMIT_DATA)
        resource.setrlimit(resource.RLIMIT_DATA, (bound if hard < 0 else min(bound, hard), hard))


def _pages(pid: int, column: int) -> int:
    try:
        columns = Path(f"/proc/{pid}/statm").read_text().split()
    except OSError:
        return 0
    return int(columns[column]) * resource.getpagesize()


MESHES = ("triangles", "faces")
POINTS = ("points", "waypoints", "poses", "placements", "positions")
"""Members with one element for each triangle of a mesh, or for each point of a motion or curve."""


def check_sizes(document: object, watch: Watch) -> None:
    """Check the sizes of meshes and trajectories in a request."""
    triangles = _count(document, watch.points)
    if triangles > watch.triangles:
        raise RequestRefused(
            Why.TOO_LARGE,
            f"the meshes of a request have {watch.triangles} triangles at most, not {triangles}",
        )


def _count(value: object, points: int) -> int:
    if isinstance(value, list):
        return sum(_count(each, points) for each in cast("list[object]", value))
    if not isinstance(value, dict):
        return 0
    total = 0
    for key, inner in cast("dict[str, object]", value).items():
        length = len(cast("list[object]", inner)) if isinstance(inner, list) else 0
        if key in POINTS and length > points:
            raise RequestRefused(Why.TOO_LARGE, f"{key} has {points} elements at most, not {length}")
        total += (length if key in MESHES else 0) + _count(cast(object, inner), points)
    return total
