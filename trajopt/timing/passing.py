"""Passing through knots: a corner whose rounding would cut off a knot is moved outwards by as much."""

from collections.abc import Callable

import numpy as np

from trajopt.native.timing import Outcome, Retimed
from trajopt.robot.limits import JointLimits
from trajopt.values.arrays import Floats, Ints

NEAR_ENOUGH = 1e-7
"""A knot counts as passed at this distance in each joint; controllers resolve no less [rad | m]."""
ROUNDS = 8
"""How often corners are moved at most. Each round leaves about a third of the miss: the spline passes a
corner by at most a third of its shorter leg, and cuts off so much of the corner's own movement."""
DEGREE = 3
"""Of the smooth path."""


def timed_through(
    knots: Floats, through: Ints, limits: JointLimits, timed: Callable[[Floats], Retimed]
) -> Retimed:
    """Time a polyline so that the smooth path passes through some of its knots.

    Args:
        knots: Of the polyline, shape (N, n) [rad | m].
        through: Which knots, shape (w,).
        limits: Of the joints: velocities scale the path parameter, and corners stay within positions.
        timed: Times a polyline.

    Returns:
        The timing that passes nearest to the knots in the joint that misses most, or one that failed.
    """
    corners, nearest, least = knots, timed(knots), np.inf
    found = nearest
    for _ in range(ROUNDS if len(through) else 0):
        if found.outcome is not Outcome.TIMED:
            break
        missed = knots[through] - _passed(found, corners, through, limits)
        worst = float(np.abs(missed).max())
        if worst < least:
            nearest, least = found, worst
        if worst <= NEAR_ENOUGH:
            break
        corners = corners.copy()
        corners[through] = np.clip(corners[through] + missed, limits.lower, limits.upper)
        found = timed(corners)
    return nearest


def _passed(found: Retimed, corners: Floats, through: Ints, limits: JointLimits) -> Floats:
    """Return where the smooth path is at the parameters of corners, shape (w, n)."""
    from scipy.interpolate import BSpline

    speed = np.where(np.isfinite(limits.velocity) & (limits.velocity > 0.0), limits.velocity, 1.0)
    steps = np.linalg.norm(np.diff(corners, axis=0) / speed, axis=1)
    parameters = np.concatenate(([0.0], np.cumsum(steps)))[through]
    ends = np.repeat(found.knots[[0, -1]], DEGREE).reshape(2, DEGREE)
    spline = BSpline(np.concatenate((ends[0], found.knots, ends[1])), found.control, DEGREE)
    relative: Floats = spline(np.clip(parameters, 0.0, found.knots[-1]))
    return corners[0] + relative
