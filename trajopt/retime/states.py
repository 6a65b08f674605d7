"""Positions, velocities and accelerations of a trajectory at the same part of many pieces."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from trajopt.arrays import Floats, Ints
from trajopt.model.trajectory import Trajectory


class States(NamedTuple):
    """States of n joints at S moments.

    Attributes:
        q: Positions, shape (S, n) [rad | m].
        v: Velocities, shape (S, n) [rad/s | m/s].
        a: Accelerations, shape (S, n) [rad/s^2 | m/s^2].
    """

    q: Floats
    v: Floats
    a: Floats


def at_points(trajectory: Trajectory) -> States:
    """Return the states at the points of a quintic trajectory."""
    assert trajectory.velocities is not None and trajectory.accelerations is not None
    return States(trajectory.positions, trajectory.velocities, trajectory.accelerations)


def within(trajectory: Trajectory, part: float, pieces: Ints | slice = slice(None)) -> States:
    """Evaluate a quintic trajectory at one part of some of its pieces.

    Args:
        trajectory: Of k points.
        part: How much of the time of each piece has passed, from 0 to 1.
        pieces: Which pieces; all k - 1 by default.
    """
    c0, c1, c2, c3, c4, c5 = trajectory.coefficients[:, pieces]
    t = part * np.diff(trajectory.times)[pieces, None]
    return States(
        ((((c0 * t + c1) * t + c2) * t + c3) * t + c4) * t + c5,
        (((5.0 * c0 * t + 4.0 * c1) * t + 3.0 * c2) * t + 2.0 * c3) * t + c4,
        ((20.0 * c0 * t + 12.0 * c1) * t + 6.0 * c2) * t + 2.0 * c3,
    )


def joined(states: Sequence[States]) -> States:
    """Put states one after the other."""
    q, v, a = (np.concatenate(part) for part in zip(*states, strict=True))
    return States(q, v, a)
