"""Segmentation of a cloud: connected parts in oriented boxes, and flat parts."""

from dataclasses import dataclass

import numpy as np

from trajopt.lab.perception.sensing import once, packed, unpacked
from trajopt.values.arrays import Floats, Ints, Value, above_zero, at_least, readonly
from trajopt.values.errors.arguments import checked
from trajopt.values.placement import Placement
from trajopt.values.shapes.shapes import Box, Points, outermost

TOUCHING = 1.75
"""Cubes of edge 1 that share a face, an edge or a corner have middles at most sqrt(3) apart, the next 2."""


@dataclass(frozen=True, eq=False)
class Cluster(Value):
    """Connected points.

    Attributes:
        name: "cluster 1" for the largest, and so on.
        placement: Of the box in the cloud's frame.
    """

    name: str
    points: Ints
    box: Box
    placement: Placement


@checked
@dataclass(frozen=True)
class Clustering(Value):
    """Parameters of a cluster.

    Attributes:
        gap: Points closer than this are always in one cluster; points farther apart than four times this are
            not, unless others connect them [m].
        least: Fewest points of a cluster: smaller ones are mostly noise.
        upright: Whether boxes are upright, like things on a table; otherwise they have the smallest volume.
    """

    gap: float = 0.02
    least: int = 20
    upright: bool = True

    def __post_init__(self) -> None:
        above_zero(self, "gap")
        at_least(self, 1, "least")


DEFAULT = Clustering()


@checked
def clusters(cloud: Points, clustering: Clustering = DEFAULT) -> tuple[Cluster, ...]:
    """Return the connected parts of a cloud, the largest first.

    A cluster's points may be replaced by its box.
    """
    found: list[Cluster] = []
    for own in groups(cloud.points, clustering.gap):
        if len(own) >= clustering.least:
            box, where = box_around(cloud.points[own], cloud.radius, upright=clustering.upright)
            found.append(Cluster(f"cluster {len(found) + 1}", own, box, where))
    return tuple(found)


@checked
def without(cloud: Points, parts: tuple[Ints, ...]) -> Points | None:
    """Return a cloud without the points of these indices, or None if none is left."""
    stays = np.ones(len(cloud.points), dtype=np.bool_)
    for part in parts:
        stays[part] = False
    return Points(cloud.points[stays], cloud.radius) if stays.any() else None


def groups(points: Floats, gap: float) -> list[Ints]:
    """Return the indices of connected points, the largest group first.

    Touching cubes with edges of the gap belong to one group.
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


ROUNDING = 1e-9
"""Enlargement of a box that covers rounding errors within 50 m [m]."""


def box_around(points: Floats, radius: float, *, upright: bool) -> tuple[Box, Placement]:
    """Return a box around balls with centres (n, 3) [m], and its placement in their frame."""
    outer = outermost(points)
    best = min(
        (_standing(outer, axes) for axes in _frames(outer, upright=upright)), key=lambda found: found[0]
    )
    return _grown(points, radius, best[1])


def slab_around(points: Floats, radius: float, normal: Floats) -> tuple[Box, Placement]:
    return _grown(points, radius, _standing(outermost(points), _with_axis(normal))[1])


def _grown(points: Floats, radius: float, axes: Floats) -> tuple[Box, Placement]:
    along = points @ axes
    lower, upper = along.min(axis=0), along.max(axis=0)
    sizes = upper - lower + 2.0 * (radius + ROUNDING)
    where = Placement(readonly(axes), readonly(axes @ ((lower + upper) / 2)))
    return Box(*map(float, sizes)), where


def _standing(points: Floats, axes: Floats) -> tuple[float, Floats]:
    flat = points @ axes[:, :2]
    corners = outermost(flat)
    edges = np.diff(np.vstack((corners, corners[:1])), axis=0)
    angles = np.append(np.arctan2(edges[:, 1], edges[:, 0]) % (np.pi / 2), 0.0)
    cosines, sines = np.cos(angles), np.sin(angles)
    wide = np.ptp(np.outer(corners[:, 0], cosines) + np.outer(corners[:, 1], sines), axis=0)
    deep = np.ptp(np.outer(corners[:, 1], cosines) - np.outer(corners[:, 0], sines), axis=0)
    best = int((wide * deep).argmin())
    turned = np.column_stack(
        (axes[:, :2] @ (cosines[best], sines[best]), axes[:, :2] @ (-sines[best], cosines[best]))
    )
    return float(wide[best] * deep[best] * np.ptp(points @ axes[:, 2])), np.column_stack((turned, axes[:, 2]))


def _frames(points: Floats, *, upright: bool) -> list[Floats]:
    from scipy.spatial import ConvexHull, QhullError  # slow to import

    if upright:
        return [np.eye(3)]
    try:
        normals = np.unique(ConvexHull(points).equations[:, :3].round(9), axis=0)
    except (QhullError, ValueError):
        # All in one plane or line: the directions in which they are spread.
        centred = points - points.mean(axis=0)
        normals = np.linalg.svd(centred if len(points) > 2 else np.vstack((centred, np.eye(3))))[2][2:3]
    return [_with_axis(normal) for normal in normals]


def _with_axis(normal: Floats) -> Floats:
    third = normal / float(np.linalg.norm(normal))
    helper = np.eye(3)[int(np.abs(third).argmin())]
    across: Floats = helper - float(helper @ third) * third
    first: Floats = across / float(np.linalg.norm(across))
    axes = np.eye(3)
    axes[:, 0], axes[:, 1], axes[:, 2] = first, np.cross(third, first), third
    return axes


SEEDS = 400
"""Number of tried places: a plane with a hundredth of the points is hit four times."""
AROUND = 24
"""Number of neighbours that determine a plane at a place: two rings of cells."""
LEVEL = float(np.cos(np.deg2rad(5.0)))
"""A plane is level, or upright, to within 5 degrees."""


@dataclass(frozen=True, eq=False)
class FlatPart(Value):
    """A flat part of a cloud.

    Attributes:
        name: "table" if it is level, "wall" if it is upright, else "slope"; numbered from the second on.
        points: Their indices in the cloud, rising, shape (n,).
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
        gap: Parts farther apart are separate planes [m].
    """

    tolerance: float = 0.0
    least: int = 400
    gap: float = 0.03
    most: int = 8

    def __post_init__(self) -> None:
        at_least(self, 0.0, "tolerance")
        at_least(self, 3, "least")
        above_zero(self, "gap", "most")


DEFAULT_PLANES = Flatness()


@checked
def planes(cloud: Points, flatness: Flatness = DEFAULT_PLANES) -> tuple[FlatPart, ...]:
    """Return the flat parts of a cloud, the largest first; reproducible."""
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
    if abs(normal[2]) > np.sqrt(1.0 - LEVEL**2):
        return bool(normal[2] > 0.0)
    return bool(normal @ points.mean(axis=0) <= offset)
