"""Passing through knots: move a corner outwards if its rounding would cut off a required knot."""

from collections.abc import Callable

import numpy as np

from trajopt.native import timing
from trajopt.robot.joints import JointLimits
from trajopt.values.arrays import Floats, Ints

NEAR_ENOUGH = 1e-7
"""Joint distance within which a knot is passed, below the resolution of controllers [rad | m]."""
ROUNDS = 8
"""Most rounds of moving corners. Each round leaves about a third of the error: the spline passes a corner
within a third of its shorter leg and cuts off the same share of the corner's displacement.
"""
DEGREE = 3
"""Degree of the smooth path."""


def timed_through(
    knots: Floats, through: Ints, limits: JointLimits, time_path: Callable[[Floats], timing.Retimed]
) -> timing.Retimed:
    """Time a polyline so that the smooth path passes through some of its knots.

    Args:
        knots: Polyline, shape (N, n) [rad | m].
        through: Indices of the knots to pass, shape (w,).
        limits: Joint limits: velocities scale the path parameter, positions bound the corners.
        time_path: Times a polyline.

    Returns:
        The timing with the smallest largest joint distance from the knots, or a failed one.
    """
    corners, nearest, least = knots, time_path(knots), np.inf
    found = nearest
    for _ in range(ROUNDS if len(through) else 0):
        if found.outcome is not timing.Outcome.TIMED:
            break
        missed = knots[through] - _passed(found, corners, through, limits)
        worst = float(np.abs(missed).max())
        if worst < least:
            nearest, least = found, worst
        if worst <= NEAR_ENOUGH:
            break
        corners = corners.copy()
        corners[through] = np.clip(corners[through] + missed, limits.lower, limits.upper)
        found = time_path(corners)
    return nearest


def _passed(found: timing.Retimed, corners: Floats, through: Ints, limits: JointLimits) -> Floats:
    """Return the points of the smooth path at the corners' parameters, shape (w, n)."""
    from scipy.interpolate import BSpline

    speed = np.where(np.isfinite(limits.velocity) & (limits.velocity > 0.0), limits.velocity, 1.0)
    steps = np.linalg.norm(np.diff(corners, axis=0) / speed, axis=1)
    parameters = np.concatenate(([0.0], np.cumsum(steps)))[through]
    ends = np.repeat(found.knots[[0, -1]], DEGREE).reshape(2, DEGREE)
    spline = BSpline(np.concatenate((ends[0], found.knots, ends[1])), found.control, DEGREE)
    relative: Floats = spline(np.clip(parameters, 0.0, found.knots[-1]))
    return corners[0] + relative
