"""Path and time: where along a planned path, and when, something is in the way."""

from dataclasses import dataclass

import numpy as np

from trajopt.geometry import DynamicObstacles, WorkCounts
from trajopt.planning.moving.blocked_cells import FREE, blocked_cells
from trajopt.planning.moving.sampled_checks import INTERVAL, SampledChecks
from trajopt.planning.result import Plan, Result
from trajopt.values.arrays import Floats, Ints, Value, number, readonly
from trajopt.values.errors import ShapeError
from trajopt.values.errors.arguments import checked
from trajopt.values.trajectory import Trajectory

PARTS = 96
"""Cells along the path: each about a hundredth of it, which is what a picture shows."""
MOST_TIMES = 1000
"""Intervals of time, as long as between two looks along a motion, or longer where there would be more."""


@dataclass(frozen=True, eq=False)
class PathTime(Value):
    """The plane of a path and time.

    Attributes:
        places: Where the m cells along the path begin and end, as parts of its length in joint space from 0
            to 1, shape (m + 1,).
        times: When the k intervals begin and end, shape (k + 1,) [s].
        blocked: Which of the objects is too near to the robot in each cell, as a place in `objects`; -1 where
            none is, shape (m, k).
        objects: Names of what moves, appears or expires.
        chosen_times: Times along the motion, increasing, shape (j,) [s].
        chosen_places: Where along the path it is then, shape (j,).
    """

    places: Floats
    times: Floats
    blocked: Ints
    objects: tuple[str, ...]
    chosen_times: Floats
    chosen_places: Floats


@checked
def forbidden_times(plan: Plan | Result, *, until: float | None = None) -> PathTime:
    """Find where along the path of a plan, and when, things that change with time are in the way.

    Cells are looked at in their middle by the optimiser's distances, with the clearance that is required and
    the error of what is predicted: this shows why a motion waits. What is proven is in its certificate.

    Args:
        plan: The plan, or a result that has one.
        until: Until when [s]; when None, until the end of the motion and half as long again.

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
    """Return the objects that block cells, by the pairs that do."""
    clock, way = passed
    checks = SampledChecks(around)
    checks.start_at(motion(np.zeros(1)))
    pairs = blocked_cells(checks, lambda place: motion(np.interp(place, way, clock)), *grid)
    which = {pair: objects.index(checks.mover(pair)) for pair in np.unique(pairs).tolist() if pair != FREE}
    found = pairs.copy()
    for pair, place in which.items():
        found[pairs == pair] = place
    return found
