"""Joint stops: each joint brakes as hard as its limits allow and may leave the path."""

import numpy as np

from trajopt.native import timing
from trajopt.robot.limits import EXCESS, JointLimits
from trajopt.values.arrays import Floats
from trajopt.values.cached import cached_per_value
from trajopt.values.trajectory import Trajectory

TICK = 1e-3
"""Pieces of a stop last multiples of this, the cycle of the fastest controllers [s].

In much shorter pieces the jerk of a polynomial is lost to rounding.
"""


def stop_from(begin: Floats, limits: JointLimits) -> Trajectory:
    """Return a motion that stops the joints as fast as their limits allow.

    It has three pieces of constant jerk: ramp up, hold and ramp down the deceleration. All joints brake
    together, which nearly preserves the direction of motion; if this violates a limit, each brakes alone.

    Args:
        begin: Positions, velocities and accelerations, shape (3, n).
        limits: Joint limits, with finite acceleration and jerk limits.
    """
    times, rows = timing.stop_from(begin, _rows(limits), TICK, EXCESS)
    return Trajectory(limits.joint_names, times, *rows)


def stop_after(begin: Floats, end: Floats, duration: float, limits: JointLimits) -> Trajectory:
    """Return a motion of one piece, followed by the stop of `stop_from`.

    Args:
        begin: Positions, velocities and accelerations at the start, shape (3, n).
        end: Those at the end of the piece, shape (3, n).
        duration: Duration of the piece [s].
        limits: Joint limits, with finite acceleration and jerk limits.
    """
    times, rows = timing.stop_from(end, _rows(limits), TICK, EXCESS)
    whole = np.concatenate((begin[:, None], rows), axis=1)
    return Trajectory(limits.joint_names, np.append(0.0, duration + times), *whole)


@cached_per_value
def _rows(limits: JointLimits) -> Floats:
    return np.stack((limits.lower, limits.upper, limits.velocity, limits.acceleration, limits.jerk))
