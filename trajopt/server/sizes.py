"""Sizes of what a request holds, looked at before anything is made of it."""

from typing import cast

from trajopt.server.refusals import Refusal, Why
from trajopt.server.watch import Watch

MESHES = ("triangles", "faces")
POINTS = ("points", "waypoints", "poses", "placements", "positions")
"""Members that hold one element for each triangle of a mesh, or for each point of a motion or curve."""


def check_sizes(document: object, watch: Watch) -> None:
    """Make sure that the meshes and trajectories of a request are not larger than they may be.

    Args:
        document: Plain data, nested as deep as `parse_json` allows.
        watch: Of the request: it knows the bounds.

    Raises:
        Refusal: If there are too many triangles in all, or too many points in one list.
    """
    triangles = _count(document, watch.points)
    if triangles > watch.triangles:
        raise Refusal(
            Why.TOO_LARGE,
            f"the meshes of a request have {watch.triangles} triangles at most, not {triangles}",
        )


def _count(value: object, points: int) -> int:
    """Return the triangles of all meshes in a document; refuse a list of too many points."""
    if isinstance(value, list):
        return sum(_count(each, points) for each in cast("list[object]", value))
    if not isinstance(value, dict):
        return 0
    total = 0
    for key, inner in cast("dict[str, object]", value).items():
        length = len(cast("list[object]", inner)) if isinstance(inner, list) else 0
        if key in POINTS and length > points:
            raise Refusal(Why.TOO_LARGE, f"{key} has {points} elements at most, not {length}")
        total += (length if key in MESHES else 0) + _count(cast(object, inner), points)
    return total
