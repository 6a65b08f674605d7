"""Convex pieces that contain the surface of a mesh, for exact collision distances.

A mesh whose hull reaches nowhere far from it is one hull. Any other is cut by planes, greedily, until
no piece's hull holds a point farther than a tolerance from the mesh; then pieces that stay good
together are merged. Triangles are clipped exactly at the planes, so every point of the surface lies in
the hull of its own piece by construction. What else was tried: docs/decisions/convex-pieces.md.
"""

import itertools
import math
from dataclasses import dataclass
from enum import Enum

import numpy as np

from trajopt.arrays import Bools, Floats, readonly
from trajopt.errors import ShapeError
from trajopt.model.meshes.array_cache import Arrays, cached_arrays
from trajopt.model.meshes.mesh_file import Mesh, clipped, components

THICKNESS = 1e-4
"""Least thickness of a piece [m]: to a flatter one as much is added, half on either side."""
VERSION = 2
"""Of the algorithm: part of the key of what is kept on disk."""

_SAMPLES = 60_000  # points in the hull of a mesh at which its distance is looked at
_JUDGES = 1500  # of these, and of a piece's triangles, about so many tell which cuts are promising
_MOST_WORK = 10**10  # samples times planes that cutting may cost, about a minute; merging as much again
_SNAP = 1e-6  # corners this near a cutting plane count as in it, as a share of the mesh's size
_PROMISING = 8  # cuts judged with all triangles, after all were with a few
_FACE_PLANES, _FACE_NORMALS, _OFFSETS = 12, 4, 5  # cuts tried: at the largest faces, along normals


class CoverMethod(Enum):
    """How a mesh became convex."""

    HULL = "hull"
    DECOMPOSITION = "decomposition"


@dataclass(frozen=True, eq=False)
class ConvexCover:
    """Convex pieces whose union contains the surface of a mesh.

    Attributes:
        pieces: Extreme points of each piece, frame of the mesh, shape (k, 3) [m], read-only.
        method: Whether the one piece is the mesh's hull, or the mesh was cut.
        excess: Volume that the plain hull adds, as a share of the mesh's (the union of its closed
            parts, with hollows that nothing can enter); infinite if the mesh bounds no volume.
        reach: How far the pieces stand out of the mesh at most [m], at points sampled in its hull.
    """

    pieces: tuple[Floats, ...]
    method: CoverMethod
    excess: float
    reach: float

    def __post_init__(self) -> None:
        """Make the pieces read-only."""
        for piece in self.pieces:
            readonly(piece)


@dataclass(frozen=True, eq=False)
class _Hull:
    vertices: Floats  # (k, 3)
    planes: Floats  # (f, 4): outward normal and offset, negative inside
    volume: float

    def holds(self, points: Floats) -> Bools:
        """Tell which points, shape (k, 3), lie strictly inside."""
        low, high = self.vertices.min(axis=0), self.vertices.max(axis=0)
        left = np.flatnonzero(((points > low) & (points < high)).all(axis=1))
        for start in range(0, len(self.planes), 24):  # a few at a time, as most points fail early
            some = self.planes[start : start + 24]
            left = left[(points[left] @ some[:, :3].T + some[:, 3] < -1e-9).all(axis=1)]
        inside = np.zeros(len(points), dtype=np.bool_)
        inside[left] = True
        return inside


@dataclass(frozen=True, eq=False)
class _Samples:
    points: Floats  # (k, 3), in the hull of the mesh and outside of the mesh
    depth: Floats  # (k,), distance to the mesh

    def chosen(self, which: Bools | slice) -> "_Samples":
        return _Samples(self.points[which], self.depth[which])

    def reach(self, hull: _Hull) -> float:
        return float(self.depth[hull.holds(self.points)].max(initial=0.0))


@dataclass(eq=False)
class _Work:
    """What cutting and merging have cost: counted, so that a cover is the same on every machine."""

    spent: int = 0

    def count(self, samples: int, triangles: int, hull: _Hull) -> None:
        """Count samples asked against the planes of a hull, and the hull's making."""
        self.spent += samples * len(hull.planes) + 200 * triangles


