"""Convex pieces that contain the surface of a mesh, for exact collision distances.

A mesh whose hull reaches nowhere far from it is one hull. Any other is cut by planes,
greedily, until no piece's hull holds a point that is farther than a tolerance from the
mesh, and pieces that stay good together are merged again. Triangles are clipped exactly at
the planes, so every point of the surface lies in the hull of its own piece by construction.
Why, and what else was tried: docs/decisions/convex-pieces.md.
"""

from __future__ import annotations

import hashlib
import itertools
import math
import os
import sys
import tempfile
import zipfile
from dataclasses import dataclass
from enum import Enum
from pathlib import Path
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import ConvexHull, cKDTree

from trajopt.model.mesh_file import Mesh

FloatArray: TypeAlias = NDArray[np.float64]
BoolArray: TypeAlias = NDArray[np.bool_]

THICKNESS = 1e-4
"""Least thickness of a piece, [m]: a flatter one is thickened by it, half to either side."""

_VERSION = 1  # of the algorithm, part of the key of the cache
_SAMPLES = 60_000  # points of the hull at which the distance to the mesh is looked at
_SNAP = 1e-6  # vertices this near a cutting plane, relative to the mesh's size, lie on it
_FACE_PLANES, _FACE_NORMALS, _OFFSETS = 12, 4, 5  # cuts tried: the largest faces, swept normals


class CoverMethod(Enum):
    """How a mesh became convex."""

    HULL = "hull"
    DECOMPOSITION = "decomposition"


@dataclass(frozen=True, eq=False)
class ConvexCover:
    """Convex pieces whose union contains the surface of a mesh.

    Attributes:
        pieces: Hull vertices of each piece, shape (k, 3), frame of the mesh, [m], read-only.
        method: Whether the one piece is the hull of the mesh, or there were cuts.
        excess: Volume that the plain hull adds, relative to the volume of the mesh (of the
            union of its closed parts); infinite when the mesh bounds no volume.
        reach: Farthest that the pieces stand out of the mesh, [m], over points sampled in
            the hull and not in hollows that are shut off from the outside.
    """

    pieces: tuple[FloatArray, ...]
    method: CoverMethod
    excess: float
    reach: float


@dataclass(frozen=True, eq=False)
class _Hull:
    vertices: FloatArray  # (k, 3)
    planes: FloatArray  # (f, 4): outward normal and offset, <= 0 inside
    volume: float

    def holds(self, points: FloatArray) -> BoolArray:
        """Which points, shape (k, 3), lie strictly inside."""
        low, high = self.vertices.min(axis=0), self.vertices.max(axis=0)
        left = np.flatnonzero(((points > low) & (points < high)).all(axis=1))
        for start in range(0, len(self.planes), 24):
            some = self.planes[start : start + 24]
            left = left[(points[left] @ some[:, :3].T + some[:, 3] < -1e-9).all(axis=1)]
        inside = np.zeros(len(points), dtype=np.bool_)
        inside[left] = True
        return inside


@dataclass(frozen=True, eq=False)
class _Outside:
    """Sampled points that lie in the hull of a mesh and outside of the mesh."""

    points: FloatArray  # (k, 3)
    depth: FloatArray  # (k,) distance to the mesh, [m]

    def within(self, hull: _Hull) -> _Outside:
        inside = hull.holds(self.points)
        return _Outside(self.points[inside], self.depth[inside])

    def deeper(self, depth: float) -> _Outside:
        return _Outside(self.points[self.depth > depth], self.depth[self.depth > depth])


@dataclass(frozen=True, eq=False)
class _Piece:
    triangles: FloatArray  # (m, 3, 3)
    hull: _Hull
    wrong: _Outside  # points that no piece should hold, but this one does


