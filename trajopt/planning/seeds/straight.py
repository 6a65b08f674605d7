"""The straight line in joint space."""

import numpy as np

from trajopt.arrays import Floats


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
