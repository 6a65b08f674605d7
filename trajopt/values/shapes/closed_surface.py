"""The solid side of a mesh: the closed part of its surface, with outward faces."""

from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from trajopt.values.arrays import Bools, Floats, Ints, readonly
from trajopt.values.cached import cached_per_value
from trajopt.values.errors import ShapeError
from trajopt.values.shapes.mesh import Mesh, components
from trajopt.values.shapes.shapes import Convex, Shape, convex

HOLE = 5e-3
"""Narrower holes leave a surface closed [m]."""


@dataclass(frozen=True, eq=False)
class ClosedSurface:
    """The faces of a mesh that bound solids; open sheets have no inside and are left out.

    Cavities count as outside if their faces point into them. A part with inconsistent faces counts as its
    convex hull.

    Attributes:
        triangles: Corners, counter-clockwise seen from outside, shape (k, 3, 3) [m], read-only.
        twisted: Number of closed parts that count as their hulls.
    """

    triangles: Floats
    parts: int
    open: int
    twisted: int

    @cached_property
    def note(self) -> str:
        found: list[str] = []
        if self.open:
            which = "it is open" if self.open == self.parts else f"{self.open} of {self.parts} parts are open"
            found.append(f"{which} and so without an inside")
        if self.twisted:
            which = f"{self.twisted} of {self.parts} parts"
            found.append(f"the faces of {which} disagree on which side is out: their hulls count as solid")
        return "; ".join(found)


@cached_per_value
def closed_surface(mesh: Mesh) -> ClosedSurface:
    """Return the closed part of a mesh's surface; computed once for each mesh."""
    part, closed = mesh.parts(HOLE)
    twisted = _twisted(mesh.faces, part, len(closed)) & closed
    whole = (closed & ~twisted)[part]
    outward = _outward(mesh.vertices, mesh.faces[whole].astype(np.int64), part[whole])
    solids = [mesh.vertices[outward]]
    for number in np.flatnonzero(twisted).tolist():
        with suppress(ShapeError):  # a flat one has no inside
            hull = convex(mesh.vertices[np.unique(mesh.faces[part == number])])
            solids.append(hull.vertices[hull.faces])
    return ClosedSurface(
        triangles=readonly(np.concatenate(solids)),
        parts=len(closed),
        open=int((~closed).sum()),
        twisted=int(twisted.sum()),
    )


def part_points(shape: Shape) -> Floats:
    """Return a point of each connected part of a shape, on its surface or inside, (p, 3) [m]."""
    match shape:
        case Mesh():
            faces = shape.faces.astype(np.int64)
            part = components(len(shape.vertices), np.tile(faces[:, 0], 2), faces[:, 1:].T.reshape(-1))
            return shape.vertices[np.unique(part, return_index=True)[1]]
        case Convex():
            return shape.vertices.mean(axis=0)[None]
        case _:
            return np.zeros((1, 3))


def _twisted(faces: NDArray[np.int32], part: Ints, parts: int) -> Bools:
    directed = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    way = np.where(directed[:, 0] < directed[:, 1], 1, -1)
    _, edge, count = np.unique(np.sort(directed, axis=1), axis=0, return_inverse=True, return_counts=True)
    edge = edge.ravel()
    wrong = (np.bincount(edge, weights=way) != 0.0) & (count % 2 == 0)
    twisted = np.zeros(parts, dtype=np.bool_)
    twisted[np.tile(part, 3)[wrong[edge]]] = True
    return twisted


def _outward(vertices: Floats, faces: Ints, part: Ints) -> Ints:
    if not len(faces):
        return faces
    a, b, c = np.moveaxis(vertices[faces] - vertices.mean(axis=0), 1, 0)
    volume = np.bincount(part, weights=np.einsum("ij,ij->i", a, np.cross(b, c)))
    if volume.sum() < 0.0:
        faces, volume = faces[:, ::-1], -volume
    solid = (volume > 0.0)[part]
    if solid.all() or not solid.any():
        return faces
    around = Mesh(vertices, faces[solid].astype(np.int32))
    for number in np.flatnonzero(volume < 0.0).tolist():
        mine = part == number
        if not around.contains(vertices[np.unique(faces[mine])], opening=HOLE).all():
            faces = np.where(mine[:, None], faces[:, ::-1], faces)
    return faces
