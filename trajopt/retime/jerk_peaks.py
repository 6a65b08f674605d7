"""Exact extremes of the jerk of quintic pieces."""

import numpy as np

from trajopt.arrays import Floats
from trajopt.model.trajectory import Trajectory


def jerk_peaks(trajectory: Trajectory) -> Floats:
    """Find the largest absolute jerk in each piece: at its ends, or where the parabola turns.

    Args:
        trajectory: Quintic, of k points and n joints.

    Returns:
        Shape (k - 1, n) [rad/s^3 | m/s^3].
    """
    c, h = trajectory.coefficients, np.diff(trajectory.times)[:, None]
    square, rate, first = 60.0 * c[0], 24.0 * c[1], 6.0 * c[2]
    bent = square != 0.0
    turn = np.clip(np.where(bent, -rate / (2.0 * np.where(bent, square, 1.0)), 0.0), 0.0, h)
    values = ((square * t + rate) * t + first for t in (turn, h))
    return np.maximum.reduce([np.abs(first), *(np.abs(value) for value in values)])
