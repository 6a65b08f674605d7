"""Knots so dense that straight lines of the joints between them keep the frame on the curve."""

import numpy as np

from trajopt.arrays import Floats
from trajopt.cartesian.on_curve import OnCurve
from trajopt.cartesian.tracking import Track

ROUNDS = 9
"""Halvings of intervals at most."""
APART = 2e-3
"""How far the joints' straight line may be from the curve's configuration half-way [rad | m]."""


def densified(on_curve: OnCurve, found: Track, *, tolerance: float) -> Track:
    """Add knots until straight lines between them are near enough to the curve.

    Args:
        on_curve: The curve and the arm.
        found: A track of it; its configurations are moved on to the curve.
        tolerance: Largest distance of the frame from the curve half-way between knots, turns counted as
            lengths [m].
    """
    s = found.stations
    q = np.concatenate((found.positions[:1], on_curve(found.positions[1:], s[1:]).positions))
    doubtful = np.ones(len(s) - 1, dtype=np.bool_)
    for _ in range(ROUNDS):
        left = np.flatnonzero(doubtful)
        if len(left) == 0:
            break
        middle = (s[left] + s[left + 1]) / 2.0
        straight = (q[left] + q[left + 1]) / 2.0
        value, _ = on_curve.errors(straight, middle)
        exact = on_curve(_guess(s, q, middle), middle)
        apart = np.abs(exact.positions - straight).max(axis=1)
        coarse = ((np.linalg.norm(value, axis=1) > tolerance) | (apart > APART)) & exact.held
        places = left[coarse] + 1
        s = np.insert(s, places, middle[coarse])
        q = np.insert(q, places, exact.positions[coarse], axis=0)
        marks = np.zeros(len(doubtful), dtype=np.bool_)
        marks[left[coarse]] = True
        doubtful = np.repeat(marks, np.where(marks, 2, 1))
    return Track(s, q)


def _guess(s: Floats, q: Floats, places: Floats) -> Floats:
    """Interpolate configurations smoothly, without overshooting."""
    from scipy.interpolate import PchipInterpolator

    return np.asarray(PchipInterpolator(s, q)(places), dtype=np.float64)


def resampled(on_curve: OnCurve, found: Track, stations: Floats) -> Track:
    """Return the track with its configurations at other stations, on the curve."""
    guess = np.concatenate((found.positions[:1], _guess(found.stations, found.positions, stations[1:])))
    moved = on_curve(guess[1:], stations[1:]).positions
    return Track(stations, np.concatenate((guess[:1], moved)))
