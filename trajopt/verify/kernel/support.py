"""How far shapes reach along directions: enough to prove that convex bodies keep apart.

Along any unit direction n from a body A to a body B the gap min_B n x - max_A n x is a lower bound of
their signed distance, and along the best one it equals it, in penetration too. So a library for
distances need only propose directions: what is taken from them here is proven.
"""

import numpy as np

from trajopt.arrays import Floats
from trajopt.model.placement import Placement
from trajopt.model.shapes import Box, Capsule, Cone, Convex, Cylinder, Mesh, Plane, Shape, Sphere

_DIRECTIONS = 2000
_STEPS = 300
_ROUNDS = 48


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


def gap(first: Shape, second: Shape, where: Placement, directions: Floats) -> Floats:
    """Return the gap between two shapes along directions from the first to the second.

    Args:
        first: One shape.
        second: The other.
        where: Placement of the second in the first one's frame.
        directions: Unit vectors in the first one's frame, shape (c, 3).

    Returns:
        Shape (c,) [m]; negative where the shapes overlap along the direction.
    """
    between = directions @ where.translation
    return between - support(first, directions) - support(second, -directions @ where.rotation)


def largest_gap(first: Shape, second: Shape, where: Placement) -> float:
    """Search all directions for the largest gap: slow, always a lower bound, nearly the distance.

    Args:
        first: One shape.
        second: The other.
        where: Placement of the second in the first one's frame.
    """
    even = _spread_evenly(_DIRECTIONS)
    found = gap(first, second, where, even)
    best, largest = even[int(found.argmax())], float(found.max())
    # Steps in all directions, of all lengths up to one, in no order.
    steps = _spread_evenly(_STEPS) * np.sqrt(np.arange(_STEPS) * 0.618034 % 1.0)[:, None]
    spread = 2.0 * np.sqrt(4.0 * np.pi / _DIRECTIONS)
    for _ in range(_ROUNDS):
        near = best + spread * steps
        near /= np.linalg.norm(near, axis=1)[:, None]
        found = gap(first, second, where, near)
        if found.max() > largest:
            best, largest = near[int(found.argmax())], float(found.max())
        else:
            spread /= 2.0
    return largest


def _spread_evenly(count: int) -> Floats:
    """Return unit vectors spread evenly over the sphere along a spiral, shape (count, 3)."""
    height = 1.0 - (2.0 * np.arange(count) + 1.0) / count
    angle = np.pi * (1.0 + np.sqrt(5.0)) * np.arange(count)
    radius = np.sqrt(1.0 - height**2)
    return np.stack((radius * np.cos(angle), radius * np.sin(angle), height), axis=1)
