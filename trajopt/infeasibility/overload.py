"""Proofs that no configuration of a box can be held: gravity overloads a joint everywhere in it."""

import numpy as np

from trajopt.arrays import Floats
from trajopt.model.gravity_bound import largest_gravity_slopes
from trajopt.problem import Problem
from trajopt.query.dynamics import DynamicsQuery


def box_overloads(problem: Problem, lower: Floats, upper: Floats) -> bool:
    """Say whether a joint is proven to be too weak to hold still at every configuration of a box.

    Args:
        problem: The problem; gives the load and the limits.
        lower: Shape (n,) [rad | m].
        upper: Shape (n,) [rad | m].
    """
    middle, half = 0.5 * (lower + upper), 0.5 * (upper - lower)
    torque = DynamicsQuery.loaded(problem.reduced).gravity(middle[None]).torque[0]
    excess = np.abs(torque) - problem.limits.effort
    return bool((excess > largest_gravity_slopes(problem.reduced) @ half).any())
