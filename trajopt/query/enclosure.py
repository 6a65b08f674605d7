"""Which bodies an exact mesh encloses: Coal's distance to its triangles does not tell."""

import numpy as np

from trajopt.arrays import Floats
from trajopt.model.closed_surface import closed_surface, part_points
from trajopt.model.meshes.mesh_file import Mesh
from trajopt.model.shapes import Shape


def closed_triangles(shape: Shape) -> Floats:
    """Return the triangles that a body can be inside of without touching them, shape (k, 3, 3) [m]."""
    return closed_surface(shape).triangles if isinstance(shape, Mesh) else np.empty((0, 3, 3))


def encloses(shell: Shape, body: Shape, rotation: Floats, translation: Floats) -> bool:
    """Say whether a shape's closed surface winds around a part of a body.

    Args:
        shell: The shape.
        body: The body's.
        rotation: Of the body in the shape's frame, shape (3, 3).
        translation: Of the body there, shape (3,) [m].
    """
    triangles = closed_triangles(shell)
    if not len(triangles):
        return False
    corners = triangles.reshape(-1, 3)
    points = part_points(body) @ rotation.T + translation
    boxed = ((points >= corners.min(axis=0)) & (points <= corners.max(axis=0))).all(axis=1)
    return any(_solid_angle(triangles - point) > 2.0 * np.pi for point in points[boxed])


def _solid_angle(triangles: Floats) -> float:
    """Return the solid angle that triangles fill as seen from the origin (van Oosterom, Strackee 1983)."""
    length = np.linalg.norm(triangles, axis=2)
    cosines = np.einsum("kij,kij->ki", triangles, np.roll(triangles, -1, axis=1))
    rest = length.prod(axis=1) + (cosines * np.roll(length, -2, axis=1)).sum(axis=1)
    return float(2.0 * np.arctan2(np.linalg.det(triangles), rest).sum())
