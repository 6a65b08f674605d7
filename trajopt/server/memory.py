"""Memory of a process, and bounds on it and on the size of requests."""

import os
import resource
import sys
from pathlib import Path
from typing import cast

from trajopt.server.limits import RequestRefused, Why
from trajopt.server.operation import Watch

KILOBYTE = 2**10


def memory_used(pid: int | None = None) -> int:
    """Return the resident memory of a process [bytes]; 0 if unknown.

    Args:
        pid: Its id; this process if None.
    """
    return _pages(pid or os.getpid(), 1)


def limit_memory(more: int) -> None:
    """Limit the further memory of this process; beyond it a `MemoryError` is raised.

    Each call replaces the previous limit. Only on Linux.

    Args:
        more: Further memory [bytes].
    """
    if sys.platform == "linux":
        # What is only reserved, as by the stacks of threads, does not count: so data, not address space.
        bound, (_, hard) = _pages(os.getpid(), 5) + more, resource.getrlimit(resource.RLIMIT_DATA)
        resource.setrlimit(resource.RLIMIT_DATA, (bound if hard < 0 else min(bound, hard), hard))


def _pages(pid: int, column: int) -> int:
    """Return a column of Linux' table of a process's memory [bytes]; 0 if it does not exist."""
    try:
        columns = Path(f"/proc/{pid}/statm").read_text().split()
    except OSError:
        return 0
    return int(columns[column]) * resource.getpagesize()


MESHES = ("triangles", "faces")
POINTS = ("points", "waypoints", "poses", "placements", "positions")
"""Members with one element for each triangle of a mesh, or for each point of a motion or curve."""


def check_sizes(document: object, watch: Watch) -> None:
    """Check the sizes of meshes and trajectories in a request.

    Args:
        document: Plain data, nested within the limit of `parse_json`.
        watch: Of the request, with the limits.

    Raises:
        RequestRefused: If there are too many triangles in total, or too many points in one list.
    """
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