@dataclass(frozen=True, eq=False)
class _Piece:
    triangles: Floats  # (m, 3, 3)
    hull: _Hull
    wrong: _Samples  # those that this piece holds, and none should


def convex_pieces(
    mesh: Mesh, *, hull_excess: float = 0.05, tolerance: float = 0.01, max_pieces: int = 64
) -> ConvexCover:
    """Cover the surface of a mesh by convex pieces.

    The mesh becomes its hull where that reaches no farther than `tolerance` from it, or adds at most
    `hull_excess` of volume and reaches no farther than twice the tolerance. Otherwise every piece
    reaches no farther than `tolerance`, unless `max_pieces` do not suffice, or the work does not that
    cutting and merging may cost: it is counted (no clock is asked), and so much takes about two minutes
    of one processor. Then pieces stay that reach farther, as `reach` says. So a distance to the pieces
    is the true one or smaller, by at most that. Pieces may fill what a ball of radius `tolerance`
    cannot enter from outside: narrow holes, shut hollows. An open mesh is a thin sheet, no solid.

    Covers are kept on disk, in the folder $TRAJOPT_CACHE_DIR or else the user's cache folder.

    Args:
        mesh: Closed or open, of one or many parts, which may overlap.
        hull_excess: Share of the mesh's volume that its hull may add.
        tolerance: Farthest that pieces may reach from the mesh [m]. It is judged at points sampled in
            the hull, so they reach a little farther, the more so the larger the mesh is.
        max_pieces: Cutting ends at so many; merging leaves fewer.

    Returns:
        The pieces. They contain the surface whatever the options are.

    Raises:
        ShapeError: If the mesh has no face, or an option is out of range.
    """
    if not len(mesh.faces):
        raise ShapeError("mesh", "has no face, so there is nothing to cover")
    if not (hull_excess >= 0.0 and tolerance > 0.0 and max_pieces >= 1):
        given = f"{hull_excess:g}, {tolerance:g}, {max_pieces}"
        raise ShapeError("hull_excess, tolerance, max_pieces", f"need >= 0, > 0, >= 1, are {given}")
    options = np.array([VERSION, _SAMPLES, THICKNESS, hull_excess, tolerance, max_pieces])
    key = (mesh.vertices.tobytes(), mesh.faces.tobytes(), options.tobytes())

    def make() -> Arrays:
        cover = _cover(mesh, hull_excess, tolerance, max_pieces)
        return {
            "points": np.concatenate(cover.pieces),
            "ends": np.cumsum([len(piece) for piece in cover.pieces]),
            "method": np.array(cover.method.value),
            "figures": np.array([cover.excess, cover.reach]),
        }

    kept = cached_arrays("convex", key, ("points", "ends", "method", "figures"), make)
    excess, reach = kept["figures"].tolist()
    pieces = np.split(kept["points"], kept["ends"][:-1])
    return ConvexCover(tuple(pieces), CoverMethod(str(kept["method"])), excess, reach)


def _cover(mesh: Mesh, hull_excess: float, tolerance: float, max_pieces: int) -> ConvexCover:
    hull = _hull(mesh.vertices)
    outside, excess = _outside(mesh, hull, tolerance)
    reach = float(outside.depth.max(initial=0.0))
    if reach <= tolerance or (excess <= hull_excess and reach <= 2.0 * tolerance):
        return ConvexCover((hull.vertices,), CoverMethod.HULL, excess, reach)
    snap = _SNAP * float(np.linalg.norm(np.ptp(mesh.vertices, axis=0)))
    wrong = outside.chosen(outside.depth > tolerance)
    work = _Work()
    bad, good = [_Piece(mesh.triangles, hull, wrong)], list[_Piece]()
    while bad and len(bad) + len(good) < max_pieces and work.spent < _MOST_WORK:
        worst = max(range(len(bad)), key=lambda index: float(bad[index].wrong.depth.sum()))
        parts = _divided(bad.pop(worst), snap, work)
        for part in parts:
            (bad if len(part.wrong.depth) and len(parts) > 1 else good).append(part)
    hulls = _merged([piece.hull for piece in good + bad], wrong, work)
    reach = max(outside.reach(hull) for hull in hulls)
    return ConvexCover(tuple(hull.vertices for hull in hulls), CoverMethod.DECOMPOSITION, excess, reach)


