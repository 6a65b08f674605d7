"""Stopping: how a start in motion comes to rest, as soon as the limits of its joints allow."""

from dataclasses import replace

import numpy as np

from trajopt.optimise.transcription.free_duration import SHORTEST
from trajopt.problem.problem import Problem
from trajopt.robot.limits import JointLimits
from trajopt.timing.joint_stops import stop_from
from trajopt.values.arrays import readonly
from trajopt.values.errors.arguments import checked
from trajopt.values.trajectory import Trajectory


@checked
def stopping_motion(problem: Problem) -> Trajectory:
    """Return a motion that brings a start in motion to rest as soon as the limits allow.

    It has three pieces of constant jerk: on to a deceleration, with it, and off it again. All joints brake
    together, so that the arm goes on nearly as it was going; where that takes one of them out of its limits,
    each brakes by itself.

    Args:
        problem: The problem; its start is in motion.
    """
    begin = np.stack((problem.reduced.start_positions, problem.start_velocities, problem.start_accelerations))
    return stop_from(begin, with_jerk(problem.limits))


def with_jerk(limits: JointLimits) -> JointLimits:
    """Return limits with the jerk limited for every joint: what stops and goes on has no jump between.

    Where none is stated, an acceleration takes as long to rise as the shortest motion there is.
    """
    return replace(limits, jerk=readonly(np.minimum(limits.jerk, limits.acceleration / SHORTEST)))
