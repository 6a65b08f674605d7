"""Blocked cells: where along a path, and when, something that changes with time is in the way.

A cell is looked at in its middle. Larger blocks of cells come first: what is farther away than anything
travels within a block is clear of all of it, and what is deeper in contact blocks all of it, so that cells
are looked at one by one only along the borders of what is blocked.
"""

from collections.abc import Callable
from typing import TypeAlias

import numpy as np

from trajopt.arrays import Floats, Ints
from trajopt.planning.moving.looks import Looks

SIDE = 8
"""Cells along each side of the largest blocks: with fewer, most looks are at what is far away; with more,
most are at blocks that have to be cut."""
FREE = -1
"""In place of a pair, of a cell in which nothing is too near."""

Along: TypeAlias = Callable[[Floats], Floats]
"""The configurations (s, n) at parameters (s,) of a path."""


def blocked_cells(looks: Looks, along: Along, edges: Floats, times: Floats, *, hurried: bool = False) -> Ints:
    """Find what is in the way where along a path, and when.

    Args:
        looks: Looks at configurations; how much room pairs keep is known to it.
        along: The path.
        edges: Parameters of the path at which its m cells begin and end, increasing, shape (m + 1,).
        times: When the k intervals begin and end, increasing, shape (k + 1,) [s].
        hurried: Whether the parameter is the time of the fastest motion along the path, and all is over by
            the end of the times: then cells that no motion can be in so soon or so late are not looked at.

    Returns:
        The pair that is too near in each cell, or FREE, shape (m, k).
    """
    parts, moments = len(edges) - 1, len(times) - 1
    found = np.full((parts, moments), FREE, dtype=np.int64)
    robot, others = _travel(looks, along, edges, times)
    size = SIDE
    begin: Ints = np.stack(np.meshgrid(np.arange(0, parts, size), np.arange(0, moments, size)), -1).reshape(
        -1, 2
    )
    while len(begin):
        end = np.minimum(begin + size, (parts, moments))
        if hurried:
            met = times[end[:, 1]] > edges[begin[:, 0]]
            met &= times[-1] - times[begin[:, 1]] > edges[-1] - edges[end[:, 0]]
            begin, end = begin[met], end[met]
        place, late = _middles(edges, begin[:, 0], end[:, 0]), _middles(times, begin[:, 1], end[:, 1])
        travel = _away(robot, edges, place, begin[:, 0], end[:, 0])
        travel += _away(others, times, late, begin[:, 1], end[:, 1])
        around = np.stack((late - times[begin[:, 1]], times[end[:, 1]] - late), axis=1)
        seen = looks.seen(along(place), late, around, travel if size > 1 else np.zeros(len(travel)))
        whole = seen.near if size == 1 else seen.throughout
        for (part, moment), (last, until), pair in zip(
            begin[whole].tolist(), end[whole].tolist(), seen.pair[whole].tolist(), strict=True
        ):
            found[part:last, moment:until] = pair
        size //= 2
        begin = _quarters(begin[seen.within & ~whole], size, parts, moments)
    return found


def _quarters(begin: Ints, size: int, parts: int, moments: int) -> Ints:
    """Return where the quarters of blocks begin, where there are cells in them; nothing of single cells."""
    if not size:
        return begin[:0]
    offsets = np.array(((0, 0), (0, size), (size, 0), (size, size)))
    quarters = (begin[:, None] + offsets).reshape(-1, 2)
    return quarters[(quarters < (parts, moments)).all(axis=1)]


def _middles(edges: Floats, begin: Ints, end: Ints) -> Floats:
    return (edges[begin] + edges[end]) / 2.0


def _travel(looks: Looks, along: Along, edges: Floats, times: Floats) -> tuple[Floats, Floats]:
    """Bound how far the robot, and what moves by itself, have come at the edges of cells [m]."""
    query, timed = looks.query, looks.timed
    robot = timed.positions(along(edges), np.zeros(len(edges)))
    others = timed.positions(np.repeat(along(edges[:1]), len(times), axis=0), times)
    both = [query.displacement(rows[:-1], rows[1:]) for rows in (robot, others)]
    return np.append(0.0, np.cumsum(both[0])), np.append(0.0, np.cumsum(both[1]))


def _away(travelled: Floats, edges: Floats, middle: Floats, begin: Ints, end: Ints) -> Floats:
    """Bound how far something is, anywhere in a block, from where it is in the middle."""
    there: Floats = np.interp(middle, edges, travelled)
    return np.maximum(there - travelled[begin], travelled[end] - there)
