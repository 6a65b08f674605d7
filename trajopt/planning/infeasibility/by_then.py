"""Where joints can be by a time: the farthest that their limits let them get from where they start."""

from math import inf, isfinite, sqrt

import numpy as np

from trajopt.problem.problem import Problem
from trajopt.robot.limits import EXCESS
from trajopt.values.arrays import Floats

START_ERROR = 1e-6
"""Motions may begin so far beside the start, and so much faster [rad | m, rad/s | m/s]."""


def by_then(problem: Problem, time: float) -> tuple[Floats, Floats]:
    """Return a box that holds every configuration of every motion of a problem up to a time.

    Each joint is bounded by its own limits of position, velocity, acceleration and jerk alone, so the
    bound holds whatever the others do.

    Args:
        problem: The problem; its start may be in motion.
        time: From the start [s].

    Returns:
        Lower and upper bounds, shape (n,) each [rad | m]; infinite where no limit bounds a joint.
    """
    limits, start = problem.limits, problem.reduced.start_positions
    rows = zip(
        problem.start_velocities.tolist(),
        problem.start_accelerations.tolist(),
        (limits.velocity * (1.0 + EXCESS)).tolist(),
        (limits.acceleration * (1.0 + EXCESS)).tolist(),
        (limits.jerk * (1.0 + EXCESS)).tolist(),
        strict=True,
    )
    ways = np.array(
        [
            [farthest(time, side * speed, side * gain, *bounds) for side in (-1.0, 1.0)]
            for speed, gain, *bounds in rows
        ]
    ).reshape(-1, 2)
    lower, upper = start - ways[:, 0] - START_ERROR, start + ways[:, 1] + START_ERROR
    return np.maximum(lower, limits.lower - START_ERROR), np.minimum(upper, limits.upper + START_ERROR)


def farthest(time: float, speed: float, gain: float, fastest: float, hardest: float, jerk: float) -> float:
    """Bound how far a joint can get one way in a time: gaining as hard as it may from the beginning.

    Args:
        time: From the start [s].
        speed: Its velocity that way; the other way counts as none.
        gain: Its acceleration that way; the other way counts as none.
        fastest: Limit of its velocity, may be infinite.
        hardest: Limit of its acceleration, may be infinite.
        jerk: Limit of its jerk, may be infinite.

    Returns:
        The travel [rad | m].
    """
    speed, gain = max(speed, 0.0) + START_ERROR, max(gain, 0.0)
    fastest, hardest = max(fastest, speed), max(hardest, gain)
    travel, left = 0.0, time
    if isfinite(jerk):
        reached = (sqrt(gain**2 + 2.0 * jerk * (fastest - speed)) - gain) / jerk
        t = min(left, (hardest - gain) / jerk, reached)
        travel = t * (speed + t * (gain / 2.0 + t * jerk / 6.0))
        speed += t * (gain + t * jerk / 2.0)
        left -= t
    if isfinite(hardest) and left > 0.0:
        t = min(left, max(fastest - speed, 0.0) / hardest) if hardest > 0.0 else left
        travel += t * (speed + t * hardest / 2.0)
        left -= t
    return travel + (left * fastest if left > 0.0 else 0.0) if fastest < inf or left <= 0.0 else inf
