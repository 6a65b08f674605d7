"""Exact extremes of the velocity and acceleration of quintic pieces."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from trajopt.values.arrays import Floats
from trajopt.values.trajectory import Trajectory

STEPS = 8
"""Newton steps towards a zero of the acceleration; what is missing then is added to the speed."""


def acceleration_range(trajectory: Trajectory) -> tuple[Floats, Floats]:
    """Least and largest acceleration in each piece.

    Args:
        trajectory: Quintic, of k points and n joints.

    Returns:
        Two arrays (k - 1, n) [rad/s^2 | m/s^2].
    """
    cubic = _acceleration(trajectory)
    first, second = _turning_points(cubic)
    values = [_horner(cubic, part) for part in (0.0, 1.0, first, second)]
    return np.minimum.reduce(values), np.maximum.reduce(values)


def speed_peaks(trajectory: Trajectory) -> Floats:
    """Largest absolute velocity in each piece.

    Extremes lie where the acceleration is zero. Between its turning points the acceleration is
    monotone, so that each part with a change of sign holds exactly one.

    Args:
        trajectory: Quintic, of k points and n joints.

    Returns:
        Shape (k - 1, n) [rad/s | m/s].
    """
    c = trajectory.coefficients
    h = np.diff(trajectory.times)[:, None]
    quartic = np.stack((5 * c[0] * h**4, 4 * c[1] * h**3, 3 * c[2] * h**2, 2 * c[3] * h, c[4]))
    peaks = np.maximum(np.abs(_horner(quartic, 0.0)), np.abs(_horner(quartic, 1.0)))
    cubic = _acceleration(trajectory)
    first, second = _turning_points(cubic)
    ends = (np.zeros_like(first), np.minimum(first, second), np.maximum(first, second), np.ones_like(first))
    signs = [_horner(cubic, part) > 0.0 for part in ends]
    found = [np.nonzero(signs[i] != signs[i + 1]) for i in range(3)]
    piece, joint = (np.concatenate([where[axis] for where in found]) for axis in range(2))
    low = np.concatenate([ends[i][where] for i, where in enumerate(found)])
    high = np.concatenate([ends[i + 1][where] for i, where in enumerate(found)])
    if len(piece):
        zero, missing = _zero(cubic[:, piece, joint], low, high)
        speed = np.abs(_horner(quartic[:, piece, joint], zero)) + missing * h[piece, 0]
        np.maximum.at(peaks, (piece, joint), speed)
    return peaks


def _acceleration(trajectory: Trajectory) -> Floats:
    """Coefficients of the acceleration over the part of each piece, (4, k - 1, n)."""
    c = trajectory.coefficients
    h = np.diff(trajectory.times)[:, None]
    return np.stack((20 * c[0] * h**3, 12 * c[1] * h**2, 6 * c[2] * h, 2 * c[3]))


def _horner(polynomial: Floats, at: Floats | float) -> Floats:
    value: NDArray[Any] = np.zeros_like(polynomial[0]) + polynomial[0]
    for coefficient in polynomial[1:]:
        value = value * at + coefficient
    return value


def _turning_points(cubic: Floats) -> tuple[Floats, Floats]:
    """Where the derivative of cubics is zero, clipped to [0, 1]; 0 where there is none.

    Source: the quadratic formula without cancellation, Press et al., Numerical Recipes, 2007, 5.6.
    """
    a, half, c = 3.0 * cubic[0], cubic[1], cubic[2]
    root = np.sqrt(np.maximum(half**2 - a * c, 0.0))
    q = -half - np.copysign(root, half)
    return _part(q, a), _part(c, q)


def _part(above: Floats, below: Floats) -> Floats:
    """The quotient where it is between 0 and 1; else 0 or 1."""
    inside = (np.abs(above) < np.abs(below)) & ((above < 0.0) == (below < 0.0))
    return np.where(inside, above / np.where(inside, below, 1.0), 0.0)


def _zero(cubic: Floats, low: Floats, high: Floats) -> tuple[Floats, Floats]:
    """Find the zero of monotone cubics between two places where their signs differ.

    Newton's method from the secant's zero, halving the bracket where it would leave it.

    Returns:
        The places, and bounds on how much of the integral up to the true zero is missing.
    """
    slope = cubic[:3] * np.array((3.0, 2.0, 1.0))[:, None]
    rising = _horner(cubic, high) > 0.0
    before, after = _horner(cubic, low), _horner(cubic, high)
    at = low + (high - low) * before / (before - after)
    for _ in range(STEPS):
        value, rate = _horner(cubic, at), _horner(slope, at)
        passed = (value > 0.0) == rising
        low, high = np.where(passed, low, at), np.where(passed, at, high)
        safe = np.where(rate == 0.0, 1.0, rate)
        step = np.where(rate == 0.0, np.inf, value / safe)
        inside = (at - step >= low) & (at - step <= high)
        at = np.where(inside, at - step, (low + high) / 2.0)
    return at, np.abs(_horner(cubic, at)) * (high - low)