def convex_pieces(
    mesh: Mesh, *, hull_excess: float = 0.05, tolerance: float = 0.01, max_pieces: int = 32
) -> ConvexCover:
    """Cover the surface of a mesh by convex pieces.

    The mesh is one hull when that reaches nowhere farther than `tolerance` from it, or adds
    no more than `hull_excess` of volume and nowhere reaches twice the tolerance. Else every
    piece reaches no farther than `tolerance`, unless `max_pieces` are not enough. Distances
    to the pieces are then true or too small by at most that. Where a ball of radius
    `tolerance` cannot come from outside, the pieces may fill: holes narrower than twice the
    tolerance, shut hollows. An open mesh is a thin sheet, not a solid.

    The result is kept on disk, in the folder $TRAJOPT_CACHE_DIR or the user's cache folder.

    Args:
        mesh: Closed or open, of one or many parts, which may overlap.
        hull_excess: Share of the mesh's volume that its hull may add.
        tolerance: Farthest that a piece may reach from the mesh, [m], as seen at points
            sampled in the hull: in a large mesh less is seen.
        max_pieces: Number of pieces at which cutting ends.

    Returns:
        The pieces, which contain the surface whatever the options are.

    Raises:
        ValueError: if the mesh has no face or an option is out of range.
    """
    if not len(mesh.faces):
        raise ValueError("a mesh without faces has no convex pieces")
    if not (hull_excess >= 0.0 and tolerance > 0.0 and max_pieces >= 1):
        raise ValueError("convex pieces need hull_excess >= 0, tolerance > 0, max_pieces >= 1")
    options = np.array([_VERSION, _SAMPLES, hull_excess, tolerance, max_pieces, THICKNESS])
    key = hashlib.sha256(mesh.vertices.tobytes() + mesh.faces.tobytes() + options.tobytes())
    file = _cache_folder() / f"convex-{key.hexdigest()}.npz"
    cover = _read(file)
    if cover is None:
        cover = _cover(mesh, hull_excess, tolerance, max_pieces)
        _write(file, cover)
    return cover


def _cover(mesh: Mesh, hull_excess: float, tolerance: float, max_pieces: int) -> ConvexCover:
    hull = _hull(mesh.vertices)
    outside, excess = _outside(mesh, hull, tolerance)
    wrong, reach = outside.deeper(tolerance), float(outside.depth.max(initial=0.0))
    if reach <= tolerance or (excess <= hull_excess and reach <= 2.0 * tolerance):
        return _frozen([hull.vertices], CoverMethod.HULL, excess, reach)
    snap = _SNAP * float(np.linalg.norm(np.ptp(mesh.vertices, axis=0)))
    cut, good = [_Piece(mesh.triangles, hull, wrong)], list[_Piece]()
    while cut and len(cut) + len(good) < max_pieces:
        worst = max(range(len(cut)), key=lambda index: float(cut[index].wrong.depth.sum()))
        parts = _divided(cut.pop(worst), snap)
        for part in parts:
            (cut if len(part.wrong.depth) and len(parts) > 1 else good).append(part)
    hulls = _merged([piece.hull for piece in good + cut], wrong)
    reach = max(float(outside.within(hull).depth.max(initial=0.0)) for hull in hulls)
    return _frozen([hull.vertices for hull in hulls], CoverMethod.DECOMPOSITION, excess, reach)


def _frozen(
    pieces: list[FloatArray], method: CoverMethod, excess: float, reach: float
) -> ConvexCover:
    for piece in pieces:
        piece.setflags(write=False)
    return ConvexCover(tuple(pieces), method, excess, reach)


def _hull(points: FloatArray) -> _Hull:
    """Convex hull of points, shape (n, 3), thickened where they are flat."""
    centred = points - points.mean(axis=0)
    axes = np.linalg.eigh(centred.T @ centred)[1].T
    for axis in axes:
        if np.ptp(points @ axis) < THICKNESS:
            points = np.concatenate([points + 0.5 * THICKNESS * axis, points - 0.5 * THICKNESS * axis])
    hull = ConvexHull(points)
    planes = np.asarray(hull.equations, dtype=np.float64)
    return _Hull(np.array(points[hull.vertices]), planes, float(hull.volume))


def _outside(mesh: Mesh, hull: _Hull, tolerance: float) -> tuple[_Outside, float]:
    """Samples of the hull that a ball of radius tolerance can reach, and the excess."""
    points = _samples(hull)
    solid = mesh.contains(points, opening=tolerance)
    volume = np.count_nonzero(solid)
    points = points[~solid]
    depth = mesh.distance(points)
    open_to = np.ones(len(points), dtype=np.bool_)
    deep = np.flatnonzero(depth > tolerance)
    open_to[deep] = _reachable(points[deep], depth[deep], hull)
    volume += np.count_nonzero(~open_to)
    excess = np.count_nonzero(open_to) / volume if volume else math.inf
    return _Outside(points[open_to], depth[open_to]), excess


