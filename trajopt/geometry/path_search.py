"""Path search: a collision-free path from one configuration to one of several others.

RRT-Connect, with a shortened path; compiled, with a generator of its own.
Sources: Kuffner and LaValle, ICRA 2000; Geraerts and Overmars, IJRR 2007 (shortening).
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from trajopt.geometry.evaluation import Evaluator
from trajopt.geometry.query import cell
from trajopt.native import proximity
from trajopt.values.arrays import Floats, Value


@dataclass(frozen=True, eq=False)
class SearchSpace(Value):
    """Space of a path search.

    Attributes:
        lower: Of the joints searched, shape (n,) [rad | m].
        upper: Shape (n,).
        unit: Of length in each joint, shape (n,): no branch of the trees is longer than one in all.
        reach: Distance that each pair keeps, shape (p,) [m].
        step: Largest travel of a body between two checked configurations [m].
    """

    lower: Floats
    upper: Floats
    unit: Floats
    reach: Floats
    step: float


def search_path(
    query: Evaluator,
    start: Floats,
    goals: Floats,
    space: SearchSpace,
    *,
    checked: int,
    shortening: int,
    seed: int,
    check: Callable[[], None],
) -> Floats | None:
    """Search a path; the interpreter's lock is released meanwhile.

    Args:
        query: Of the robot and its surroundings; its counts include the work done.
        start: Shape (n,) [rad | m].
        goals: Possible ends, shape (g, n).
        space: Space of the search; a start or goal outside is added to it.
        checked: Configurations that are checked before the search gives up.
        shortening: Configurations that shortening may check, in each of its three passes.
        seed: Of the random numbers, at least 0: the same on every platform.
        check: Called every few milliseconds; may raise to stop.

    Returns:
        Corners, shape (k, n), with straight lines between them, both ends included; None if none was found.
    """
    ends = np.concatenate((start[None], goals))
    counts, before = query.counts, query.counts.forward_kinematics

    def going_on(looked: int) -> None:
        counts.forward_kinematics = before + looked
        check()

    corners, looked, bounds, distances = proximity.search_path(
        cell=cell(query.reduced),
        start=np.ascontiguousarray(start),
        goals=np.ascontiguousarray(goals),
        lower=np.minimum(space.lower, ends.min(axis=0)),
        upper=np.maximum(space.upper, ends.max(axis=0)),
        unit=space.unit,
        reach=space.reach,
        step=space.step,
        looks=checked,
        shortening=shortening,
        seed=seed,
        check=going_on,
    )
    counts.forward_kinematics = before + looked
    counts.bounds += bounds
    counts.distances += distances
    if not len(corners):
        return None
    # They were scaled to units and back.
    corners[0] = start
    corners[-1] = goals[np.argmin(np.abs(goals - corners[-1]).max(axis=1))]
    return corners
