"""Planes: the tables, boards and walls of a cloud, each as a slab that contains its balls."""

from dataclasses import dataclass

import numpy as np

from trajopt.lab.perception.clusters import groups, slab_around
from trajopt.values.arrays import Floats, Ints, Value, above_zero, at_least
from trajopt.values.errors.arguments import checked
from trajopt.values.placement import Placement
from trajopt.values.shapes.shapes import Box, Points

SEEDS = 400
"""Number of tried places: a plane with a hundredth of the points is hit four times."""
AROUND = 24
"""Number of neighbours that determine a plane at a place: two rings of cells."""
LEVEL = float(np.cos(np.deg2rad(5.0)))
"""A plane is level, or upright, to within 5 degrees: as floors and walls are built, and cameras placed."""


@dataclass(frozen=True, eq=False)
class FlatPart(Value):
    """A flat part of a cloud.

    Attributes:
        name: "table" if it is level, "wall" if it is upright, else "slope"; numbered from the second on.
        points: Which points of the cloud it has, rising, shape (n,).
        box: A slab that contains the balls of all of them; its z is across.
        placement: Of the slab in the cloud's frame; z points up, or away from the cloud's middle.
    """

    name: str
    points: Ints
    box: Box
    placement: Placement

    @property
    def normal(self) -> Floats:
        """Its direction, shape (3,)."""
        return self.placement.rotation[:, 2]


@checked
@dataclass(frozen=True)
class Flatness(Value):
    """Parameters of a plane.

    Attributes:
        tolerance: Largest distance of its points [m]; 0 for the radius of the cloud's balls.
        least: Least number of points.
        gap: Parts farther apart are separate planes [m].
        most: Largest number of planes.
    """

    tolerance: float = 0.0
    least: int = 400
    gap: float = 0.03
    most: int = 8

    def __post_init__(self) -> None:
        """Check the numbers."""
        at_least(self, 0.0, "tolerance")
        at_least(self, 3, "least")
        above_zero(self, "gap", "most")


DEFAULT = Flatness()


@checked
def planes(cloud: Points, flatness: Flatness = DEFAULT) -> tuple[FlatPart, ...]:
    """Return the flat parts of a cloud, the largest first; reproducible.

    Args:
        cloud: The cloud.
        flatness: Parameters.
    """
    left = np.arange(len(cloud.points))
    within = flatness.tolerance or cloud.radius
    found: list[FlatPart] = []
    named: dict[str, int] = {}
    while len(left) >= flatness.least and len(found) < flatness.most:
        points = cloud.points[left]
        normal, offset = _best(points, within)
        on = np.flatnonzero(np.abs(points @ normal - offset) <= within)
        part = on[groups(points[on], flatness.gap)[0]] if len(on) else on
        if len(part) < flatness.least:
            break
        kind = _kind(normal)
        named[kind] = named.get(kind, 0) + 1
        name = kind if named[kind] == 1 else f"{kind} {named[kind]}"
        outward = normal if _points_out(normal, offset, cloud.points) else -normal
        own: Ints = np.sort(left[part]).astype(np.int64)
        own.flags.writeable = False
        found.append(FlatPart(name, own, *slab_around(cloud.points[own], cloud.radius, outward)))
        left = np.setdiff1d(left, own, assume_unique=True)
    return tuple(found)


def _best(points: Floats, within: float) -> tuple[Floats, float]:
    """Return the normal and offset of the plane that has most points within a distance."""
    from scipy.spatial import cKDTree  # slow to import

    seeds = points[:: max(1, len(points) // SEEDS)]
    _, near = cKDTree(points).query(seeds, k=min(AROUND, len(points)))
    around = points[near]
    centred = around - around.mean(axis=1, keepdims=True)
    normals = np.linalg.eigh(np.einsum("sni,snj->sij", centred, centred))[1][:, :, 0]
    offsets = np.einsum("si,si->s", normals, around.mean(axis=1))
    # A tenth of the points decides as well, to a few in a hundred, in a tenth of the time.
    some = points[:: max(1, len(points) // (10 * SEEDS))]
    counts = (np.abs(some @ normals.T - offsets) <= within).sum(axis=0)
    normal, offset = normals[int(counts.argmax())], float(offsets[int(counts.argmax())])
    for _ in range(3):
        on = points[np.abs(points @ normal - offset) <= within]
        if len(on) < 3:
            break
        middle = on.mean(axis=0)
        normal = np.linalg.eigh((on - middle).T @ (on - middle))[1][:, 0]
        offset = float(normal @ middle)
    return normal, offset


def _kind(normal: Floats) -> str:
    if abs(normal[2]) >= LEVEL:
        return "table"
    return "wall" if abs(normal[2]) <= np.sqrt(1.0 - LEVEL**2) else "slope"


def _points_out(normal: Floats, offset: float, points: Floats) -> bool:
    """Return whether a normal points up, or, if level, away from the cloud's centre."""
    if abs(normal[2]) > np.sqrt(1.0 - LEVEL**2):
        return bool(normal[2] > 0.0)
    return bool(normal @ points.mean(axis=0) <= offset)
