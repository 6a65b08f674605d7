"""The straight line in joint space, and the turn of each joint that is nearest."""

import numpy as np

from trajopt.arrays import Floats
from trajopt.model.limits import JointLimits


def straight_line(start: Floats, goal: Floats, knots: int) -> Floats:
    """Return knots evenly spaced between two configurations.

    Args:
        start: Shape (n,) [rad | m].
        goal: Shape (n,).
        knots: How many, ends included.

    Returns:
        Shape (knots, n).
    """
    return np.linspace(start, goal, knots)


def nearest_turn(start: Floats, goal: Floats, limits: JointLimits, revolute: Floats) -> Floats:
    """Return the goal with whole turns added so that each revolute joint travels least.

    Args:
        start: Shape (n,) [rad | m].
        goal: Shape (n,).
        limits: A turn is only taken where it stays inside the position limits.
        revolute: 1 for joints that turn, 0 for those that slide, shape (n,).
    """
    turn = 2.0 * np.pi * revolute
    best = np.array(goal)
    for count in (-1.0, 0.0, 1.0):
        turns = np.round((start - goal) / (2.0 * np.pi)) * revolute
        shifted = goal + turns * turn + count * turn
        inside = (shifted >= limits.lower) & (shifted <= limits.upper)
        outside_now = (best < limits.lower) | (best > limits.upper)
        nearer = np.abs(shifted - start) < np.abs(best - start)
        best = np.where(inside & (nearer | outside_now), shifted, best)
    return best
