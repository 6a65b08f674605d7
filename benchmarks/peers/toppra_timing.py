"""Timing by toppra, for planners that give a path without time."""

from collections.abc import Callable
from typing import Any

import numpy as np
import toppra
import toppra.algorithm
import toppra.constraint
from worker import Motion, denser

toppra.setup_logging("ERROR")


GRID = 600
"""Points at which toppra keeps the limits; accelerations are 0.5 % too large between them, with 100 6 %."""
SPACINGS = (np.inf, 0.4, 0.2, 0.1, 0.05, 0.025)


def time_path(
    robot: dict[str, Any],
    points: np.ndarray,
    free: Callable[[np.ndarray], bool],
    step: float,
) -> Motion | None:
    """Time a path under the robot's velocity and acceleration limits.

    toppra needs a smooth path: a cubic spline through the points. It leaves the polyline between
    them; where that is in collision, the spline goes through denser and denser points of the
    polyline. What toppra returns is a cubic spline in time, which the motion states exactly.

    Args:
        robot: With `velocity` and `acceleration` of each joint.
        points: Shape (k, n) [rad].
        free: Says whether a configuration is free.
        step: Largest distance between configurations of the spline that are tested [rad].
    """
    moved = np.linalg.norm(np.diff(points, axis=0), axis=1)
    points = points[np.concatenate(([True], moved > 1e-9))]
    for spacing in SPACINGS:
        spline = _spline(denser(points, spacing))
        count = int(np.ceil(spline.duration / step)) + 1
        if all(free(q) for q in spline(np.linspace(0.0, spline.duration, count))):
            break
    velocity, acceleration = (np.array(robot[key]) for key in ("velocity", "acceleration"))
    constraints = [
        toppra.constraint.JointVelocityConstraint(np.stack((-velocity, velocity), axis=1)),
        toppra.constraint.JointAccelerationConstraint(np.stack((-acceleration, acceleration), axis=1)),
    ]
    solver = toppra.algorithm.TOPPRA(
        constraints, spline, parametrizer="ParametrizeSpline", gridpt_min_nb_points=GRID
    )
    timed = solver.compute_trajectory()
    if timed is None:
        return None
    times = timed.cspl.x
    return Motion(times.tolist(), timed(times).tolist(), timed(times, 1).tolist())


def _spline(points: np.ndarray) -> toppra.SplineInterpolator:
    """Put a cubic spline through points, over the length of their polyline."""
    lengths = np.linalg.norm(np.diff(points, axis=0), axis=1)
    return toppra.SplineInterpolator(np.concatenate(([0.0], np.cumsum(lengths))), points)
