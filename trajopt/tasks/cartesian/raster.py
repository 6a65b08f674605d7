"""Parallel rows over a face of a mesh, as curves of a tool."""

from collections import deque
from collections.abc import Iterator

import numpy as np
from numpy.typing import ArrayLike

from trajopt.tasks.cartesian.curves import polyline
from trajopt.values.arrays import Bools, Floats, Ints, direction_of, floats, not_negative, positive
from trajopt.values.curve import Curve
from trajopt.values.errors import ProblemError
from trajopt.values.errors.arguments import checked
from trajopt.values.placement import IDENTITY, Placement, PlacementLike, as_placement
from trajopt.values.shapes.mesh import Mesh

BEND = np.deg2rad(20.0)
"""Default largest angle between neighbouring triangles of a face [rad]: chamfers and edges have more."""
EDGE = 1e-9
"""Distance of a row from an edge along it, so that it crosses triangles [m]."""
MEETING = 1e-7
"""Ends of pieces of a row nearer than this meet [m]."""
STRAIGHT = 1e-9
"""Points nearer than this to the line between their neighbours, with equal normals, are left out [m]."""


@checked
def raster(
    mesh: Mesh,
    face: int,
    spacing: float,
    *,
    along: ArrayLike | None = None,
    margin: float = 0.0,
    bend: float = BEND,
    at: PlacementLike = IDENTITY,
) -> tuple[Curve, ...]:
    """Return parallel rows over a face of a mesh, in turn forwards and backwards.

    The face is grown from one triangle to its neighbours as far as the surface is smooth. A row that meets a
    hole is split. At each point z of the tool's placement points into the surface, and x along the first row.

    Args:
        face: Index of a triangle of the face.
        spacing: Distance of the rows [m].
        along: Direction of the rows in the mesh's frame, shape (3,); the longest extent of the face if None.
        margin: Distance of the first and last row, and of the ends of rows, from the edge, along the rows and
            across [m].
        bend: Largest angle between neighbouring triangles [rad].
        at: Placement of the mesh in the frame of the curves.

    Raises:
        ProblemError: If there is no such triangle, or the face is too small for a row.
    """
    triangles = mesh.triangles
    if not 0 <= face < len(triangles):
        raise ProblemError(f"face must be the index of one of {len(triangles)} triangles, is {face}")
    where = as_placement("at", at)
    positive("spacing", spacing)
    not_negative("margin", margin)
    normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    part = _grown(mesh, normals, face, positive("bend", bend))
    corners, normals = triangles[part], normals[part]
    row, across = _axes(corners, normals, along)
    sides = corners @ across
    begin, end = float(sides.min()) + margin, float(sides.max()) - margin
    count = int(np.floor((end - begin) / spacing + 1e-9)) + 1
    inset = 0.5 * (end - begin - (count - 1) * spacing)
    curves: list[Curve] = []
    for place in range(max(count, 0)):
        level = np.clip(begin + inset + place * spacing, sides.min() + EDGE, sides.max() - EDGE)
        pieces = _pieces(corners, normals, row, sides - level)
        poses = [found for piece in pieces if (found := _poses(*piece, row, margin))]
        if place % 2:
            poses = [each[::-1] for each in poses[::-1]]
        curves += [polyline([where * pose for pose in each]) for each in poses]
    if not curves:
        raise ProblemError(
            f"the face has no room for a row with a margin of {margin:g} m: give a smaller one"
        )
    return tuple(curves)


def _grown(mesh: Mesh, normals: Floats, face: int, bend: float) -> Ints:
    owners: dict[tuple[int, int], list[int]] = {}
    for index, corners in enumerate(mesh.faces.tolist()):
        for a, b in ((0, 1), (1, 2), (2, 0)):
            edge = min(corners[a], corners[b]), max(corners[a], corners[b])
            owners.setdefault(edge, []).append(index)
    neighbours: dict[int, set[int]] = {}
    for sharing in owners.values():
        for index in sharing:
            neighbours.setdefault(index, set()).update(sharing)
    taken, waiting = {face}, deque([face])
    while waiting:
        here = waiting.popleft()
        for other in neighbours[here] - taken:
            if normals[here] @ normals[other] >= np.cos(bend):
                taken.add(other)
                waiting.append(other)
    return np.array(sorted(taken))


