"""Triangle meshes: containment, distance and connected parts."""

import io
import json
from dataclasses import dataclass
from pathlib import Path

import coal
import numpy as np
from numpy.typing import NDArray

from trajopt.values.arrays import Bools, Floats, Ints, Value, floats, indices, number, readonly
from trajopt.values.arrays import path as path_of
from trajopt.values.cached import Arrays, cached_arrays
from trajopt.values.documents.files import is_file
from trajopt.values.errors import MeshFileError, ShapeError, shown
from trajopt.values.errors.arguments import checked
from trajopt.values.processes import ProcessRefused, answer_of

LARGEST = 1e6
"""Largest coordinate of a vertex [m]; its fourth power does not overflow."""
_CELLS_AT_ONCE = 200_000  # cells of triangles that the ray count holds in memory


@dataclass(frozen=True, eq=False)
class Mesh(Value):
    """Triangles: of a file (`load_mesh`), or of arrays.

    On construction coincident vertices are merged; faces without area, and vertices that no face
    uses, are dropped. The order of the rest is kept.

    Attributes:
        vertices: Corners, shape (n, 3) [m], read-only.
        faces: Indices of the vertices of each triangle, counter-clockwise seen from outside, shape
            (m, 3), int32, read-only.

    Raises:
        ShapeError: If a vertex is not three finite numbers of at most 1e6 m, or a face is not three indices
            of vertices.
    """

    vertices: Floats
    faces: NDArray[np.int32]

    def __post_init__(self) -> None:
        vertices = floats("Mesh.vertices", self.vertices, (None, 3)) + 0.0  # no negative zeros
        if (largest := float(np.abs(vertices).max(initial=0.0))) > LARGEST:
            raise ShapeError("Mesh.vertices", f"has a coordinate of {largest:g} m, more than {LARGEST:g} m")
        faces = indices("Mesh.faces", self.faces, 3, len(vertices))
        _, first, inverse = np.unique(vertices, axis=0, return_index=True, return_inverse=True)
        faces = first[inverse.ravel()][faces]
        sides = np.diff(vertices[faces[:, [0, 1, 2, 0]]], axis=1)
        double_area = np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1)
        faces = faces[double_area > 1e-14 * np.sum(sides * sides, axis=(1, 2))]
        used, faces = np.unique(faces, return_inverse=True)
        faces = faces.reshape(-1, 3).astype(np.int32)
        faces.flags.writeable = False
        object.__setattr__(self, "vertices", readonly(vertices[used]))
        object.__setattr__(self, "faces", faces)

    @property
    def triangles(self) -> Floats:
        """Corners of the faces, shape (m, 3, 3) [m]: face, corner, coordinate."""
        return self.vertices[self.faces]

    @property
    def volume(self) -> float:
        """Signed volume of a closed mesh [m^3], positive when its faces point outward.

        Where parts overlap, the overlap counts once for each.
        """
        a, b, c = np.moveaxis(self.triangles, 1, 0)
        return float(np.sum(a * np.cross(b, c))) / 6.0

    @property
    def is_closed(self) -> bool:
        """Whether every edge is shared by exactly two faces."""
        _, count = np.unique(np.sort(_edges(self.faces), axis=1), axis=0, return_counts=True)
        return len(self.faces) > 0 and bool(np.all(count == 2))

    def contains(self, points: Floats, *, opening: float = 1e-6) -> Bools:
        """Return the points (k, 3) [m] that lie in the solid: inside at least one closed part, shape (k,).

        The even-odd rule along two generic directions decides, and a third if these differ. Overlapping parts
        and wrongly oriented faces are harmless; a part within a part is not a cavity.

        Args:
            opening: Narrower holes [m] leave a part closed.
        """
        points = floats("points", points, (None, 3))
        part, closed = self.parts(opening)
        solid = closed[part]
        triangles, part = self.triangles[solid], part[solid]
        frame = _generic_frame()
        inside = _inside_along(frame, points, triangles, part)
        doubt = inside != _inside_along(frame[[1, 2, 0]], points, triangles, part)
        inside[doubt] = _inside_along(frame[[2, 0, 1]], points[doubt], triangles, part)
        return inside

    def distance(self, points: Floats) -> Floats:
        """Return the distance of points (k, 3) to the surface, positive on both sides, shape (k,) [m]."""
        points = floats("points", points, (None, 3))
        surface = coal.BVHModelOBBRSS()
        surface.beginModel(len(self.faces), len(self.vertices))
        surface.addVertices(np.array(self.vertices))
        surface.addTriangles(self.faces.astype(np.int64))
        surface.endModel()
        dot, here, there = coal.Sphere(1e-12), coal.Transform3s(), coal.Transform3s()
        request, result = coal.DistanceRequest(), coal.DistanceResult()
        distances = np.empty(len(points))
        for index, point in enumerate(points):
            there.setTranslation(point)
            result.clear()
            distances[index] = coal.distance(surface, here, dot, there, request, result)
        return np.maximum(distances, 0.0)

    def parts(self, opening: float) -> tuple[Ints, Bools]:
        """Return the part of each face (m,), sets joined by edges, and whether each is closed (parts,)."""
        opening = number("opening", opening, infinite=True)
        edges, face = _edges(self.faces), np.tile(np.arange(len(self.faces)), 3)
        _, edge, count = np.unique(np.sort(edges, axis=1), axis=0, return_inverse=True, return_counts=True)
        edge = edge.ravel()
        order = np.argsort(edge, kind="stable")
        same = edge[order][1:] == edge[order][:-1]
        part = components(len(self.faces), face[order][1:][same], face[order][:-1][same])
        closed = np.ones(part.max(initial=-1) + 1, dtype=np.bool_)
        odd = count[edge] % 2 == 1
        rim, owner = edges[odd], part[face[odd]]
        loop = components(len(self.vertices), rim[:, 0], rim[:, 1])[rim[:, 0]]
        for which in np.unique(loop):
            if _width(self.vertices[rim[loop == which]]) > opening:
                closed[owner[loop == which]] = False
        return part, closed