def _hull(points: Floats) -> _Hull:
    """Return the convex hull of points, shape (n, 3), thickened where it is flat."""
    from scipy.spatial import ConvexHull

    centred = points - points.mean(axis=0)
    for axis in np.linalg.eigh(centred.T @ centred)[1].T:
        if np.ptp(points @ axis) < THICKNESS:
            half = 0.5 * THICKNESS * axis
            points = np.concatenate([points + half, points - half])
    hull = ConvexHull(points)
    return _Hull(points[hull.vertices], np.asarray(hull.equations, dtype=np.float64), float(hull.volume))


def _outside(mesh: Mesh, hull: _Hull, tolerance: float) -> tuple[_Samples, float]:
    """Return samples of the hull outside of the mesh, where things can get to, and the hull's excess."""
    from scipy.spatial import KDTree

    points = _spread(hull)
    points = points[~mesh.contains(points, opening=tolerance)]
    samples = _Samples(points, mesh.distance(points))
    free = samples.depth <= tolerance
    free[~free] = _reachable(samples.chosen(~free), hull)
    shut = samples.chosen(~free)
    if len(shut.depth):  # of a shut hollow, all up to its walls is
        distance, near = KDTree(shut.points).query(points)
        free &= np.asarray(distance) > shut.depth[near]
    count = int(np.count_nonzero(free))
    excess = count / (_SAMPLES - count) if count < _SAMPLES else math.inf
    return samples.chosen(free), excess


def _spread(hull: _Hull) -> Floats:
    """Return points evenly spread in the hull, shape (_SAMPLES, 3): the same ones at every run."""
    from scipy.spatial import ConvexHull

    centre = hull.vertices.mean(axis=0)
    corners = hull.vertices[ConvexHull(hull.vertices).simplices]
    share = np.cumsum(np.abs(np.linalg.det(corners - centre)))
    golden = 1.1673039782614187  # the root of x^5 = x + 1: Kronecker's sequence in four dimensions
    number = np.arange(1, _SAMPLES + 1)[:, None]
    sequence = np.mod(0.5 + number / golden ** np.arange(1, 5), 1.0)
    which = np.asarray(np.searchsorted(share, sequence[:, 0] * share[-1]), dtype=np.int64)
    weights = np.diff(np.sort(sequence[:, 1:], axis=1), axis=1, prepend=0.0)
    return centre + np.einsum("kc,kcx->kx", weights, corners[which] - centre)


def _reachable(samples: _Samples, hull: _Hull) -> Bools:
    """Tell to which samples something can get from outside, going from centre to centre.

    Each is the centre of a ball, of its depth, that is free of the mesh. Those whose ball stands out
    of the hull are reached, and from one centre to the next, if one of the two balls holds both.
    """
    from scipy.spatial import KDTree

    points, depth = samples.points, samples.depth
    if not len(points):
        return np.zeros(0, dtype=np.bool_)
    below = np.full(len(points), np.inf)
    for plane in hull.planes:
        np.minimum(below, -(points @ plane[:3] + plane[3]), out=below)
    found = KDTree(points).query(points, k=np.arange(1, min(16, len(points)) + 1))
    distance, near = np.asarray(found[0], dtype=np.float64), np.asarray(found[1], dtype=np.int64)
    first, which = np.nonzero(distance <= np.maximum(depth[:, None], depth[near]))
    room = components(len(points), first, near[first, which])
    return np.isin(room, room[below < depth])


