"""Triangles of surfaces: of any shape, and of the solid side of a mesh, with outward faces."""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from trajopt.values.arrays import Bools, Floats, Ints, readonly
from trajopt.values.cached import cached_per_value
from trajopt.values.errors import ShapeError
from trajopt.values.shapes.clouds import Points, Voxels, cloud_surface
from trajopt.values.shapes.mesh import Mesh, components
from trajopt.values.shapes.shapes import Box, Capsule, Cone, Convex, Cylinder, Plane, Shape, Sphere, convex

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


SECTORS = 32
PLANE_EDGE = 4.0
"""Edge of the square that represents a half-space [m]."""
PLANE_DEPTH = 0.002
"""Depth of that square below the surface, clear of the floor grid [m]."""


@dataclass(frozen=True, eq=False)
class Surface:
    """Triangles.

    Attributes:
        faces: Indices into vertices, anticlockwise seen from outside, shape (m, 3).
        smooth: Whether light is blended over the edges.
    """

    vertices: Floats
    faces: NDArray[np.integer]
    smooth: bool


def surface(shape: Shape) -> Surface:
    """Return triangles of a shape's surface, in the shape's own frame."""
    match shape:
        case Box():
            signs = np.array(np.meshgrid((-0.5, 0.5), (-0.5, 0.5), (-0.5, 0.5))).reshape(3, 8).T
            hull = convex(signs * (shape.x, shape.y, shape.z))
            return Surface(hull.vertices, hull.faces, False)
        case Plane():
            x, z = PLANE_EDGE / 2, -PLANE_DEPTH
            corners = np.array([(-x, -x, z), (x, -x, z), (x, x, z), (-x, x, z)])
            return Surface(corners, np.array([(0, 1, 2), (0, 2, 3)]), False)
        case Points() | Voxels():
            return Surface(*cloud_surface(shape), False)
        case Convex() | Mesh():
            return Surface(shape.vertices, shape.faces, isinstance(shape, Mesh))
        case _:
            return _revolve(_profile(shape))


def _profile(shape: Sphere | Capsule | Cylinder | Cone) -> list[tuple[float, float]]:
    r = shape.radius
    if isinstance(shape, Sphere):
        return _arc(r, 0.0, -90.0, 90.0)
    half = shape.length / 2
    match shape:
        case Capsule():
            return [*_arc(r, -half, -90.0, 0.0), *_arc(r, half, 0.0, 90.0)]
        case Cylinder():
            return [(0.0, -half), (r, -half), (r, -half), (r, half), (r, half), (0.0, half)]
        case Cone():
            return [(0.0, -half), (r, -half), (r, -half), (0.0, half)]


def _arc(radius: float, height: float, begin: float, end: float) -> list[tuple[float, float]]:
    """Return (r, z) on a circle about (0, height), from one latitude to another [deg]."""
    latitudes = np.radians(np.linspace(begin, end, round((end - begin) / 180.0 * SECTORS / 2) + 1))
    pairs = np.stack((radius * np.cos(latitudes), height + radius * np.sin(latitudes)), axis=1)
    return [(float(r), float(z)) for r, z in pairs]


def _revolve(profile: Sequence[tuple[float, float]]) -> Surface:
    angles = np.linspace(0.0, 2 * np.pi, SECTORS, endpoint=False)
    circle = np.stack((np.cos(angles), np.sin(angles)), axis=1)
    vertices = np.concatenate([np.column_stack((r * circle, np.full(SECTORS, z))) for r, z in profile])
    here = np.arange(SECTORS)
    there = (here + 1) % SECTORS
    bands: list[NDArray[np.integer]] = []
    for ring, (below, above) in enumerate(pairwise(profile)):
        low, high = ring * SECTORS, (ring + 1) * SECTORS
        if below == above:
            continue
        if below[0] > 0.0:
            bands.append(np.stack((low + here, low + there, high + there), axis=1))
        if above[0] > 0.0:
            bands.append(np.stack((low + here, high + there, high + here), axis=1))
    return Surface(vertices, np.concatenate(bands), True)