def components(size: int, a: Ints, b: Ints) -> Ints:
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    links = coo_array((np.ones(len(a), dtype=np.int8), (a, b)), shape=(size, size))
    return np.asarray(connected_components(links, directed=False)[1], dtype=np.int64)


def _edges(faces: NDArray[np.int32]) -> Ints:
    return np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]).astype(np.int64)


def _width(rim: Floats) -> float:
    a, b = rim[:, 0] - rim[0, 0], rim[:, 1] - rim[0, 0]
    area = 0.5 * float(np.linalg.norm(np.cross(a, b).sum(axis=0)))
    return 2.0 * area / float(np.linalg.norm(np.ptp(rim.reshape(-1, 3), axis=0)))


def _generic_frame() -> Floats:
    (ca, cb), (sa, sb) = np.cos([0.7391, 0.4127]), np.sin([0.7391, 0.4127])
    turn = np.array([[ca, -sa, 0.0], [sa, ca, 0.0], [0.0, 0.0, 1.0]])
    return turn @ np.array([[1.0, 0.0, 0.0], [0.0, cb, -sb], [0.0, sb, cb]])


def _inside_along(frame: Floats, points: Floats, triangles: Floats, part: Ints) -> Bools:
    inside = np.zeros(len(points), dtype=np.bool_)
    if not len(points) or not len(triangles):
        return inside
    p, t, parts = points @ frame.T, triangles @ frame.T, int(part.max()) + 1
    side = max(1, int(np.sqrt(len(p)) / 1.5))
    low, step = p[:, :2].min(axis=0), (np.ptp(p[:, :2], axis=0) + 1e-12) * (1.0 + 1e-9) / side
    cell = ((p[:, :2] - low) / step).astype(np.int64) @ np.array([side, 1])
    order = np.argsort(cell, kind="stable")
    start = np.searchsorted(cell[order], np.arange(side * side + 1))
    begin = np.clip(np.floor((t[:, :, :2].min(axis=1) - low) / step), 0, side).astype(np.int64)
    end = np.clip(np.floor((t[:, :, :2].max(axis=1) - low) / step), -1, side - 1).astype(np.int64)
    span = np.maximum(end - begin + 1, 0)
    block = np.cumsum(span[:, 0] * span[:, 1]) // _CELLS_AT_ONCE
    hits: list[Ints] = []
    for chosen in np.split(np.arange(len(t)), np.flatnonzero(np.diff(block)) + 1):
        face, local = _repeated(chosen, span[chosen, 0] * span[chosen, 1])
        cell = (begin[face] + np.stack(np.divmod(local, span[face, 1]), axis=1)) @ np.array([side, 1])
        meeting, local = _repeated(np.arange(len(cell)), start[cell + 1] - start[cell])
        face, index = face[meeting], order[start[cell[meeting]] + local]
        hits.append((index * parts + part[face])[_is_above(t[face], p[index])])
    key, count = np.unique(np.concatenate(hits), return_counts=True)
    inside[key[count % 2 == 1] // parts] = True
    return inside


def _repeated(items: Ints, counts: Ints) -> tuple[Ints, Ints]:
    return np.repeat(items, counts), np.arange(int(counts.sum())) - np.repeat(
        np.cumsum(counts) - counts, counts
    )


def _is_above(triangles: Floats, points: Floats) -> Bools:
    met, heights, _ = crossings(triangles, points)
    above = np.zeros(len(points), dtype=np.bool_)
    above[met] = heights > points[met, 2]
    return above


def crossings(triangles: Floats, points: Floats) -> tuple[Ints, Floats, Floats]:
    """Return the triangles that lines along z meet inside, and at which heights.

    Args:
        triangles: Corners, shape (m, 3, 3) [m].
        points: On the line of each triangle, shape (m, 2 or 3) [m], or one for all of them.

    Returns:
        Indices (k,), heights (k,) [m], and double areas seen along the line, (k,) [m^2], positive if the
        triangle is counter-clockwise seen from above.
    """
    x, y = (triangles[:, :, axis] - points[:, None, axis] for axis in (0, 1))
    weight = np.roll(x, -1, axis=1) * np.roll(y, -2, axis=1) - np.roll(x, -2, axis=1) * np.roll(y, -1, axis=1)
    met = np.flatnonzero((weight > 0.0).all(axis=1) | (weight < 0.0).all(axis=1))
    weight = weight[met]
    areas = weight.sum(axis=1)
    return met, (weight * triangles[met, :, 2]).sum(axis=1) / areas, areas


ALONE = frozenset((".stl", ".dae", ".obj", ".ply", ".off"))
"""Suffixes of self-contained files; others, such as .gltf, may refer to more files."""
_CHILD, _KEPT = Path(__file__).with_name("mesh_child.py"), ("vertices", "faces")


@checked
def load_mesh(path: Path | str, scale: float | tuple[float, float, float] = 1.0) -> Mesh:
    """Read a mesh file.

    Args:
        path: A file whose suffix assimp knows: .dae, .stl, .obj, ...
        scale: One factor, such as 0.001 for a file in millimetres, or factors along x, y, z, as in a URDF. If
            they mirror, faces are turned to point outward.

    Returns:
        All nodes of the file in one frame; in metres if file and scale are consistent.

    Raises:
        MeshFileError: If the file is missing or unreadable, has no triangle, or takes more than 30 s of CPU
            time or 4 GB to read.
    """
    path = path_of("path", path)
    factors = np.array(np.broadcast_to(np.asarray(scale, dtype=np.float64), 3))
    if not factors.all():
        raise MeshFileError(str(path), f"its scale must not be 0, is {shown(factors.tolist())}")
    if not is_file(path):
        raise MeshFileError(str(path), "no such file")
    vertices, faces = _triangles(path, factors)
    if np.prod(np.sign(factors)) < 0:
        faces = faces[:, ::-1]
    if not np.isfinite(vertices).all():
        raise MeshFileError(str(path), "it has vertices that are not finite")
    try:
        mesh = Mesh(vertices, faces)
    except ShapeError as error:
        raise MeshFileError(str(path), str(error)) from error
    if not len(mesh.faces):
        raise MeshFileError(str(path), "it holds no triangle")
    return mesh


def _triangles(path: Path, factors: Floats) -> tuple[Floats, NDArray[np.int32]]:
    def read() -> Arrays:
        request = json.dumps({"file": str(path.absolute()), "scale": factors.tolist()})
        try:
            answer = answer_of(_CHILD, request.encode())
        except ProcessRefused as error:
            raise MeshFileError(str(path), str(error)) from error
        with np.load(io.BytesIO(answer), allow_pickle=False) as arrays:
            return {name: arrays[name] for name in _KEPT}

    if path.suffix.lower() in ALONE:
        key = (path.suffix.lower().encode(), factors.tobytes(), path.read_bytes())
        arrays = cached_arrays("mesh", key, _KEPT, read)
    else:
        arrays = read()
    return arrays["vertices"], arrays["faces"]
