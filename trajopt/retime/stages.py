"""The limits of a time-optimal profile as half-planes in two neighbouring control values.

A profile (see `trajopt.retime.profile`) is given by control values y at the `stations`: start, middles
of the grid intervals, goal. At the grid point between two stations its path acceleration is
u = (y_after - y_before) / (2 distance), and its squared speed x = (ds/dt)² lies between the two.
So a limit |a u + b x + c| <= limit holds at the grid point if it holds with either of them for x:

    onward * y_after + held * y_before <= room.

(With the average itself for x, a large value could pay for a small neighbour, and profiles jitter.)

Source: Pham and Pham, A new approach to time-optimal path parameterization based on reachability
analysis, IEEE T-RO 34(3), 2018; here on the stations, so that what is bounded is the smooth profile.
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


@dataclass(frozen=True, eq=False)
class Stages:
    """Half-planes at all grid points, shape (k, 4 m) each.

    Attributes:
        onward: Factors of the control value after the grid point.
        held: Factors of the control value before it.
    """

    onward: Floats
    held: Floats


def stations(s: Floats) -> Floats:
    """Where control values stand: start, interval middles, goal: (k,) -> (k + 1,)."""
    return np.concatenate((s[:1], (s[:-1] + s[1:]) / 2.0, s[-1:]))


def stages(s: Floats, rows: Rows) -> Stages:
    """Write the limits as half-planes.

    Args:
        s: Grid, increasing, shape (k,).
        rows: The limits at the grid points.
    """
    a = rows.a / (2.0 * np.diff(stations(s))[:, None])
    b = rows.b.copy()
    b[[0, -1]] = 0.0  # at rest
    onward, held = np.hstack((a, a + b)), np.hstack((b - a, -a))
    return Stages(np.hstack((onward, -onward)), np.hstack((held, -held)))


def rooms(rows: Rows, limit: Floats) -> Floats:
    """Right-hand sides of the half-planes: limits (k, m) -> (k, 4 m), never less than a trifle."""
    least = LEAST_ROOM * limit
    above, below = np.maximum(limit - rows.c, least), np.maximum(limit + rows.c, least)
    return np.hstack((above, above, below, below))


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
