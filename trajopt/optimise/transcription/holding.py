"""Rows that keep a path where the joints can hold the load still, for joints that may be overloaded.

Retiming refuses a path on which a joint needs more than its effort limit just to stand still: no timing
helps there. So the program has rows against it, but only for joints that gravity can overload: the others
are shown never to need a row.
"""

import numpy as np

from trajopt.geometry import Evaluator
from trajopt.optimise.terms import Constraint, constraint
from trajopt.optimise.terms.gravity_torque import HoldingTorque
from trajopt.problem.problem import Problem
from trajopt.problem.requirements.joints import SHARE, GravityTorque
from trajopt.scene.gravity_bound import largest_gravity_torques
from trajopt.values.arrays import Floats

USABLE = 0.9
"""Part of the rest above the share that a path may use if necessary. The remainder, a hundredth of the limit,
is for the distance between samples and for corners that retiming rounds: they displace the payload by a few
millimetres, with levers of decimetres.
"""
LISTED = 0.3
"""A joint gets a row from this far below its share on: a step may change its load by about that."""


def holding_rows(problem: Problem, query: Evaluator, stops: Floats) -> tuple[Constraint, ...]:
    """Return the rows that keep the joints able to hold the load still; none if they always are.

    A joint may use its share, or its load at a fixed stop if that is larger. If the problem itself limits
    the share of gravity, that is enough.

    Args:
        problem: The problem.
        query: Of its reduced model.
        stops: Configurations that the motion passes in any case, shape (k, n) [rad | m].
    """
    effort = problem.limits.effort
    heavy = largest_gravity_torques(problem.reduced) > SHARE * effort
    if not heavy.any() or any(isinstance(item, GravityTorque) for item in problem.requirements):
        return ()
    given = np.abs(query.dynamics.gravity(stops).torque / effort).max(axis=0)
    share = np.minimum(np.maximum(given, SHARE), 1.0)
    bound = np.where(heavy, share, np.inf)
    return (
        constraint(
            HoldingTorque(effort, bound - LISTED),
            lower=-bound,
            upper=bound,
            tolerance=max(USABLE * (1.0 - float(share[heavy].max())), 1e-9),
            reach=LISTED,
        ),
    )