def _axes(corners: Floats, normals: Floats, along: ArrayLike | None) -> tuple[Floats, Floats]:
    normal = normals.mean(axis=0)
    if along is None:
        direction = np.linalg.eigh(_second_moment(corners))[1][:, -1]
    else:
        direction = direction_of("along", along)
    row = direction - (direction @ normal) * normal / (normal @ normal)
    length = float(np.linalg.norm(row))
    if length < 1e-6:
        raise ProblemError("along must not be the normal of the face")
    row = row / length
    across = np.cross(normal, row)
    return row, across / np.linalg.norm(across)


def _second_moment(corners: Floats) -> Floats:
    """Return the integral of x x^T over triangles about their common centroid, shape (3, 3) [m^4].

    Over one triangle it is its area / 12 times the sum of x x^T over its corners and of s s^T, with the sum s
    of its corners.
    """
    areas = 0.5 * np.linalg.norm(
        np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
    )
    centroid = areas @ corners.mean(axis=1) / areas.sum()
    off = corners - centroid
    total = off.sum(axis=1)
    moment = np.einsum("m,mki,mkj->ij", areas, off, off) + np.einsum("m,mi,mj->ij", areas, total, total)
    return moment / 12.0


def _pieces(corners: Floats, normals: Floats, row: Floats, sides: Floats) -> Iterator[tuple[Floats, Floats]]:
    """Yield the connected pieces of a row: points in order, shape (k, 3), and a normal at each."""
    segments: list[tuple[float, float, Floats, Floats, Floats]] = []
    for triangle, side, normal in zip(corners, sides, normals, strict=True):
        cut = _cut(triangle, side)
        if len(cut) == 2:
            places = cut @ row
            first, last = (0, 1) if places[0] <= places[1] else (1, 0)
            segments.append((float(places[first]), float(places[last]), cut[first], cut[last], normal))
    segments.sort(key=lambda one: (one[0], one[1]))
    points: list[Floats] = []
    directions: list[Floats] = []
    reached = -np.inf
    for begin, end, first, last, normal in segments:
        if begin > reached + MEETING and points:
            yield np.array(points), np.array(directions)
            points, directions = [], []
        if not points:
            points, directions = [first], [normal]
        elif end > reached:
            directions[-1] = directions[-1] + normal
        if end > reached:
            points.append(last)
            directions.append(normal)
            reached = end
    if points:
        yield np.array(points), np.array(directions)


def _cut(triangle: Floats, side: Floats) -> Floats:
    found: list[Floats] = []
    for a, b in ((0, 1), (1, 2), (2, 0)):
        if (side[a] < 0.0) != (side[b] < 0.0):
            share = side[a] / (side[a] - side[b])
            found.append(triangle[a] + share * (triangle[b] - triangle[a]))
    return np.array(found).reshape(-1, 3)


def _poses(points: Floats, directions: Floats, row: Floats, margin: float) -> list[Placement]:
    places = points @ row
    begin, end = float(places[0]) + margin, float(places[-1]) - margin
    if end - begin <= MEETING:
        return []
    inner = (places > begin + MEETING) & (places < end - MEETING)
    stations = np.concatenate(([begin], places[inner], [end]))
    at = _interpolated(stations, places, points)
    normals = _interpolated(stations, places, directions)
    normals = normals / np.linalg.norm(normals, axis=1)[:, None]
    kept = _bends(at, normals)
    return [_into(point, normal, row) for point, normal in zip(at[kept], normals[kept], strict=True)]


def _interpolated(stations: Floats, places: Floats, values: Floats) -> Floats:
    columns = [np.interp(stations, places, np.array(column)) for column in values.T]
    return np.stack(columns, axis=1)


def _bends(points: Floats, normals: Floats) -> Bools:
    before, after = points[:-2], points[2:]
    chords = (after - before) / np.linalg.norm(after - before, axis=1)[:, None]
    off = points[1:-1] - before
    off -= (off * chords).sum(axis=1)[:, None] * chords
    turns = np.abs(np.stack((normals[1:-1] - normals[:-2], normals[1:-1] - normals[2:])))
    bent = (np.linalg.norm(off, axis=1) > STRAIGHT) | (turns.max(axis=(0, 2)) > STRAIGHT)
    return np.concatenate(((True,), bent, (True,)))


def _into(point: Floats, normal: Floats, row: Floats) -> Placement:
    x = row - (row @ normal) * normal
    x = x / np.linalg.norm(x)
    axes = np.stack((x, np.cross(-normal, x), -normal), axis=1)
    return Placement(floats("axes", axes, (3, 3)), floats("point", point, (3,)))
