"""Test of a motion against acceleration and jerk limits between its points."""

import numpy as np

from trajopt.native import timing
from trajopt.robot.limits import EXCESS, JointLimits
from trajopt.values.trajectory import Trajectory


def holds_limits(motion: Trajectory, limits: JointLimits) -> bool:
    """Whether a motion of quintics holds acceleration and jerk limits, by its extremes.

    Args:
        motion: Motion of the limits' joints, in their order.
        limits: Joint limits.
    """
    widths = np.diff(motion.times)
    _, least, largest = timing.motion_extremes(motion.coefficients, widths)
    accelerations = np.maximum(-least, largest)
    # The jerk of a quintic is a parabola: largest at an end, or where it turns.
    square, slope, begin = (
        60.0 * motion.coefficients[0],
        24.0 * motion.coefficients[1],
        6.0 * motion.coefficients[2],
    )
    with np.errstate(divide="ignore", invalid="ignore"):
        turn = np.clip(np.nan_to_num(-slope / (2.0 * square)), 0.0, widths[:, None])
    at = np.stack((np.zeros_like(turn), turn, np.broadcast_to(widths[:, None], turn.shape)))
    jerks = np.abs(begin + at * (slope + at * square))
    return bool(
        (accelerations <= limits.acceleration * (1.0 + EXCESS)).all()
        and (jerks <= limits.jerk * (1.0 + EXCESS)).all()
    )
