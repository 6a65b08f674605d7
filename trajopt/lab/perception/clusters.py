"""Clusters: what of a cloud hangs together, each in an oriented box that contains its balls."""

from dataclasses import dataclass

import numpy as np

from trajopt.lab.perception.cells import once, packed, unpacked
from trajopt.lab.perception.oriented_box import box_around
from trajopt.values.arrays import Floats, Ints, Value, above_zero, at_least
from trajopt.values.errors.arguments import checked
from trajopt.values.placement import Placement
from trajopt.values.shapes.shapes import Box, Points

TOUCHING = 1.75
"""Cubes of edge 1 that share a face, an edge or a corner have middles at most sqrt(3) apart, the next 2."""


@dataclass(frozen=True, eq=False)
class Cluster(Value):
    """Points that hang together.

    Attributes:
        name: "cluster 1" for the largest, and so on.
        points: Which points of the cloud it has, rising, shape (n,).
        box: A box that contains the balls of all of them.
        placement: Of the box in the cloud's frame.
    """

    name: str
    points: Ints
    box: Box
    placement: Placement


@checked
@dataclass(frozen=True)
class Clustering(Value):
    """What counts as one thing.

    Attributes:
        gap: Points nearer to each other than this always are of one cluster, and points farther than
            four times this never are, unless others lead from one to the other [m].
        least: A cluster has so many points at least: fewer are mostly noise.
        upright: Whether boxes stand upright, as things on a table do; otherwise they are turned to be as
            small as they can.
    """

    gap: float = 0.02
    least: int = 20
    upright: bool = True

    def __post_init__(self) -> None:
        """Check the numbers."""
        above_zero(self, "gap")
        at_least(self, 1, "least")


DEFAULT = Clustering()


@checked
def clusters(cloud: Points, clustering: Clustering = DEFAULT) -> tuple[Cluster, ...]:
    """Return what of a cloud hangs together, the largest first.

    What is in no cluster is left to the cloud: a box that stands for its points may take their place, but
    those of no cluster must stay.

    Args:
        cloud: The cloud.
        clustering: What counts as one thing.
    """
    found: list[Cluster] = []
    for own in groups(cloud.points, clustering.gap):
        if len(own) >= clustering.least:
            box, where = box_around(cloud.points[own], cloud.radius, upright=clustering.upright)
            found.append(Cluster(f"cluster {len(found) + 1}", own, box, where))
    return tuple(found)


@checked
def without(cloud: Points, parts: tuple[Ints, ...]) -> Points | None:
    """Return a cloud without some of its points; None where none is left.

    Args:
        cloud: The cloud.
        parts: Numbers of points, of clusters or planes that something else stands for.
    """
    stays = np.ones(len(cloud.points), dtype=np.bool_)
    for part in parts:
        stays[part] = False
    return Points(cloud.points[stays], cloud.radius) if stays.any() else None


def groups(points: Floats, gap: float) -> list[Ints]:
    """Return the numbers of the points that hang together, the largest group first.

    Points are put into cubes with edges of the gap; cubes that touch each other are of one group.
    """
    from scipy.sparse import coo_array  # slow to import
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import cKDTree

    own = packed(np.floor((points - points.min(axis=0)) / gap).astype(np.int64))
    cubes = once(own)
    pairs = cKDTree(unpacked(cubes)).query_pairs(TOUCHING, output_type="ndarray")
    links = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), (len(cubes), len(cubes)))
    label = connected_components(links, directed=False)[1][np.searchsorted(cubes, own)]
    order = np.argsort(label, kind="stable")
    begins = np.flatnonzero(np.diff(label[order], prepend=-1))
    split = np.split(order, begins[1:])
    return [_fixed(part) for part in sorted(split, key=lambda part: (-len(part), int(part[0])))]


def _fixed(part: Ints) -> Ints:
    part = part.astype(np.int64)
    part.flags.writeable = False
    return part
