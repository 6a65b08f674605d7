"""Which joints cannot hold the arm still at a configuration."""

from dataclasses import replace

import numpy as np

from trajopt.arrays import Floats
from trajopt.model.payload import loaded_model
from trajopt.problem import Problem
from trajopt.query.dynamics import dynamics_of
from trajopt.reasons import Block, BlockKind


def overloaded(problem: Problem, positions: Floats) -> tuple[Block, ...]:
    """Return the joints whose effort limit is less than what holding still takes, the worst first.

    Args:
        problem: The problem; gives the load and the limits.
        positions: Of the group's joints, shape (n,) [rad | m].
    """
    reduced, limits = problem.reduced, problem.limits
    loaded = replace(reduced, model=loaded_model(reduced))
    still = np.zeros((1, len(positions)))
    need = np.abs(dynamics_of(loaded).torque(positions[None], still, still)[0])
    excess = need - limits.effort
    return tuple(
        Block(
            kind=BlockKind.EFFORT,
            subjects=(reduced.joint_names[joint],),
            amount=float(excess[joint]),
            place=None,
            words=(
                f"{reduced.joint_names[joint]} needs {need[joint]:.4g} to hold still, its effort limit is "
                f"{limits.effort[joint]:.4g}"
            ),
        )
        for joint in map(int, np.argsort(-excess))
        if excess[joint] > 0.0
    )
