"""Fewer points that stand for many: one for each cell of a grid."""

from math import prod

import numpy as np

from trajopt.values.arrays import Bools, Floats, Ints, readonly

ROUNDED_UP = 1.0 + 1e-12
"""On the distance of the farthest point: more than what the arithmetic rounds off, so that balls contain."""


def one_in_each_cell(points: Floats, cell: float) -> tuple[Floats, float]:
    """Put one point in the place of all that lie in the same cube of a grid.

    Args:
        points: Shape (n, 3) [m].
        cell: Edge of the cubes [m].

    Returns:
        The middle of the bounding box of the points of each cube, shape (m, 3) [m], in the order in which
        the cubes follow each other; and the distance of the farthest point from its middle [m].
    """
    order, begins = _by_cell(points, cell)
    sorted_points = points[order]
    lower = np.minimum.reduceat(sorted_points, begins, axis=0)
    upper = np.maximum.reduceat(sorted_points, begins, axis=0)
    middles = (lower + upper) / 2.0
    sizes = np.diff(np.append(begins, len(points)))
    apart = np.linalg.norm(sorted_points - np.repeat(middles, sizes, axis=0), axis=1)
    return readonly(middles), float(apart.max()) * ROUNDED_UP


def _by_cell(points: Floats, cell: float) -> tuple[Ints, Ints]:
    """Return an order of points in which those of a cube are neighbours, and where each cube begins in it."""
    keys: Ints = np.floor((points - points.min(axis=0)) / cell).astype(np.int64)
    span = keys.max(axis=0) + 1
    changes: Bools
    if prod(span.tolist()) < 2**62:
        flat = (keys[:, 0] * span[1] + keys[:, 1]) * span[2] + keys[:, 2]
        order = np.argsort(flat, kind="stable")
        changes = np.diff(flat[order]) != 0
    else:
        order = np.lexsort(keys.T[::-1])
        changes = (np.diff(keys[order], axis=0) != 0).any(axis=1)
    return order, np.append(0, np.flatnonzero(changes) + 1)
