"""Stopping: how a start in motion comes to rest, as soon as the limits of its joints allow."""

from dataclasses import replace

import numpy as np

from trajopt.arrays import readonly
from trajopt.errors.arguments import checked
from trajopt.model.limits import JointLimits
from trajopt.model.trajectory import Trajectory
from trajopt.problem import Problem
from trajopt.retime.joint_stops import stop_from
from trajopt.transcription.free_duration import SHORTEST


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
