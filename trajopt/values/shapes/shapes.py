"""Shapes of collision bodies, in metres."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from trajopt.values.arrays import Floats, Ints, Value, floats, length, readonly
from trajopt.values.errors import ShapeError
from trajopt.values.placement import Placement
from trajopt.values.shapes.clouds import Points, Voxels, centres_of
from trajopt.values.shapes.mesh import Mesh


@dataclass(frozen=True)
class Box(Value):
    """Box about its centre; x, y and z are the lengths of its edges [m]."""

    x: float
    y: float
    z: float

    def __post_init__(self) -> None:
        for name in ("x", "y", "z"):
            object.__setattr__(self, name, length(f"Box.{name}", getattr(self, name)))


@dataclass(frozen=True)
class Sphere(Value):
    """Sphere about its centre; radius [m]."""

    radius: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "radius", length("Sphere.radius", self.radius))


@dataclass(frozen=True)
class Cylinder(Value):
    """Solid cylinder about its centre, axis along z; radius and length [m]."""

    radius: float
    length: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "radius", length("Cylinder.radius", self.radius))
        object.__setattr__(self, "length", length("Cylinder.length", self.length))


@dataclass(frozen=True)
class Capsule(Value):
    """Cylinder with a half sphere at each end, axis along z; `length` is without the caps [m]."""

    radius: float
    length: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "radius", length("Capsule.radius", self.radius))
        object.__setattr__(self, "length", length("Capsule.length", self.length))


@dataclass(frozen=True)
class Cone(Value):
    """Solid cone, axis along z: base of that radius at -length/2, tip at +length/2 [m]."""

    radius: float
    length: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "radius", length("Cone.radius", self.radius))
        object.__setattr__(self, "length", length("Cone.length", self.length))


@dataclass(frozen=True)
class Plane(Value):
    """Everything below the plane z = 0 of its own frame is solid (a half-space)."""


@dataclass(frozen=True, eq=False)
class Convex(Value):
    """Convex hull of points.

    Build one with `convex(points)`.

    Attributes:
        vertices: Extreme points, shape (n, 3) [m], read-only.
        faces: Triangles of the surface, outward, indices into vertices, shape (m, 3), read-only.
    """

    vertices: Floats
    faces: Ints

    @cached_property
    def sphere(self) -> tuple[Floats, float]:
        """Centre (3,) and radius [m] of a sphere around all vertices."""
        centre = (self.vertices.min(axis=0) + self.vertices.max(axis=0)) / 2
        return centre, float(np.linalg.norm(self.vertices - centre, axis=1).max())


Shape: TypeAlias = Box | Sphere | Cylinder | Capsule | Cone | Plane | Convex | Mesh | Points | Voxels


MOST_NEIGHBOURS = 255
"""Of a vertex of a hull: Coal counts them in one byte."""
OUTWARD, RESOLVED = 1e-7, 1e-10
"""How far corners are moved outward at first where there would be more [m], and as a share of coordinates, so
that rounding does not hide it.
"""


def convex(points: ArrayLike) -> Convex:
    """Wrap points into their convex hull.

    If a corner has more than 255 neighbours, as the tip of a finely meshed cone, corners move outward by up
    to a few tenths of a micrometre, or a few 1e-10 of the largest coordinate.

    Args:
        points: At least four points that do not lie in one plane, shape (n, 3) [m].

    Raises:
        ShapeError: If the points span no volume.
    """
    cloud = floats("points", points, (None, 3))
    if len(cloud) < 4 or np.linalg.matrix_rank(cloud - cloud[0], tol=1e-9) < 3:
        raise ShapeError("points", "lie in one plane, so their hull has no volume")
    step = max(OUTWARD, RESOLVED * float(np.abs(cloud).max()))
    corners, faces, outward = _hull(cloud)
    if (_neighbours(faces) > MOST_NEIGHBOURS).any():  # as triangles of a flat face have a corner in common
        corners, faces, outward = _hull(corners + step * _uneven(corners))
    while ((neighbours := _neighbours(faces)) > MOST_NEIGHBOURS).any():
        corners, faces, outward = _hull(np.concatenate(list(_blunt(corners, neighbours, step))))
        step *= 2.0  # so that this ends
    at = corners[faces]
    inward = np.einsum("ij,ij->i", np.cross(at[:, 1] - at[:, 0], at[:, 2] - at[:, 0]), outward) < 0.0
    faces[inward] = faces[inward][:, ::-1]
    return Convex(readonly(corners), faces)


def _hull(cloud: Floats) -> tuple[Floats, Ints, Floats]:
    """Return the corners of the hull, its triangles in any order of their corners, and outward normals."""
    from scipy.spatial import ConvexHull

    hull = ConvexHull(cloud)
    used, compact = np.unique(hull.simplices, return_inverse=True)
    return cloud[used], compact.reshape(-1, 3), hull.equations[:, :3]


def _neighbours(faces: Ints) -> Ints:
    return np.bincount(faces.ravel())


def _directions(corners: Floats) -> Floats:
    away = corners - corners.mean(axis=0)
    return away / np.linalg.norm(away, axis=1, keepdims=True)


def _uneven(corners: Floats) -> Floats:
    return np.random.default_rng(0).random((len(corners), 1)) * _directions(corners)


def _blunt(corners: Floats, neighbours: Ints, step: float) -> Iterator[Floats]:
    """Yield the corners, and in place of those with too many neighbours circles of points around them."""
    crowded = neighbours > MOST_NEIGHBOURS
    yield corners[~crowded]
    tips = zip(corners[crowded], _directions(corners)[crowded], neighbours[crowded].tolist(), strict=True)
    for corner, away, count in tips:
        across = np.cross(away, np.eye(3)[int(np.argmin(np.abs(away)))])
        axes = np.stack((across, np.cross(away, across))) / np.linalg.norm(across)
        angles = np.linspace(0.0, 2.0 * np.pi, 3 + count // 64, endpoint=False)
        circle = np.stack((np.cos(angles), np.sin(angles)), axis=1) @ axes
        yield corner + step * (away + circle)


def bounding_sphere(shape: Shape) -> tuple[Floats, float]:
    """Return centre (3,) [m] in the shape's frame and radius [m] of a sphere around the shape."""
    origin = np.zeros(3)
    match shape:
        case Box():
            return origin, float(np.linalg.norm((shape.x, shape.y, shape.z))) / 2
        case Sphere():
            return origin, shape.radius
        case Cylinder() | Cone():
            return origin, float(np.hypot(shape.radius, shape.length / 2))
        case Capsule():
            return origin, shape.radius + shape.length / 2
        case Plane():
            return origin, np.inf
        case Convex():
            return shape.sphere
        case Points() | Voxels():
            return shape.sphere
        case Mesh():
            centre = (shape.vertices.min(axis=0) + shape.vertices.max(axis=0)) / 2
            return centre, float(np.linalg.norm(shape.vertices - centre, axis=1).max())


