"""Which joints cannot hold the arm still at a configuration."""

from dataclasses import replace

import numpy as np

from trajopt.arrays import Floats
from trajopt.infeasibility.chain import Chain
from trajopt.infeasibility.reasons import Block, BlockKind
from trajopt.model.payload import loaded_model
from trajopt.problem import Problem
from trajopt.query.dynamics import DynamicsQuery


def overloaded(problem: Problem, positions: Floats) -> tuple[Block, ...]:
    """Return the joints whose effort limit is less than what holding still takes, the worst first.

    Args:
        problem: The problem; gives the load and the limits.
        positions: Of the group's joints, shape (n,) [rad | m].
    """
    reduced, limits = problem.reduced, problem.limits
    loaded = replace(reduced, model=loaded_model(reduced))
    still = np.zeros((1, len(positions)))
    need = np.abs(DynamicsQuery(loaded).torque(positions[None], still, still)[0])
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


def largest_change(problem: Problem, half: Floats) -> float:
    """Bound how much what it takes to hold still differs near a configuration, for any joint [Nm | N].

    A joint that turns by an angle changes the torque of another by no more than the angle times all weight
    times its largest lever.

    Args:
        problem: The problem; gives the load.
        half: How far each of the group's joints may be from where it was looked at, shape (n,) [rad | m].
    """
    reduced, chain = problem.reduced, Chain(problem.reduced)
    model = loaded_model(reduced)
    weight = float(np.linalg.norm(model.gravity.linear))
    levers = (
        model.inertias[joint].mass
        * max(1.0, chain.longest(chain.joints(joint)[0], joint, model.inertias[joint].lever))
        for joint in range(1, model.njoints)
    )
    moved = np.abs(reduced.mimic_matrix)
    return float(weight * sum(levers) * moved.sum(axis=0).max() * (moved @ half).sum())
