"""Path and time: the places along a planned path, and the times, at which an object is in the way."""

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
"""Cells along the path: each about a hundredth of it, the resolution of a picture."""
MOST_TIMES = 1000
"""Largest number of intervals, each at least the sampling interval along a motion."""


@dataclass(frozen=True, eq=False)
class PathTime(Value):
    """The plane of a path and time.

    Attributes:
        places: Borders of the m cells along the path, as parts of its length in joint space from 0
            to 1, shape (m + 1,).
        times: Borders of the k intervals, shape (k + 1,) [s].
        blocked: Object that is too near to the robot in each cell, as a place in `objects`; -1 for
            none, shape (m, k).
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

    Cells are sampled in their middle by the optimiser's distances, with the required clearance and
    the prediction error: this shows why a motion waits. Proofs are in its certificate.

    Args:
        plan: The plan, or a result that has one.
        until: End of the plane [s]; when None, one and a half times the end of the motion.

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
