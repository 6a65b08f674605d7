"""Goal configurations of a problem, for who makes problems or picks one by hand."""

import numpy as np

from trajopt.arrays import Floats
from trajopt.kinematics.goal_candidates import goal_candidates
from trajopt.problem import Problem
from trajopt.query import Counts


def goal_configurations(problem: Problem, *, rng: np.random.Generator | None = None) -> tuple[Floats, ...]:
    """Return configurations at which a motion may end: they hold goal and path constraints, clear of all.

    Constraints in code of your own are not looked at.

    Args:
        problem: What the motion must achieve.
        rng: Draws the starts of the search; a fixed seed when None.

    Returns:
        Positions of the group's joints, each of shape (n,) [rad | m], nearest to the start first;
        none if none was found.
    """
    wanted = (*problem.goals, *problem.requirements_at(len(problem.waypoint_names) + 1))
    return goal_candidates(problem.reduced, wanted, rng=rng or np.random.default_rng(0), counts=Counts()).free
