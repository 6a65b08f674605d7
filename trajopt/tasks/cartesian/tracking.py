"""Tracking of a curve from a first configuration: stepwise, without jumps, several branches in parallel.

Redundant joints drift towards a posture; the result is the seed of the program that plans the whole line
(`trajopt.tasks.cartesian.program`).
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from trajopt.tasks.cartesian.on_curve import OnCurve
from trajopt.values.arrays import Floats

STEP = 0.01
"""Length of a step along the curve [m]."""
MOST_STEPS = 400
"""Largest number of steps along a curve."""
LEAST_STEPS = 8
"""Smallest number of steps along a curve."""
FARTHEST = 0.2
"""Largest joint motion in a step; a larger one may be a jump, which smaller steps decide [rad | m]."""
HALVINGS = 7
"""Number of halvings of a step before the rest counts as a jump."""
DRIFT = 4.0
"""Rate of the drift to the posture, per metre along the curve [1/m]."""


@dataclass(frozen=True, eq=False)
class Track:
    """A path of the joints along a curve.

    Attributes:
        stations: Lengths along the curve, increasing from 0, shape (m,) [m].
        positions: Configurations there, shape (m, n) [rad | m].
    """

    stations: Floats
    positions: Floats

    @property
    def reached(self) -> float:
        """Its length along the curve [m]."""
        return float(self.stations[-1])

    def until(self, s: float) -> "Track":
        """Return the part up to the last station within a length [m]."""
        kept = max(int(np.searchsorted(self.stations, s + 1e-12, side="right")), 1)
        return Track(self.stations[:kept], self.positions[:kept])


def stations_of(on_curve: OnCurve) -> Floats:
    """Return lengths along the curve about a step apart, including the ends of its pieces."""
    edges = on_curve.required.curve.edges
    until = on_curve.required.until
    edges = np.append(edges[edges < until], until)
    step = max(STEP, until / MOST_STEPS)
    least = int(np.ceil(LEAST_STEPS / max(len(edges) - 1, 1)))
    spans = np.diff(edges)
    parts = np.maximum(np.ceil(spans / step), least)
    # The whole part of a count is the number of a piece, and the rest of it where in the piece.
    counted = np.interp(np.arange(int(parts.sum())), np.append(0.0, np.cumsum(parts)), np.arange(len(edges)))
    return np.append(np.interp(counted, np.arange(len(edges)), edges), until)


def track(on_curve: OnCurve, stations: Floats, begin: Floats, pull: Floats) -> list[Track]:
    """Track the curve from several first configurations.

    Args:
        on_curve: The curve and the arm.
        stations: Lengths along the curve, increasing from 0, shape (m,) [m].
        begin: Configurations at the first of them, shape (b, n) [rad | m].
        pull: Posture of each drift, shape (b, n); NaN for no drift.

    Returns:
        The joint path of each.
    """
    count = len(begin)
    q, alive = begin.copy(), np.ones(count, dtype=np.bool_)
    places: list[list[float]] = [[float(stations[0])] for _ in range(count)]
    ways: list[list[Floats]] = [[begin[branch]] for branch in range(count)]
    for s, after in pairwise(stations.tolist()):
        going = np.flatnonzero(alive)
        if len(going) == 0:
            break
        now = q[going]
        estimate = now + _drift(on_curve, now, s, after - s, pull[going])
        ended = on_curve(estimate, np.full(len(going), after))
        smooth = ended.held & (np.abs(ended.positions - now).max(axis=1) <= FARTHEST)
        for row, branch in enumerate(map(int, going)):
            if smooth[row]:
                reached, place = ended.positions[row], after
            else:
                reached, place = _finely(on_curve, now[row], s, after)
                alive[branch] = place == after
            if place > s:
                q[branch] = reached
                places[branch].append(place)
                ways[branch].append(reached)
    return [Track(np.array(place), np.array(way)) for place, way in zip(places, ways, strict=True)]


def _drift(on_curve: OnCurve, q: Floats, s: float, step: float, pull: Floats) -> Floats:
    drifting = np.isfinite(pull).all(axis=1)
    moved = np.zeros_like(q)
    if on_curve.spare and drifting.any():
        wish = np.clip((pull - q)[drifting] * DRIFT * step, -DRIFT * step, DRIFT * step)
        moved[drifting] = on_curve.free_motion(q[drifting], np.full(int(drifting.sum()), s), wish)
    return moved


def _finely(on_curve: OnCurve, q: Floats, begin: float, end: float) -> tuple[Floats, float]:
    """Continue with halved steps: return the last configuration reached without a jump, and its length."""
    s, step, least = begin, end - begin, (end - begin) / 2**HALVINGS
    while s < end and step >= least:
        after = end if s + step >= end - 0.5 * least else s + step
        ended = on_curve(q[None], np.array((after,)))
        moved = float(np.abs(ended.positions[0] - q).max())
        if ended.held[0] and moved <= FARTHEST * max(step / (end - begin), 0.05) * 4.0:
            q, s = ended.positions[0], after
            step = min(2.0 * step, end - begin)
        else:
            step /= 2.0
    return q, s


ROUNDS = 9
"""Largest number of bisections."""
APART = 2e-3
"""Largest distance of a chord from the curve's configuration half-way [rad | m]."""


def densified(on_curve: OnCurve, found: Track, *, tolerance: float) -> Track:
    """Add knots until the chords between them are near enough to the curve.

    Args:
        on_curve: The curve and the arm.
        found: A track of it; its configurations are moved onto the curve.
        tolerance: Largest distance of the frame from the curve half-way between knots, rotations counted as
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
        exact = on_curve(_interpolated(s, q, middle), middle)
        apart = np.abs(exact.positions - straight).max(axis=1)
        coarse = ((np.linalg.norm(value, axis=1) > tolerance) | (apart > APART)) & exact.held
        places = left[coarse] + 1
        s = np.insert(s, places, middle[coarse])
        q = np.insert(q, places, exact.positions[coarse], axis=0)
        marks = np.zeros(len(doubtful), dtype=np.bool_)
        marks[left[coarse]] = True
        doubtful = np.repeat(marks, np.where(marks, 2, 1))
    return Track(s, q)


def _interpolated(s: Floats, q: Floats, places: Floats) -> Floats:
    """Interpolate configurations smoothly, without overshooting."""
    from scipy.interpolate import PchipInterpolator

    return np.asarray(PchipInterpolator(s, q)(places), dtype=np.float64)


def resampled(on_curve: OnCurve, found: Track, stations: Floats) -> Track:
    """Return the track with its configurations at other stations, on the curve."""
    estimate = np.concatenate(
        (found.positions[:1], _interpolated(found.stations, found.positions, stations[1:]))
    )
    moved = on_curve(estimate[1:], stations[1:]).positions
    return Track(stations, np.concatenate((estimate[:1], moved)))
