"""Plane of path and time."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from trajopt.geometry import DynamicObstacles, WorkCounts
from trajopt.planning.moving.sampled_checks import INTERVAL, SampledChecks
from trajopt.planning.result import Plan, Result
from trajopt.values.arrays import Bools, Floats, Ints, Value, number, readonly
from trajopt.values.errors import ShapeError
from trajopt.values.errors.arguments import checked
from trajopt.values.trajectory import Trajectory

PARTS = 96
"""Cells along the path: each about a hundredth of it, the resolution of a picture."""
MOST_TIMES = 1000
"""Most intervals, each at least the sampling interval along a motion."""


@dataclass(frozen=True, eq=False)
class PathTime(Value):
    """The plane of a path and time.

    Attributes:
        places: Borders of the m cells along the path, as parts of its length in joint space, shape (m + 1,).
        times: Borders of the k intervals, shape (k + 1,) [s].
        blocked: Object too near to the robot in each cell, as a place in `objects`; -1 for none, shape (m,
            k).
        objects: Names of the objects that move, appear or expire.
        chosen_times: Times along the motion, increasing, shape (j,) [s].
        chosen_places: Its place along the path at each, shape (j,).
    """

    places: Floats
    times: Floats
    blocked: Ints
    objects: tuple[str, ...]
    chosen_times: Floats
    chosen_places: Floats


@checked
def forbidden_times(plan: Plan | Result, *, until: float | None = None) -> PathTime:
    """Find the places along the path of a plan, and the times, at which dynamic obstacles are in the way.

    Cells are sampled in their middle by the optimiser's distances, with the required clearance and the
    prediction error: this shows why a motion waits, and proves nothing.

    Args:
        until: End of the plane [s]; 1.5 times the duration of the motion when None.

    Raises:
        PlanningFailed: If the result has no plan.
        ShapeError: If the time is not positive.
    """
    planned = plan.require()
    motion, problem = planned.trajectory, planned.problem
    around = DynamicObstacles.of(problem.reduced, WorkCounts(), problem.evaluator)
    end = motion.duration * 1.5 if until is None else number("until", until)
    if end <= 0.0:
        raise ShapeError("until", f"must be after 0 s, is {end:g} s")
    count = int(np.clip(np.ceil(end / INTERVAL), 1, MOST_TIMES))
    times: Floats = np.linspace(0.0, end, count + 1)
    clock: Floats = np.union1d(np.linspace(0.0, motion.duration, count), motion.times)
    rows = motion(clock)
    way: Floats = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(rows, axis=0), axis=1)))
    way = way / way[-1]
    places: Floats = np.linspace(0.0, 1.0, PARTS + 1)
    blocked, objects = np.full((PARTS, count), FREE, dtype=np.int64), tuple[str, ...]()
    if around is not None:
        objects = tuple(around.timed.timings)
        blocked = _objects(around, objects, motion, (clock, way), (places, times))
    return PathTime(readonly(places), readonly(times), blocked, objects, readonly(clock), readonly(way))


def _objects(
    around: DynamicObstacles,
    objects: tuple[str, ...],
    motion: Trajectory,
    passed: tuple[Floats, Floats],
    grid: tuple[Floats, Floats],
) -> Ints:
    clock, way = passed
    checks = SampledChecks(around)
    checks.start_at(motion(np.zeros(1)))
    pairs = blocked_cells(checks, lambda place: motion(np.interp(place, way, clock)), *grid)
    which = {pair: objects.index(checks.mover(pair)) for pair in np.unique(pairs).tolist() if pair != FREE}
    found = pairs.copy()
    for pair, place in which.items():
        found[pairs == pair] = place
    return found


SIDE = 8
"""Cells along each side of the largest blocks: fewer sample distant objects, more have to be cut."""
STRETCH = 8 * SIDE
"""Intervals of time to sample before the reachable cells are computed."""
FREE = -1
"""In place of a pair, of a cell in which nothing is too near."""

Along: TypeAlias = Callable[[Floats], Floats]
"""The configurations (s, n) at parameters (s,) of a path."""


def blocked_cells(
    checks: SampledChecks, along: Along, edges: Floats, times: Floats, *, hurried: bool = False
) -> Ints:
    """Find the cells of path and time that dynamic obstacles block: the pair, or FREE, shape (m, k).

    A cell is sampled in its middle. Larger blocks come first: an object farther away than the travel within a
    block is clear of all of it, and a deeper contact blocks all of it.

    Args:
        edges: Parameters of the path at which its m cells begin and end, increasing, shape (m + 1,).
        times: When the k intervals begin and end, increasing, shape (k + 1,) [s].
        hurried: Whether the parameter is the time of the fastest motion along the path, no interval is longer
            than a cell, and all is over by the end of the times: then only cells that a motion can be in are
            sampled.
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
    def __init__(
        self, checks: SampledChecks, along: Along, edges: Floats, times: Floats, hurried: bool
    ) -> None:
        self.found = np.full((len(edges) - 1, len(times) - 1), FREE, dtype=np.int64)
        self._checks, self._along, self._edges, self._times = checks, along, edges, times
        self._hurried = hurried
        self._robot = self._travelled(along(edges), np.zeros(len(edges)))

    def look(self, parts: tuple[int, int], moments: tuple[int, int]) -> None:
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
        return np.append(0.0, np.cumsum(self._checks.obstacles.moved(positions, times)))


def _quarters(begin: Ints, size: int, last: Ints) -> Ints:
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
