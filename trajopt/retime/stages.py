"""What limits a time-optimal profile on a grid: linear constraints on path acceleration and squared speed.

Source: Pham and Pham, A new approach to time-optimal path parameterization based on reachability
analysis, IEEE T-RO 34(3), 2018.
"""

from dataclasses import dataclass

import numpy as np

from trajopt.arrays import Floats

LARGEST_SQUARED_SPEED = 1e8
"""Bound of x where no velocity limit binds, since all joints turn back at once [-]."""

LEAST_ROOM = 1e-6
"""Part of each limit that is left to motion even where holding still takes more than all of it."""


@dataclass(frozen=True, eq=False)
class Rows:
    """Limits |a u + b x + c| <= limit at every grid point, one column a limit.

    Attributes:
        a: Factor of the path acceleration, shape (k, m).
        b: Factor of the squared path speed, shape (k, m).
        c: What remains at rest (gravity), shape (k, m).
    """

    a: Floats
    b: Floats
    c: Floats


def stations(s: Floats) -> Floats:
    """Where control values stand: start, interval middles, goal: (k,) -> (k + 1,)."""
    return np.concatenate((s[:1], (s[:-1] + s[1:]) / 2.0, s[-1:]))


def squared_speed_bound(derivative: Floats, velocity: Floats) -> Floats:
    """Bound of x = (ds/dt)² by the velocity limits.

    Args:
        derivative: dq/ds at the stations, shape (k, n).
        velocity: Velocity limits at the stations, shape (k, n).

    Returns:
        Shape (k,).
    """
    slope = np.abs(derivative)
    moving = slope > velocity / np.sqrt(LARGEST_SQUARED_SPEED)
    speed = np.where(moving, velocity / np.where(moving, slope, 1.0), np.sqrt(LARGEST_SQUARED_SPEED))
    return speed.min(axis=1) ** 2
