"""How far shapes reach along directions."""

import numpy as np

from trajopt.arrays import Floats
from trajopt.model.shapes import Box, Capsule, Cone, Convex, Cylinder, Mesh, Plane, Shape, Sphere


def support(shape: Shape, directions: Floats) -> Floats:
    """Return how far a shape reaches along directions, from its own origin.

    Args:
        shape: The shape; a mesh reaches as far as its convex hull, a plane infinitely far.
        directions: Unit vectors in the shape's frame, shape (c, 3).

    Returns:
        Largest value of `direction @ point` over its points, shape (c,) [m].
    """
    along = directions[:, 2]
    across = np.hypot(directions[:, 0], directions[:, 1])
    match shape:
        case Box():
            reach = np.abs(directions) @ np.array((shape.x, shape.y, shape.z)) / 2
        case Sphere():
            reach = np.full(len(directions), shape.radius)
        case Cylinder():
            reach = across * shape.radius + np.abs(along) * shape.length / 2
        case Capsule():
            reach = shape.radius + np.abs(along) * shape.length / 2
        case Cone():
            reach = np.maximum(along * shape.length / 2, across * shape.radius - along * shape.length / 2)
        case Plane():
            reach = np.full(len(directions), np.inf)
        case Convex() | Mesh():
            reach = (directions @ shape.vertices.T).max(axis=1)
    return np.asarray(reach, dtype=np.float64)
