"""Tracking: whether a robot is where it has to be."""

import numpy as np

from trajopt.driving.committed_motion import CommittedMotion
from trajopt.driving.executor import Executor
from trajopt.robot.loading.pinocchio_model import joint_unit
from trajopt.robot.robot import Robot
from trajopt.values.printed import in_joint_position


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
    return f"{name} is at {where}, has to be at {should}"
