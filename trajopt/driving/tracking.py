"""Tracking: whether a robot is where it has to be."""

import numpy as np

from trajopt.driving.committed_motion import CommittedMotion
from trajopt.driving.executor import Executor
from trajopt.problem.problem import Problem
from trajopt.robot.loading.pinocchio_model import joint_unit
from trajopt.robot.robot import Robot
from trajopt.values.printed import in_joint_position, in_range, in_unit

ROUNDING = 1e-9
"""A joint that is outside its limits by less than this is at its limit [rad | m]."""


def off_track(executor: Executor, committed: CommittedMotion, robot: Robot) -> str:
    """Say which joint is farther from where it has to be than the executor's tolerance; empty if none is."""
    state = executor.state()
    wanted = committed(state.stamp)[0]
    away = np.abs(state.positions - wanted) - executor.tolerance
    worst = int(away.argmax())
    if away[worst] <= 0.0:
        return ""
    name = executor.joint_names[worst]
    unit = joint_unit(robot.model, name)
    where, should = (in_joint_position(float(each[worst]), unit) for each in (state.positions, wanted))
    allowed = in_unit(float(executor.tolerance[worst]), unit)
    return f"{name} is at {where}, has to be at {should} within {allowed}"


def outside_limits(problem: Problem, executor: Executor) -> str:
    """List the joints outside the group that stand outside their limits; empty if there are none.

    Args:
        problem: Its start is where the executor has the joints.
        executor: What holds them there, within its tolerance of each.
    """
    robot, reduced = problem.scene.robot, problem.reduced
    limits, stands, driven = robot.limits, problem.start_positions, executor.joint_names
    found: list[str] = []
    for index, name in enumerate(robot.joint_names):
        lower, upper, here = (float(each[index]) for each in (limits.lower, limits.upper, stands))
        if name in reduced.moving_joints or lower - ROUNDING <= here <= upper + ROUNDING:
            continue
        unit = joint_unit(robot.model, name)
        held = "stays there"
        if name in driven:
            held = f"is held there within {in_unit(float(executor.tolerance[driven.index(name)]), unit)}"
        elif name in robot.mimics:
            held = f"follows {robot.mimics[name].source}"
        where = in_joint_position(here, unit)
        found.append(
            f"{name} stands at {where}, outside its limits {in_range(lower, upper, unit)}, and {held}"
        )
    return "; ".join(found)