def _samples(hull: _Hull) -> FloatArray:
    """Points spread evenly in the hull, shape (_SAMPLES, 3): the same ones every time."""
    corners = np.asarray(ConvexHull(hull.vertices).simplices, dtype=np.int64)
    triangles, centre = hull.vertices[corners], hull.vertices.mean(axis=0)
    volume = np.abs(np.linalg.det(triangles - centre))
    golden = 1.1673039782614187  # root of x^5 = x + 1: the additive sequence of four dimensions
    number = np.arange(1, _SAMPLES + 1)[:, None]
    fraction = np.mod(0.5 + number / golden ** np.arange(1, 5), 1.0)
    which = np.searchsorted(np.cumsum(volume) / volume.sum(), fraction[:, 0])
    cuts = np.sort(fraction[:, 1:], axis=1)
    weights = np.diff(cuts, axis=1, prepend=0.0, append=1.0)
    tetrahedra = triangles[np.minimum(which, len(volume) - 1)]
    return np.einsum("nc,ncx->nx", weights[:, :3], tetrahedra) + weights[:, 3:] * centre


def _reachable(points: FloatArray, depth: FloatArray, hull: _Hull) -> BoolArray:
    """Which of the points, each the centre of a ball free of the mesh, the outside can reach.

    A ball that sticks out of the hull is reached; so is the centre of a ball within a
    reached ball, or the ball whose centre is within a reached one's.
    """
    if not len(points):
        return np.zeros(0, dtype=np.bool_)
    below = np.full(len(points), np.inf)
    for plane in hull.planes:
        np.minimum(below, -(points @ plane[:3] + plane[3]), out=below)
    distance, near = cKDTree(points).query(points, k=min(16, len(points)))
    near = np.asarray(near, dtype=np.int64).reshape(len(points), -1)
    distance = np.asarray(distance, dtype=np.float64).reshape(near.shape)
    first, which = np.nonzero(distance <= np.maximum(depth[:, None], depth[near]))
    links = coo_array(
        (np.ones(len(first), dtype=np.int8), (first, near[first, which])), shape=(len(points),) * 2
    )
    room = np.asarray(connected_components(links, directed=False)[1], dtype=np.int64)
    return np.isin(room, room[below < depth])


