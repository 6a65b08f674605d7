"""Shapes as the native core knows them."""

from functools import singledispatch

import numpy as np

from trajopt.native import proof
from trajopt.values.cached import cached_per_value
from trajopt.values.errors import ShapeError
from trajopt.values.shapes.closed_surface import closed_surface, part_points
from trajopt.values.shapes.clouds.points import Points
from trajopt.values.shapes.clouds.voxels import Voxels
from trajopt.values.shapes.shapes import (
    Box,
    Capsule,
    Cone,
    Convex,
    Cylinder,
    Mesh,
    Plane,
    Shape,
    Sphere,
    convex,
)

_THICKENING = 1e-5
"""A flat mesh is thickened by this much for its hull [m]."""


@cached_per_value
def form_of(shape: Shape) -> proof.Form:
    """Return a shape for the native core; computed once for each shape and kept as long as it."""
    return _make(shape)


@singledispatch
def _make(shape: Shape) -> proof.Form:
    raise NotImplementedError(type(shape).__name__)


@_make.register
def _(shape: Box) -> proof.Form:
    return proof.box(shape.x, shape.y, shape.z)


@_make.register
def _(shape: Sphere) -> proof.Form:
    return proof.round_solid("sphere", shape.radius, 0.0)


@_make.register
def _(shape: Cylinder) -> proof.Form:
    return proof.round_solid("cylinder", shape.radius, shape.length)


@_make.register
def _(shape: Capsule) -> proof.Form:
    return proof.round_solid("capsule", shape.radius, shape.length)


@_make.register
def _(shape: Cone) -> proof.Form:
    return proof.round_solid("cone", shape.radius, shape.length)


@_make.register
def _(shape: Plane) -> proof.Form:
    return proof.half_space()


@_make.register
def _(shape: Convex) -> proof.Form:
    return proof.hull(np.ascontiguousarray(shape.vertices), np.ascontiguousarray(shape.faces, dtype=np.int64))


@_make.register
def _(shape: Points) -> proof.Form:
    return proof.balls(np.ascontiguousarray(shape.points), shape.radius)


@_make.register
def _(shape: Voxels) -> proof.Form:
    return proof.cubes(np.ascontiguousarray(shape.centres), shape.size)


@_make.register
def _(shape: Mesh) -> proof.Form:
    return proof.mesh(
        np.ascontiguousarray(shape.vertices),
        np.ascontiguousarray(shape.faces, dtype=np.int64),
        form_of(hull_of(shape)),
        np.ascontiguousarray(part_points(shape)),
        np.ascontiguousarray(closed_surface(shape).triangles),
    )


def hull_of(mesh: Mesh) -> Convex:
    """Return the convex hull of a mesh; a flat one is thickened a little, as a hull needs volume."""
    try:
        return convex(mesh.vertices)
    except ShapeError:
        nudge = _THICKENING * np.vstack((np.eye(3), -np.eye(3)))
        return convex((mesh.vertices[:, None] + nudge).reshape(-1, 3))