def bounding_box(shape: Shape) -> tuple[Floats, Floats]:
    """Return the shape's axis-aligned box in its own frame: lower and upper corner, (3,) [m]."""
    match shape:
        case Box():
            half = np.array((shape.x, shape.y, shape.z)) / 2
        case Sphere():
            half = np.full(3, shape.radius)
        case Cylinder() | Cone():
            half = np.array((shape.radius, shape.radius, shape.length / 2))
        case Capsule():
            half = np.array((shape.radius, shape.radius, shape.length / 2 + shape.radius))
        case Plane():
            return np.full(3, -np.inf), np.array((np.inf, np.inf, 0.0))
        case Convex() | Mesh():
            return shape.vertices.min(axis=0), shape.vertices.max(axis=0)
        case Points() | Voxels():
            return shape.box
    return -half, half


def placed_box(shape: Shape, where: Placement) -> Floats:
    """Return the axis-aligned box of a placed shape, or more: lower and upper corner, shape (2, 3) [m]."""
    lower, upper = bounding_box(shape)
    middle, half = where * ((lower + upper) / 2.0), np.abs(where.rotation) @ ((upper - lower) / 2.0)
    return np.stack((middle - half, middle + half))


def outermost(points: Floats) -> Floats:
    """Return the corners of the convex hull of points (n, 2 or 3); all of them if it is flat."""
    from scipy.spatial import ConvexHull, QhullError  # slow to import

    try:
        return points[ConvexHull(points).vertices]
    except (QhullError, ValueError):
        return points


def scaled(shape: Shape, factor: float, centre: Floats) -> Shape:
    """Return a scaled shape: primitives about their origin, points about a centre, shape (3,) [m].

    A plane is unchanged; the cells of a grid stay on a grid about their origin.

    Raises:
        SizeError: If the result is larger than any shape may be.
    """
    match shape:
        case Box():
            return Box(factor * shape.x, factor * shape.y, factor * shape.z)
        case Sphere():
            return Sphere(factor * shape.radius)
        case Cylinder() | Capsule() | Cone():
            return type(shape)(factor * shape.radius, factor * shape.length)
        case Plane():
            return shape
        case Convex() | Mesh():
            return replace(shape, vertices=readonly(centre + factor * (shape.vertices - centre)))
        case Points():
            return Points(centre + factor * (shape.points - centre), factor * shape.radius)
        case Voxels():
            return Voxels(shape.keys, factor * shape.size)


def solids_near(
    shape: Shape, where: Placement, centre: Floats, reach: float
) -> list[tuple[Shape, Placement]]:
    """Return the balls or cubes of a cloud that may touch a ball, each with its placement; others unchanged.

    Args:
        centre: Of the ball, in the reference frame of the placement, shape (3,) [m].
    """
    if not isinstance(shape, Points | Voxels):
        return [(shape, where)]
    one = Sphere(shape.radius) if isinstance(shape, Points) else Box(shape.size, shape.size, shape.size)
    centres = where * centres_of(shape)
    near = np.linalg.norm(centres - centre, axis=1) <= reach + bounding_sphere(one)[1]
    return [(one, Placement(where.rotation, readonly(at))) for at in centres[near]]
