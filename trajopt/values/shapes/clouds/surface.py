"""Triangles that show a cloud."""

import numpy as np

from trajopt.values.arrays import Floats, Ints
from trajopt.values.shapes.clouds.parts import centres_of, fewer
from trajopt.values.shapes.clouds.points import Points
from trajopt.values.shapes.clouds.voxels import Voxels

MOST_SHOWN = 20_000
"""Balls or cubes that are drawn of a cloud; of one that has more, fewer and larger ones that contain them."""


def cloud_surface(cloud: Points | Voxels, most: int = MOST_SHOWN) -> tuple[Floats, Ints]:
    """Return triangles that show a cloud: an octahedron for each ball, and the outer faces of cubes.

    Args:
        cloud: The cloud.
        most: How many balls or cubes are drawn.

    Returns:
        Vertices, shape (v, 3) [m], and faces, anticlockwise seen from outside, shape (f, 3).
    """
    shown = fewer(cloud, most)
    if isinstance(shown, Voxels):
        return _cubes(shown)
    corners = np.concatenate((np.eye(3), -np.eye(3))) * shown.radius
    faces = np.array([(0, 1, 2), (1, 3, 2), (3, 4, 2), (4, 0, 2), (1, 0, 5), (3, 1, 5), (4, 3, 5), (0, 4, 5)])
    first = 6 * np.arange(len(shown))
    vertices = (centres_of(shown)[:, None] + corners).reshape(-1, 3)
    return vertices, (first[:, None, None] + faces).reshape(-1, 3)


def _cubes(cloud: Voxels) -> tuple[Floats, Ints]:
    """Return two triangles for each side of a cell that no other cell hides."""
    vertices: list[Floats] = []
    square = np.array(((0, 0), (1, 0), (1, 1), (0, 1)))
    keys = cloud.keys - cloud.keys.min(axis=0) + 1
    span = keys.max(axis=0) + 2
    flat = (keys[:, 0] * span[1] + keys[:, 1]) * span[2] + keys[:, 2]
    strides = (span[1] * span[2], span[2], 1)
    for axis in range(3):
        for side in (0, 1):
            open_ = ~np.isin(flat + (2 * side - 1) * strides[axis], flat)
            corners = np.zeros((4, 3), dtype=np.int64)
            corners[:, (axis + 1) % 3], corners[:, (axis + 2) % 3] = square[:: 2 * side - 1].T
            corners[:, axis] = side
            vertices.append(
                ((cloud.keys[open_][:, None] + corners).astype(np.float64) * cloud.size).reshape(-1, 3)
            )
    found = np.concatenate(vertices)
    first = 4 * np.arange(len(found) // 4)[:, None, None]
    return found, (first + np.array(((0, 1, 2), (0, 2, 3)))).reshape(-1, 3)
