"""Triangles that show a cloud, and coarser clouds."""

import numpy as np

from trajopt.values.arrays import LARGEST_SIZE, Floats, Ints
from trajopt.values.shapes.clouds.points import Points
from trajopt.values.shapes.clouds.voxels import Voxels

MOST_SHOWN = 20_000
"""Largest number of drawn balls or cubes; larger clouds are drawn coarser."""


def cloud_surface(cloud: Points | Voxels, most: int = MOST_SHOWN) -> tuple[Floats, Ints]:
    """Return triangles that show a cloud: an octahedron for each ball, and the outer faces of cubes.

    Args:
        most: Largest number of drawn balls or cubes.

    Returns:
        Vertices, shape (v, 3) [m], and faces, counter-clockwise seen from outside, shape (f, 3).
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
    """Return two triangles for each side of a cell without a neighbour."""
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


def fewer(cloud: Points | Voxels, most: int) -> Points | Voxels:
    """Return a coarser cloud with at most `most` balls or cubes, which contain the original ones.

    Args:
        cloud: The cloud; returned itself if it is small enough.
        most: Largest number, at least 8, since 8 cells of any size meet at a corner.
    """
    while len(cloud) > most:
        if isinstance(cloud, Voxels):
            cloud = Voxels(cloud.keys >> 1, 2.0 * cloud.size)
        else:
            cloud = _coarser(cloud, most)
    return cloud


def _coarser(cloud: Points, most: int) -> Points:
    """Thin a cloud by doubling the cell, from half a radius on, until it is small enough."""
    cell, thin = cloud.radius / 2.0, cloud
    while len(thin) > most:
        cell *= 2.0
        thin = cloud.thinned(min(cell, LARGEST_SIZE))
    return thin


def centres_of(cloud: Points | Voxels) -> Floats:
    """Return the centres of the balls or cubes of a cloud, shape (n, 3) [m]."""
    return cloud.points if isinstance(cloud, Points) else cloud.centres
