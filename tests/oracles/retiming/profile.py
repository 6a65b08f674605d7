"""The profile s(t): how fast the path parameter runs."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from trajopt.values.arrays import Floats


def stations(s: Floats) -> Floats:
    """Where control values stand: start, interval middles, goal: (k,) -> (k + 1,)."""
    return np.concatenate((s[:1], (s[:-1] + s[1:]) / 2.0, s[-1:]))


@dataclass(frozen=True, eq=False)
class Profile:
    """A profile whose path acceleration is continuous, and linear in s between grid points.

    Attributes:
        s: Grid, increasing, shape (k,).
        x: Squared speed (ds/dt)² at the grid points, positive between the ends, (k,).
        u: Path acceleration d²s/dt² = dx/ds / 2 at the grid points, shape (k,).
    """

    s: Floats
    x: Floats
    u: Floats

    @cached_property
    def times(self) -> Floats:
        """Time of each grid point, from 0, shape (k,) [s].

        On an interval x is a quadratic in s with leading factor alpha = du/ds; the integral of
        ds / sqrt(x) is 2 / sqrt(alpha) * artanh(sqrt(alpha) * ds / (speed + speed after)).
        """
        ds, speed = np.diff(self.s), np.sqrt(self.x)
        mean = ds / (speed[:-1] + speed[1:])
        alpha = np.diff(self.u) / ds
        return np.concatenate(((0.0,), np.cumsum(2.0 * mean * _stretch(alpha * mean**2))))

    @property
    def duration(self) -> float:
        """Time of the last grid point [s]."""
        return float(self.times[-1])


def _stretch(square: Floats) -> Floats:
    """artanh(r) / r of r² = square; for a negative square its continuation arctan(r) / r."""
    root = np.sqrt(np.abs(square))
    small = root < 1e-3
    safe = np.where(small, 0.5, np.minimum(root, 1.0 - 1e-15))
    far = np.where(square > 0.0, np.arctanh(safe), np.arctan(np.where(small, 0.5, root))) / np.where(
        small, 0.5, root
    )
    return np.where(small, 1.0 + square / 3.0 + square**2 / 5.0, far)


def spline_profile(s: Floats, control: Floats) -> Profile:
    """Make the profile whose squared speed is a quadratic B-spline with these control values.

    Source: between grid points x is the quadratic that runs from chord to chord of the control
    polygon; it is an average of control values with positive weights, and so stays positive.

    Args:
        s: Grid, shape (k,).
        control: Control values at the stations (`stations`), shape (k + 1,).
    """
    station = stations(s)
    distance, rise = np.diff(station), np.diff(control)
    x = control[:-1] + (s - station[:-1]) / distance * rise
    return Profile(s, x, rise / (2.0 * distance))


def from_control(s: Floats, control: Floats) -> Profile:
    """Make the profile from rest to rest with these control values.

    Args:
        s: Grid, shape (k,).
        control: Control values at the stations, 0 at both ends and positive between, shape (k + 1,).
    """
    profile = spline_profile(s, control)
    profile.x[-1] = 0.0  # not off by a rounding error
    return profile
