"""Triangle meshes: read from a file, and asked whether and how far points are outside.

Coal's own loader (assimp) reads the files, so a mesh has exactly the coordinates that
Pinocchio gives to the same file: DAE, STL (binary, ascii), OBJ and what else assimp knows.
In a DAE file the transforms of the nodes count, while `unit` and `up_axis` do not: robot
descriptions rely on that, and MoveIt does the same. Such a file is scaled in the URDF.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TypeAlias

import coal
import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from trajopt.errors import MeshFileError

FloatArray: TypeAlias = NDArray[np.float64]
IntArray: TypeAlias = NDArray[np.int32]
IndexArray: TypeAlias = NDArray[np.int64]
BoolArray: TypeAlias = NDArray[np.bool_]

_TRIANGLES_AT_ONCE = 200_000  # grid cells of triangles held in memory by the ray count


@dataclass(frozen=True, eq=False)
class Mesh:
    """Triangle mesh in the frame and unit of its file.

    On construction coincident vertices are merged, and faces that use a vertex twice and
    vertices that no face uses are dropped; the order of the rest is kept.

    Attributes:
        vertices: Corners, shape (n, 3), [m], read-only.
        faces: Vertex indices of the triangles, shape (m, 3), counter-clockwise seen from
            outside, read-only.
    """

    vertices: FloatArray
    faces: IntArray

    def __post_init__(self) -> None:
        vertices = np.array(self.vertices, dtype=np.float64).reshape(-1, 3) + 0.0
        faces = np.array(self.faces, dtype=np.int64).reshape(-1, 3)
        if not np.isfinite(vertices).all():
            raise ValueError("a mesh has vertices that are not finite")
        if len(faces) and (faces.min() < 0 or faces.max() >= len(vertices)):
            raise ValueError(f"a mesh of {len(vertices)} vertices has faces that index others")
        faces, first = _merged(vertices, faces)
        object.__setattr__(self, "vertices", _read_only(vertices[first]))
        object.__setattr__(self, "faces", _read_only(faces.astype(np.int32)))

    @property
    def triangles(self) -> FloatArray:
        """Corners of every face, shape (m, 3, 3): face, corner, coordinate, [m]."""
        return self.vertices[self.faces]

    @property
    def volume(self) -> float:
        """Signed volume by the divergence theorem, [m^3].

        Meant for closed surfaces: positive when the faces point outwards. Where parts
        overlap, the overlap counts once for each.
        """
        a, b, c = np.moveaxis(self.triangles, 1, 0)
        return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0)

    @property
    def is_closed(self) -> bool:
        """Whether every edge is shared by exactly two faces."""
        _, count = np.unique(np.sort(_edges(self.faces), axis=1), axis=0, return_counts=True)
        return len(self.faces) > 0 and bool(np.all(count == 2))

    def contains(self, points: FloatArray, *, opening: float = 0.0) -> BoolArray:
        """Tell which points lie in the solid: inside at least one part that is closed.

        A part is a set of faces joined by edges. Its inside is found by the even-odd rule,
        along two generic directions and a third where those differ, so neither overlapping
        parts nor wrongly oriented faces matter, and a cavity inside a part is solid.

        Args:
            points: Shape (k, 3), frame of the mesh, [m].
            opening: A part is closed, too, when its holes are narrower than this, [m].

        Returns:
            Shape (k,). Parts that are open contain nothing.
        """
        part, closed = self._parts(opening)
        solid = closed[part]
        if not solid.any() or not len(points):
            return np.zeros(len(points), dtype=np.bool_)
        triangles, part = self.triangles[solid], part[solid]
        frame = _generic_frame()
        inside = _inside_along(frame, points, triangles, part)
        differs = inside != _inside_along(frame[[1, 2, 0]], points, triangles, part)
        inside[differs] = _inside_along(frame[[2, 0, 1]], points[differs], triangles, part)
        return inside

    def distance(self, points: FloatArray) -> FloatArray:
        """Distance from points to the nearest face, zero on it, positive on both sides.

        Args:
            points: Shape (k, 3), frame of the mesh, [m].

        Returns:
            Shape (k,), [m].
        """
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

    def _parts(self, opening: float) -> tuple[IndexArray, BoolArray]:
        """Part of every face, shape (m,), and whether each part is closed, shape (parts,)."""
        edges, face = _edges(self.faces), np.tile(np.arange(len(self.faces)), 3)
        _, edge, count = np.unique(np.sort(edges, axis=1), axis=0, return_inverse=True, return_counts=True)
        edge = edge.ravel()
        order = np.argsort(edge, kind="stable")
        same = edge[order][1:] == edge[order][:-1]
        part = _components(len(self.faces), face[order][1:][same], face[order][:-1][same])
        closed = np.ones(part.max(initial=-1) + 1, dtype=np.bool_)
        odd = count[edge] % 2 == 1
        rim, owner = edges[odd], part[face[odd]]
        loop = _components(len(self.vertices), rim[:, 0], rim[:, 1])[rim[:, 0]]
        for which in np.unique(loop):
            if _width(self.vertices[rim[loop == which]]) > opening:
                closed[owner[loop == which]] = False
        return part, closed


def load_mesh(path: Path, scale: tuple[float, float, float] = (1.0, 1.0, 1.0)) -> Mesh:
    """Read a mesh file.

    Args:
        path: File in a format of assimp, told by its suffix: .dae, .stl, .obj, ...
        scale: Factors along x, y, z, as in the URDF. Mirroring factors turn the faces, so
            that they still point outwards.

    Returns:
        The mesh, all nodes of the file in one frame, [m] when file and scale say so.

    Raises:
        MeshFileError: if the file is missing, unreadable, or without a triangle.
    """
    if not path.is_file():
        raise MeshFileError(str(path), "no such file")
    try:
        model = coal.MeshLoader().load(str(path), np.array(scale, dtype=np.float64))
    except (ValueError, RuntimeError) as error:
        raise MeshFileError(str(path), _reason(str(error))) from error
    vertices = np.array(model.vertices(), dtype=np.float64).reshape(-1, 3)
    corners = (model.tri_indices(face) for face in range(int(model.num_tris)))
    faces = np.array([(c[0], c[1], c[2]) for c in corners], dtype=np.int64).reshape(-1, 3)
    if np.prod(np.sign(scale)) < 0:
        faces = faces[:, ::-1]
    try:
        mesh = Mesh(vertices, faces.astype(np.int32))
    except ValueError as error:
        raise MeshFileError(str(path), str(error)) from error
    if not len(mesh.faces):
        raise MeshFileError(str(path), "it has no triangle")
    return mesh


def _reason(message: str) -> str:
    """The sentence of assimp in an error of coal: place, resource, sentence, hint."""
    lines = [line.strip() for line in message.rsplit("message:", maxsplit=1)[-1].splitlines()]
    told = [line for line in lines if line and not line.startswith(("Could not load", "Hint"))]
    return told[0] if told else message


def _read_only(array: NDArray[np.generic]) -> NDArray[np.generic]:
    array.setflags(write=False)
    return array


def _merged(vertices: FloatArray, faces: IndexArray) -> tuple[IndexArray, IndexArray]:
    """Faces of the mesh without repeated vertices, and the index of each vertex kept."""
    _, first, inverse = np.unique(vertices, axis=0, return_index=True, return_inverse=True)
    faces = first[inverse.ravel()][faces]
    a, b, c = faces.T
    faces = faces[(a != b) & (b != c) & (c != a)]
    kept, renamed = np.unique(faces, return_inverse=True)
    return renamed.reshape(-1, 3).astype(np.int64), kept.astype(np.int64)


def _edges(faces: NDArray[np.integer]) -> NDArray[np.integer]:
    """Directed edges of all faces, shape (3 m, 2): all first edges, all second, all third."""
    return np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])


def _components(size: int, a: NDArray[np.integer], b: NDArray[np.integer]) -> IndexArray:
    """Number of the connected component of each of `size` nodes, given links a - b."""
    links = coo_array((np.ones(len(a), dtype=np.int8), (a, b)), shape=(size, size))
    return np.asarray(connected_components(links, directed=False)[1], dtype=np.int64)


def _width(rim: FloatArray) -> float:
    """Width of the hole that a rim of edges, shape (k, 2, 3), runs around: area / half length."""
    a, b = rim[:, 0] - rim[0, 0], rim[:, 1] - rim[0, 0]
    area = 0.5 * np.linalg.norm(np.cross(a, b).sum(axis=0))
    return float(2.0 * area / np.linalg.norm(np.ptp(rim.reshape(-1, 3), axis=0)))


def _generic_frame() -> FloatArray:
    """Rotation, shape (3, 3), whose axes are along no edge that a designer would draw."""
    (ca, cb), (sa, sb) = np.cos([0.7391, 0.4127]), np.sin([0.7391, 0.4127])
    turn = np.array([[ca, -sa, 0.0], [sa, ca, 0.0], [0.0, 0.0, 1.0]])
    return turn @ np.array([[1.0, 0.0, 0.0], [0.0, cb, -sb], [0.0, sb, cb]])


def _inside_along(
    frame: FloatArray, points: FloatArray, triangles: FloatArray, part: IndexArray
) -> BoolArray:
    """Which points have an odd number of faces of some part above them.

    Above is along the third axis of the frame. Points are sorted into the cells of a grid
    in the plane of the other two, and each triangle meets those in the cells it spans.
    """
    inside = np.zeros(len(points), dtype=np.bool_)
    if not len(points):
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
    block = np.cumsum(span[:, 0] * span[:, 1]) // _TRIANGLES_AT_ONCE
    hits: list[IndexArray] = []
    for chosen in np.split(np.arange(len(t)), np.flatnonzero(np.diff(block)) + 1):
        face, local = _expand(chosen, span[chosen, 0] * span[chosen, 1])
        x, y = begin[face, 0] + local // span[face, 1], begin[face, 1] + local % span[face, 1]
        cell = x * side + y
        face, local = _expand(face, start[cell + 1] - start[cell], start[cell])
        index = order[local]
        hits.append((index * parts + part[face])[_is_above(t[face], p[index])])
    key, count = np.unique(np.concatenate(hits), return_counts=True)
    inside[key[count % 2 == 1] // parts] = True
    return inside


def _expand(
    items: IndexArray, counts: IndexArray, begin: IndexArray | None = None
) -> tuple[IndexArray, IndexArray]:
    """Each item repeated `count` times, and the running numbers begin, begin + 1, ... of it."""
    number = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
    return np.repeat(items, counts), number if begin is None else number + np.repeat(begin, counts)


def _is_above(triangles: FloatArray, points: FloatArray) -> BoolArray:
    """Whether triangle i, shape (k, 3, 3), lies above point i, shape (k, 3), along z."""
    x, y = (triangles[:, :, axis] - points[:, None, axis] for axis in (0, 1))
    weight = np.roll(x, -1, axis=1) * np.roll(y, -2, axis=1)
    weight -= np.roll(x, -2, axis=1) * np.roll(y, -1, axis=1)
    within = (weight > 0.0).all(axis=1) | (weight < 0.0).all(axis=1)
    above = np.zeros(len(points), dtype=np.bool_)
    chosen = weight[within]
    height = np.einsum("ij,ij->i", chosen, triangles[within, :, 2]) / chosen.sum(axis=1)
    above[within] = height > points[within, 2]
    return above
