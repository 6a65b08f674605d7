"""Goals that turn a joint without limits the long way round: kept as they are asked for, and named."""

import numpy as np

from trajopt.problem.problem import Problem
from trajopt.problem.requirements import JointPositions
from trajopt.robot.loading.pinocchio_model import joint_unit
from trajopt.values.printed import in_degrees

TURN = 2.0 * np.pi


def long_turns(problem: Problem) -> tuple[str, ...]:
    """Return a sentence on each joint without limits whose goal is more than half a turn away.

    The position is what was asked for, and turns may be meant, as where a cable is unwound; but the same
    angle is nearer.

    Args:
        problem: The problem; of a goal set each goal is looked at.
    """
    found: dict[str, None] = {}
    start, turning = _turning(problem)
    for one in problem.alternatives.values() or (problem,):
        for goal in one.goals:
            if not isinstance(goal, JointPositions):
                continue
            for joint in turning.intersection(goal.positions):
                way = goal.positions[joint] - start[joint]
                slack = goal.above[joint] if way < 0.0 else goal.below[joint]
                if abs(way) - slack > np.pi:
                    near = goal.positions[joint] - TURN * round(way / TURN)
                    found[
                        f"{joint} is asked to turn by {in_degrees(abs(way))}: {near:.4g} rad is the same "
                        f"angle, {in_degrees(abs(near - start[joint]))} away"
                    ] = None
    return tuple(sorted(found))


def _turning(problem: Problem) -> tuple[dict[str, float], set[str]]:
    """Return where the group's joints start, and which of them turn without limits."""
    reduced = problem.reduced
    free = np.isinf(reduced.limits.lower) & np.isinf(reduced.limits.upper)
    return (
        dict(zip(reduced.joint_names, reduced.start_positions.tolist(), strict=True)),
        {
            name
            for name, without in zip(reduced.joint_names, free.tolist(), strict=True)
            if without and joint_unit(problem.scene.robot.model, name) == "rad"
        },
    )
