"""Triangles of a shape's surface, to draw it."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from trajopt.values.arrays import Floats
from trajopt.values.shapes.clouds.points import Points
from trajopt.values.shapes.clouds.surface import cloud_surface
from trajopt.values.shapes.clouds.voxels import Voxels
from trajopt.values.shapes.mesh import Mesh
from trajopt.values.shapes.shapes import Box, Capsule, Cone, Convex, Cylinder, Plane, Shape, Sphere, convex

SECTORS = 32
"""Number of edges of a drawn circle."""
PLANE_EDGE = 4.0
"""Edge of the square that represents a half-space [m]."""
PLANE_DEPTH = 0.002
"""Depth of that square below the surface, clear of the floor grid [m]."""


@dataclass(frozen=True, eq=False)
class Surface:
    """Triangles.

    Attributes:
        vertices: Shape (n, 3) [m].
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
    """Return (r, z) from the lower pole to the upper; points at sharp edges are doubled for their shading."""
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
    """Turn a profile of (r, z), from the lower pole to the upper, about the z axis."""
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
