"""Conversion of shapes for the native core and for Coal."""

from functools import singledispatch
from typing import Any, TypeAlias

import coal
import numpy as np
from numpy.typing import NDArray

from trajopt.native import proof
from trajopt.values.arrays import Floats
from trajopt.values.cached import cached_per_value
from trajopt.values.errors import ProblemError, ShapeError
from trajopt.values.shapes.clouds import Points, Voxels
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
from trajopt.values.shapes.surfaces import closed_surface, part_points

_THICKENING = 1e-5
"""Thickness added to a flat mesh for its hull [m]."""


@cached_per_value
def form_of(shape: Shape) -> proof.Form:
    """Return a shape for the native core, cached for the lifetime of the shape."""
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
    """Return the convex hull of a mesh; a flat one is thickened slightly, as a hull needs volume."""
    try:
        return convex(mesh.vertices)
    except ShapeError:
        nudge = _THICKENING * np.vstack((np.eye(3), -np.eye(3)))
        return convex((mesh.vertices[:, None] + nudge).reshape(-1, 3))


Indices: TypeAlias = NDArray[np.integer[Any]]


def coal_geometry(shape: Shape) -> coal.CollisionGeometry:
    """Return a shape for Coal, with the same origin."""
    geometry: coal.CollisionGeometry
    match shape:
        case Box():
            geometry = coal.Box(shape.x, shape.y, shape.z)
        case Sphere():
            geometry = coal.Sphere(shape.radius)
        case Cylinder():
            geometry = coal.Cylinder(shape.radius, shape.length)
        case Capsule():
            geometry = coal.Capsule(shape.radius, shape.length)
        case Cone():
            geometry = coal.Cone(shape.radius, shape.length)
        case Plane():
            geometry = coal.Halfspace(np.array((0.0, 0.0, 1.0)), 0.0)
        case Convex():
            geometry = coal.Convex(_points(shape.vertices), _triangles(shape.faces))
        case Points() | Voxels():
            raise ProblemError("Coal does not support clouds")
        case Mesh():
            geometry = coal.BVHModelOBBRSS()
            geometry.beginModel(len(shape.faces), len(shape.vertices))
            geometry.addSubModel(_points(shape.vertices), _triangles(shape.faces))
            geometry.endModel()
    return geometry


def _points(vertices: Floats) -> coal.StdVec_Vec3s:
    points = coal.StdVec_Vec3s()
    points.extend(vertices)
    return points


def _triangles(faces: Indices) -> coal.StdVec_Triangle:
    triangles = coal.StdVec_Triangle()
    triangles.extend([coal.Triangle(*face) for face in faces.tolist()])
    return triangles
