"""Stops of joints: each brakes as hard as its limits allow, off the path that they were on."""

import numpy as np

from trajopt.native import timing
from trajopt.robot.limits import EXCESS, JointLimits
from trajopt.values.arrays import Floats
from trajopt.values.cached import cached_per_value
from trajopt.values.trajectory import Trajectory

TICK = 1e-3
"""Pieces of a stop take multiples of this [s], the cycle of the fastest controllers: in much shorter ones the
jerk of a polynomial is lost to rounding."""


def stop_from(begin: Floats, limits: JointLimits) -> Trajectory:
    """Return a motion that brings joints to rest as soon as their limits allow.

    It has three pieces of constant jerk: on to a deceleration, with it, and off it again. All joints brake
    together, so that the arm goes on nearly as it was going; where that takes one of them out of its limits,
    each brakes by itself.

    Args:
        begin: Positions, velocities and accelerations, shape (3, n).
        limits: Of the joints, with acceleration and jerk of each limited.
    """
    times, rows = timing.stop_from(begin, _rows(limits), TICK, EXCESS)
    return Trajectory(limits.joint_names, times, *rows)


def stop_after(begin: Floats, end: Floats, duration: float, limits: JointLimits) -> Trajectory:
    """Return a motion of one piece, and the stop of `stop_from` after it.

    Args:
        begin: Positions, velocities and accelerations at its begin, shape (3, n).
        end: The same at the end of the piece, shape (3, n).
        duration: Of the piece [s].
        limits: Of the joints, with acceleration and jerk of each limited.
    """
    times, rows = timing.stop_from(end, _rows(limits), TICK, EXCESS)
    whole = np.concatenate((begin[:, None], rows), axis=1)
    return Trajectory(limits.joint_names, np.append(0.0, duration + times), *whole)


@cached_per_value
def _rows(limits: JointLimits) -> Floats:
    """Return the limits as the core takes them, shape (5, n)."""
    return np.stack((limits.lower, limits.upper, limits.velocity, limits.acceleration, limits.jerk))
