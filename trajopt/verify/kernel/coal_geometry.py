"""Shapes as Coal's collision geometries."""

from typing import Any, TypeAlias

import coal
import numpy as np
from numpy.typing import NDArray

from trajopt.values.arrays import Floats
from trajopt.values.errors import ProblemError
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
)

Indices: TypeAlias = NDArray[np.integer[Any]]


def coal_geometry(shape: Shape) -> coal.CollisionGeometry:
    """Return a shape as Coal knows it; each of Coal's shapes has its origin where ours has.

    Raises:
        ProblemError: If it is a cloud, which Coal does not know.
    """
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
            raise ProblemError("a cloud is no shape of Coal's")
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
