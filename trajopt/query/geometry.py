"""Shapes as Coal's collision geometries."""

import coal
import numpy as np
from numpy.typing import NDArray

from trajopt.arrays import Floats
from trajopt.model.derived import once_each
from trajopt.model.meshes.mesh_file import Mesh
from trajopt.model.shapes import Box, Capsule, Cone, Convex, Cylinder, Plane, Shape, Sphere


def _points(vertices: Floats) -> coal.StdVec_Vec3s:
    points = coal.StdVec_Vec3s()
    for vertex in vertices:
        points.append(vertex)
    return points


def _triangles(faces: NDArray[np.integer]) -> coal.StdVec_Triangle:
    triangles = coal.StdVec_Triangle()
    for a, b, c in faces.tolist():
        triangles.append(coal.Triangle(a, b, c))
    return triangles


@once_each
def collision_geometry(shape: Shape) -> coal.CollisionGeometry:
    """Return Coal's geometry of a shape, in the shape's own frame; made once for each shape."""
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
            geometry = coal.Halfspace(np.array([0.0, 0.0, 1.0]), 0.0)
        case Convex():
            geometry = coal.Convex(_points(shape.vertices), _triangles(shape.faces))
        case Mesh():
            geometry = coal.BVHModelOBBRSS()
            geometry.beginModel(len(shape.faces), len(shape.vertices))
            geometry.addSubModel(_points(shape.vertices), _triangles(shape.faces))
            geometry.endModel()
    geometry.computeLocalAABB()
    return geometry
