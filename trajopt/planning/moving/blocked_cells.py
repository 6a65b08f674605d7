"""Blocked cells: places along a path, and times, at which a dynamic obstacle is in the way.

A cell is sampled in its middle. Larger blocks of cells come first: an object farther away than
the travel within a block is clear of all of it, and a deeper contact blocks all of it, so that single cells
are only sampled along the borders of blocked regions.
"""

from collections.abc import Callable
from typing import TypeAlias

import numpy as np

from trajopt.planning.moving.sampled_checks import SampledChecks
from trajopt.values.arrays import Bools, Floats, Ints

SIDE = 8
"""Cells along each side of the largest blocks: with fewer, most samples are of distant objects; with more,
most blocks have to be cut.
"""
STRETCH = 8 * SIDE
"""Intervals of time to sample before the reachable cells are computed: few enough to waste
few samples, enough to sample many blocks together.
"""
FREE = -1
"""In place of a pair, of a cell in which nothing is too near."""

Along: TypeAlias = Callable[[Floats], Floats]
"""The configurations (s, n) at parameters (s,) of a path."""


def blocked_cells(
    checks: SampledChecks, along: Along, edges: Floats, times: Floats, *, hurried: bool = False
) -> Ints:
    """Find what is in the way where along a path, and when.

    Args:
        checks: Checks configurations; it has the clearance that pairs keep.
        along: The path.
        edges: Parameters of the path at which its m cells begin and end, increasing, shape (m + 1,).
        times: When the k intervals begin and end, increasing, shape (k + 1,) [s].
        hurried: Whether the parameter is the time of the fastest motion along the path, no interval is longer
            than a cell, and all is over by the end of the times: then only cells that a motion can be in are
            looked at: not so soon or so late, nor behind what it cannot have passed.

    Returns:
        The pair that is too near in each cell, or FREE, shape (m, k).
    """
    plane = _Plane(checks, along, edges, times, hurried)
    parts, moments = plane.found.shape
    if not hurried:
        plane.look((0, parts), (0, moments))
        return plane.found
    reached: Bools = np.arange(parts) == 0
    for begin in range(0, moments, STRETCH):
        end = min(begin + STRETCH, moments)
        there = np.flatnonzero(reached)
        if not len(there):
            break
        plane.look((int(there[0]), min(int(there[-1]) + 1 + end - begin, parts)), (begin, end))
        reached = _reached(reached, plane.found[:, begin:end] == FREE)
    return plane.found


def _reached(before: Bools, free: Bools) -> Bools:
    """Return the cells, of m, in which a motion can be in the last of some intervals.

    Args:
        before: Cells in which it can be in the interval before, or begin, shape (m,).
        free: Free cells, shape (m, k).
    """
    reached = before
    for column in free.T:
        # In an interval it gets on by the length of a cell at the most.
        reached = (reached | np.append(False, reached[:-1])) & column
    return reached


class _Plane:
    """The plane of a path and time, in which blocks of cells are looked at."""

    def __init__(
        self, checks: SampledChecks, along: Along, edges: Floats, times: Floats, hurried: bool
    ) -> None:
        """Begin without results; for arguments see `blocked_cells`."""
        self.found = np.full((len(edges) - 1, len(times) - 1), FREE, dtype=np.int64)
        self._checks, self._along, self._edges, self._times = checks, along, edges, times
        self._hurried = hurried
        self._robot = self._travelled(along(edges), np.zeros(len(edges)))

    def look(self, parts: tuple[int, int], moments: tuple[int, int]) -> None:
        """Look at the cells from some to before others."""
        size, edges, times = SIDE, self._edges, self._times
        ahead = slice(moments[0], moments[1] + 1)
        standing = np.repeat(self._along(edges[:1]), ahead.stop - ahead.start, axis=0)
        others = self._travelled(standing, times[ahead])
        corners = np.meshgrid(np.arange(*parts, size), np.arange(*moments, size))
        begin: Ints = np.stack(corners, -1).reshape(-1, 2)
        last = np.array((parts[1], moments[1]))
        while len(begin):
            end = np.minimum(begin + size, last)
            if self._hurried:
                met = times[end[:, 1]] > edges[begin[:, 0]]
                met &= times[-1] - times[begin[:, 1]] > edges[-1] - edges[end[:, 0]]
                begin, end = begin[met], end[met]
            place, late = _middles(edges, begin[:, 0], end[:, 0]), _middles(times, begin[:, 1], end[:, 1])
            travel = _away(self._robot, edges, place, begin[:, 0], end[:, 0])
            travel += _away(others, times[ahead], late, begin[:, 1] - ahead.start, end[:, 1] - ahead.start)
            around = np.stack((late - times[begin[:, 1]], times[end[:, 1]] - late), axis=1)
            room = travel if size > 1 else np.zeros(len(travel))
            seen = self._checks.check(self._along(place), late, around, room)
            whole = seen.near if size == 1 else seen.throughout
            for (part, moment), (after, until), pair in zip(
                begin[whole].tolist(), end[whole].tolist(), seen.pair[whole].tolist(), strict=True
            ):
                self.found[part:after, moment:until] = pair
            size //= 2
            begin = _quarters(begin[seen.within & ~whole], size, last)

    def _travelled(self, positions: Floats, times: Floats) -> Floats:
        """Bound the travel of everything at configurations (s, n) at times (s,), shape (s,) [m]."""
        return np.append(0.0, np.cumsum(self._checks.obstacles.moved(positions, times)))


def _quarters(begin: Ints, size: int, last: Ints) -> Ints:
    """Return the first cells of the quarters of blocks; none of single cells."""
    if not size:
        return begin[:0]
    offsets = np.array(((0, 0), (0, size), (size, 0), (size, size)))
    quarters = (begin[:, None] + offsets).reshape(-1, 2)
    return quarters[(quarters < last).all(axis=1)]


def _middles(edges: Floats, begin: Ints, end: Ints) -> Floats:
    return (edges[begin] + edges[end]) / 2.0


def _away(travelled: Floats, edges: Floats, middle: Floats, begin: Ints, end: Ints) -> Floats:
    """Bound the distance of an object, anywhere in a block, from its place in the middle."""
    there: Floats = np.interp(middle, edges, travelled)
    return np.maximum(there - travelled[begin], travelled[end] - there)