def _divided(piece: _Piece, snap: float) -> list[_Piece]:
    """The two parts of the piece at the best of the planes tried; the piece if there is none."""
    corners, index = np.unique(piece.triangles.reshape(-1, 3), axis=0, return_inverse=True)
    index = index.reshape(-1, 3)
    edges = np.concatenate([index[:, [0, 1]], index[:, [1, 2]], index[:, [2, 0]]])
    edges = np.unique(np.sort(edges, axis=1), axis=0)
    planes = _planes(piece, corners)
    if not len(planes):
        return [piece]
    few = slice(None, None, 1 + len(piece.wrong.depth) // 1500)
    wrong = _Outside(piece.wrong.points[few], piece.wrong.depth[few])
    costs = [_cost(corners, edges, plane, snap, wrong) for plane in planes]
    sides = _clipped(piece.triangles, planes[int(np.argmin(costs))], snap)
    hulls = [_hull(side.reshape(-1, 3)) for side in sides]
    return [_Piece(s, h, piece.wrong.within(h)) for s, h in zip(sides, hulls, strict=True)]


def _planes(piece: _Piece, corners: FloatArray) -> FloatArray:
    """Planes worth a cut, shape (c, 4), n x = o: of large faces, and swept through the wrong."""
    a, b, c = np.moveaxis(piece.triangles, 1, 0)
    cross = np.cross(b - a, c - a)
    area = np.linalg.norm(cross, axis=1)
    proper = area > 1e-14
    normal = cross[proper] / area[proper, None]
    planes = np.column_stack([normal, np.einsum("ij,ij->i", normal, a[proper])])
    size = float(np.ptp(corners, axis=0).max())
    bins = np.round(planes * np.array([50.0, 50.0, 50.0, 500.0 / size])).astype(np.int64)
    _, first, face = np.unique(bins, axis=0, return_index=True, return_inverse=True)
    order = np.argsort(-np.bincount(face.ravel(), weights=area[proper]), kind="stable")
    planes = planes[first[order[:_FACE_PLANES]]]
    principal = np.linalg.svd(corners - corners.mean(axis=0), full_matrices=False)[2]
    normals = np.concatenate([np.eye(3), principal, planes[:_FACE_NORMALS, :3]])
    along = piece.wrong.points @ normals.T
    offsets = np.linspace(along.min(axis=0), along.max(axis=0), _OFFSETS, axis=1)
    swept = np.column_stack([np.repeat(normals, _OFFSETS, axis=0), offsets.ravel()])
    planes = np.concatenate([planes, swept])
    height = corners @ planes[:, :3].T - planes[:, 3]
    return planes[(height.min(axis=0) < -1e-3 * size) & (height.max(axis=0) > 1e-3 * size)]


def _cost(
    corners: FloatArray, edges: NDArray[np.int64], plane: FloatArray, snap: float, wrong: _Outside
) -> float:
    """What the two parts of a cut piece still hold of the wrong points, by depth."""
    height = corners @ plane[:3] - plane[3]
    height[np.abs(height) <= snap] = 0.0
    start, end = edges[height[edges[:, 0]] * height[edges[:, 1]] < 0.0].T
    share = (height[start] / (height[start] - height[end]))[:, None]
    rim = corners[start] * (1.0 - share) + corners[end] * share
    cost = 0.0
    for side in (corners[height <= 0.0], corners[height >= 0.0]):
        hull = _hull(_extremes(np.concatenate([side, rim])))
        cost += float(wrong.depth[hull.holds(wrong.points)].sum()) ** 1.5
    return cost


def _extremes(points: FloatArray) -> FloatArray:
    """The points that are outermost along 200 directions, of many: nearly their hull."""
    if len(points) <= 250:
        return points
    number = np.arange(200) + 0.5
    z, angle = 1.0 - number / 100.0, np.pi * (1.0 + math.sqrt(5.0)) * number
    radius = np.sqrt(1.0 - z * z)
    directions = np.stack([radius * np.cos(angle), radius * np.sin(angle), z])
    return points[np.unique(np.argmax(points @ directions, axis=0))]


def _clipped(triangles: FloatArray, plane: FloatArray, snap: float) -> list[FloatArray]:
    """Triangles, shape (m, 3, 3), behind and before a plane; those across it are cut.

    A triangle in the plane goes behind when it faces along the plane's normal: there is the
    solid that it bounds.
    """
    height = triangles @ plane[:3] - plane[3]
    height[np.abs(height) <= snap] = 0.0
    side = np.sign(height)
    behind, before = (side <= 0.0).all(axis=1), (side >= 0.0).all(axis=1)
    a, b, c = np.moveaxis(triangles, 1, 0)
    along = np.cross(b - a, c - a) @ plane[:3] >= 0.0
    behind, before = behind & (~before | along), before & ~(behind & along)
    across = ~(behind | before)
    triangles, height, side = triangles[across], height[across], side[across]
    lone = np.where(side.sum(axis=1) > 0.0, side.argmin(axis=1), side.argmax(axis=1))
    turn = (lone[:, None] + np.arange(3)) % 3
    a, b, c = np.moveaxis(np.take_along_axis(triangles, turn[:, :, None], axis=1), 1, 0)
    high = np.take_along_axis(height, turn, axis=1)[:, :, None]
    on_ab = a + high[:, 0] / (high[:, 0] - high[:, 1]) * (b - a)
    on_ac = a + high[:, 0] / (high[:, 0] - high[:, 2]) * (c - a)
    tip = np.stack([a, on_ab, on_ac], axis=1)
    base = np.concatenate([np.stack([on_ab, b, c], axis=1), np.stack([on_ab, c, on_ac], axis=1)])
    up = high[:, 0, 0] > 0.0
    twice = np.tile(up, 2)
    whole = (behind, before)
    return [[], []]
