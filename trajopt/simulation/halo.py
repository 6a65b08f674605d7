"""Halo: a surface around a shape at the distance of its position error."""

from dataclasses import dataclass
from functools import cache

import numpy as np

from trajopt.robot.joints import FixedBody
from trajopt.values.arrays import Floats, Ints, Value, readonly
from trajopt.values.placement import Placement
from trajopt.values.shapes.clouds import Points, Voxels, centres_of
from trajopt.values.shapes.mesh import Mesh
from trajopt.values.shapes.shapes import Box, Capsule, Cone, Convex, Cylinder, Plane, Shape, Sphere, convex

DIVISIONS = 12
"""Divisions of each edge of the octahedron from which a ball is made: a multiple of 2 and 3, so that edges
and corners of boxes have points."""

THINNEST = 3e-3
"""Thinner halos are not drawn [m]: they would flicker with the surface itself."""


@dataclass(frozen=True, eq=False)
class Halo(Value):
    """A surface at a variable distance around a body, or around its convex hull.

    Attributes:
        nearest: Points at distance 0, in the frame of the body, shape (n, 3) [m].
        outward: Unit vectors of their displacements, shape (n, 3).
    """

    nearest: Floats
    outward: Floats
    faces: Ints

    def grown(self, distance: float) -> Floats:
        """Return its points at a distance, shape (n, 3) [m]."""
        return self.nearest + distance * self.outward


def halo(shape: Shape, where: Placement) -> Halo:
    """Return the halo of a shape (not a half-space), placed in the frame of the halo."""
    ball = _ball()
    directions = ball.vertices
    return Halo(
        readonly(where * _farthest(shape, directions)), readonly(directions @ where.rotation.T), ball.faces
    )


def has_halo(body: FixedBody) -> bool:
    """Return whether a body has a halo: all except half-spaces."""
    return not isinstance(body.shape, Plane)


def _farthest(shape: Shape, directions: Floats) -> Floats:
    level = directions * (1.0, 1.0, 0.0)
    size = np.linalg.norm(level, axis=1, keepdims=True)
    aside = np.divide(level, size, out=np.zeros_like(level), where=size > 1e-12)
    up = np.sign(directions) * (0.0, 0.0, 1.0)
    match shape:
        case Box():
            return np.sign(directions) * (shape.x / 2, shape.y / 2, shape.z / 2)
        case Sphere():
            return shape.radius * directions
        case Capsule():
            return shape.radius * directions + shape.length / 2 * up
        case Cylinder():
            return shape.radius * aside + shape.length / 2 * up
        case Cone():
            tip = directions[:, 2:] * shape.length > size * shape.radius
            top = np.array((0.0, 0.0, shape.length / 2))
            return np.where(tip, top, shape.radius * aside - top)
        case Points() | Voxels():
            grown = (
                shape.radius * directions
                if isinstance(shape, Points)
                else np.sign(directions) * shape.size / 2
            )
            centres = centres_of(shape)
            return centres[[int((centres @ each).argmax()) for each in directions]] + grown
        case Convex() | Mesh():
            return shape.vertices[(directions @ shape.vertices.T).argmax(axis=1)]
        case Plane():
            raise AssertionError("a half-space has no support point")


@cache
def _ball() -> Convex:
    grid = np.mgrid[-DIVISIONS : DIVISIONS + 1, -DIVISIONS : DIVISIONS + 1, -DIVISIONS : DIVISIONS + 1]
    points = grid.reshape(3, -1).T
    points = points[np.abs(points).sum(axis=1) == DIVISIONS].astype(np.float64)
    return convex(points / np.linalg.norm(points, axis=1, keepdims=True))
