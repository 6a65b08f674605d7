"""A proof that there is no path from the start to the goal: a cut that no configuration can cross.

A joint that starts on one side of a value and must end on the other has to pass it. If every
configuration with the joint at that value is in collision, whatever all other joints do, nothing passes.
A pair that must keep a clearance collides, in this sense, where it is nearer than that.
The cut is covered by boxes of configurations, as `cover` says.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from trajopt.optimise.terms.joint_positions import without_followers
from trajopt.planning.infeasibility.cover import Cover, endless, whole_range
from trajopt.problem.problem import Problem
from trajopt.problem.requirements import JointPositions
from trajopt.scene.reduced import ReducedModel
from trajopt.values.arrays import Floats

SHARES = (0.5, 0.25, 0.75, 0.125, 0.375, 0.625, 0.875)
"""Where between start and goal each joint is cut."""
MOST_BOXES = 30000
"""Boxes that are examined, of all cuts together, before the question is left undecided."""


@dataclass(frozen=True, kw_only=True)
class ClosedCut:
    """A value of a joint that every motion to the goal has to pass, and none can.

    Attributes:
        joint: The joint.
        position: The value [rad | m].
        pairs: Links and objects whose contact, or required clearance, closes the cut, most frequent first.
        boxes: Boxes of configurations that were examined.
    """

    joint: str
    position: float
    pairs: tuple[tuple[str, str], ...]
    boxes: int


def closed_cut(
    problem: Problem, *, apart: Floats | None = None, shares: Sequence[float] = SHARES
) -> ClosedCut | None:
    """Look for a cut between the start and a goal of joints that no configuration can cross.

    Args:
        problem: The problem.
        apart: Distance that pairs would have to keep on the cut, shape (p,) [m], -inf for those that need
            none; what is required of them when None.
        shares: Where between start and goal each joint is cut.

    Returns:
        The first that is proven; None if none is, which proves nothing.
    """
    if endless(problem.reduced).any():
        return None
    cover = Cover(problem.reduced, MOST_BOXES, apart)
    for joint, (start, goal) in _must_move(problem).items():
        for share in shares:
            value = start + share * (goal - start)
            closed = cover.close(*_whole(problem.reduced, joint, value))
            if closed is not None:
                name = problem.reduced.joint_names[joint]
                return ClosedCut(joint=name, position=value, pairs=closed.pairs, boxes=closed.boxes)
    return None


def _must_move(problem: Problem) -> dict[int, tuple[float, float]]:
    """Return where joints with a goal of their own begin and where they must come to at least."""
    reduced, found = problem.reduced, dict[int, tuple[float, float]]()
    for goal in without_followers(problem.goals, reduced):
        if isinstance(goal, JointPositions):
            for joint, wanted in goal.positions.items():
                if joint in reduced.joint_names:
                    place = reduced.joint_names.index(joint)
                    begin = float(reduced.start_positions[place])
                    end = float(np.clip(begin, wanted - goal.below[joint], wanted + goal.above[joint]))
                    if end != begin:
                        found[place] = (begin, end)
    return dict(sorted(found.items()))


def _whole(reduced: ReducedModel, joint: int, value: float) -> tuple[Floats, Floats]:
    """Return middle and half width of the box of all configurations on a cut, shape (n,) each."""
    middle, half = whole_range(reduced)
    middle[joint], half[joint] = value, 0.0
    return middle, half