def _divided(piece: _Piece, snap: float, work: _Work) -> list[_Piece]:
    """Return both sides of the piece at the best plane of those tried; the piece if there is none."""
    planes = _planes(piece)
    if not len(planes):
        return [piece]
    judges = piece.wrong.chosen(slice(None, None, 1 + len(piece.wrong.depth) // _JUDGES))
    few = piece.triangles[:: 1 + len(piece.triangles) // _JUDGES]
    rough = [_cut(few, plane, snap, judges, work)[0] for plane in planes]
    promising = planes[np.argsort(rough, kind="stable")[:_PROMISING]]
    _, sides = min(
        (_cut(piece.triangles, plane, snap, judges, work) for plane in promising), key=lambda cut: cut[0]
    )
    return [_Piece(side, hull, piece.wrong.chosen(hull.holds(piece.wrong.points))) for side, hull in sides]


def _cut(
    triangles: Floats, plane: Floats, snap: float, wrong: _Samples, work: _Work
) -> tuple[float, list[tuple[Floats, _Hull]]]:
    """Cut at a plane; return what of the wrong samples the sides still hold, by depth, and the sides.

    The power prefers, of two cuts alike, one with a good side to one that leaves both to be cut.
    """
    sides = [(side, _hull(side.reshape(-1, 3))) for side in clipped(triangles, plane, snap) if len(side)]
    for side, hull in sides:
        work.count(len(wrong.depth), len(side), hull)
    return sum(float(wrong.depth[hull.holds(wrong.points)].sum()) ** 0.85 for _, hull in sides), sides


def _planes(piece: _Piece) -> Floats:
    """Return planes n x = o worth a cut, shape (c, 4): of large faces, and through the wrong points."""
    corners = np.unique(piece.triangles.reshape(-1, 3), axis=0)
    a, b, c = np.moveaxis(piece.triangles, 1, 0)
    cross = np.cross(b - a, c - a)
    area = np.linalg.norm(cross, axis=1)
    proper = area > 1e-14
    normal = cross[proper] / area[proper, None]
    planes = np.column_stack([normal, np.sum(normal * a[proper], axis=1)])
    size = float(np.ptp(corners, axis=0).max())
    bins = np.round(planes * np.array([50.0, 50.0, 50.0, 500.0 / size])).astype(np.int64)
    _, first, face = np.unique(bins, axis=0, return_index=True, return_inverse=True)
    largest = np.argsort(-np.bincount(face.ravel(), weights=area[proper]), kind="stable")
    planes = planes[first[largest[:_FACE_PLANES]]]
    centred = corners - corners.mean(axis=0)
    principal = np.linalg.eigh(centred.T @ centred)[1].T
    normals = np.concatenate([np.eye(3), principal, planes[:_FACE_NORMALS, :3]])
    along = piece.wrong.points @ normals.T
    low, extent = along.min(axis=0), np.ptp(along, axis=0)
    swept = [np.column_stack([normals, low + share * extent]) for share in np.linspace(0.0, 1.0, _OFFSETS)]
    planes = np.concatenate([planes, *swept])
    height = corners @ planes[:, :3].T - planes[:, 3]
    behind, before = height.min(axis=0) < -1e-3 * size, height.max(axis=0) > 1e-3 * size
    faces = np.arange(len(planes)) < len(planes) - len(normals) * _OFFSETS
    return planes[(behind & before) | (faces & (behind | before))]


def _merged(hulls: list[_Hull], wrong: _Samples, work: _Work) -> list[_Hull]:
    """Replace pairs of hulls by their common hull, tightest first, while it holds no wrong sample."""
    kept = dict(enumerate(hulls))
    joined: dict[tuple[int, int], tuple[float, _Hull]] = {}

    def join(i: int, j: int) -> None:
        if work.spent >= 2 * _MOST_WORK:
            return  # What is not merged covers as well, with more pieces.
        hull = _hull(np.concatenate([kept[i].vertices, kept[j].vertices]))
        work.count(len(wrong.depth), len(hull.vertices), hull)
        if not hull.holds(wrong.points).any():
            joined[i, j] = (hull.volume - kept[i].volume - kept[j].volume, hull)

    for i, j in itertools.combinations(kept, 2):
        join(i, j)
    while joined:
        best = min(joined, key=lambda pair: joined[pair][0])
        new, hull = max(kept) + 1, joined[best][1]
        for pair in [pair for pair in joined if set(pair) & set(best)]:
            del joined[pair]
        for index in best:
            del kept[index]
        others = list(kept)
        kept[new] = hull
        for other in others:
            join(other, new)
    return list(kept.values())
