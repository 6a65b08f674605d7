"""How far along a curve a frame is at each time: estimated by dynamic programming, then by Newton's method.

Nothing is proven here, and nothing need be: any non-decreasing function is a witness, and
`follows_curve` bounds the error that it leaves.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from trajopt.problem.requirements import FollowsCurve
from trajopt.values.arrays import Floats
from trajopt.verify.checks.curve_places import CurvePlaces
from trajopt.verify.kernel.motion import Motion

TIMES = 600
"""Times of the first estimate."""
PLACES = 600
"""Points of the curve among which the first estimate chooses."""
NEARER = 8
"""Places tried on each side of a kink beside the even ones, each nearer to it by a factor of"""
TOWARDS = 0.5
"""so much."""
SAME = 1e-9
"""Points nearer to each other count as one [m]."""
ROUNDS = 4
"""Newton steps from there."""
DIFFERENCE = 1e-5
"""Step of the difference that gives the curve's direction [m]."""


@dataclass(frozen=True, eq=False)
class Errors:
    """Differences between a frame and points of a curve, as vectors.

    Attributes:
        required: The curve and the tolerances.
        places: The curve, as the judge reads it.
        placements: Times (c,) -> rotation (c, 3, 3) and point (c, 3) [m] of the frame.
    """

    required: FollowsCurve
    places: CurvePlaces
    placements: Callable[[Floats], tuple[Floats, Floats]]

    @property
    def spread(self) -> float:
        """Length of the change of an orientation's vector for a small turn about the worst axis [1/rad]."""
        return 1.0 if self.required.spin is not None else float(np.sqrt(2.0))

    def chord(self, angle: float) -> float:
        """Length of the difference of two orientations' vectors that an angle makes."""
        return 2.0 * self.spread * float(np.sin(min(angle, np.pi) / 2.0))

    def angle(self, chord: float) -> float:
        """Angle that a difference of orientations' vectors stands for [rad]."""
        return 2.0 * float(np.arcsin(min(chord / (2.0 * self.spread), 1.0)))

    def frame(self, times: Floats) -> Floats:
        """Points and orientations of the frame as vectors, shape (c, 6 or 12)."""
        return self._vector(*self.placements(times))

    def curve(self, s: Floats) -> Floats:
        """The same of points of the curve."""
        return self._vector(*self.places.at(s))

    def sizes(self, times: Floats, s: Floats) -> Floats:
        """Lengths of the differences of points and of orientations' vectors, shape (c, 2)."""
        return self.lengths(self.frame(times) - self.curve(s))

    def lengths(self, apart: Floats) -> Floats:
        """Lengths of both parts of differences (c, 6 or 12), shape (c, 2); 0 where orientation is free."""
        found = np.stack((np.linalg.norm(apart[:, :3], axis=1), np.linalg.norm(apart[:, 3:], axis=1)), axis=1)
        if np.isinf(self.required.rotation_tolerance):
            found[:, 1] = 0.0
        return found

    def at(self, times: Floats, s: Floats) -> Floats:
        """Distances [m] and angles [rad], shape (c, 2)."""
        found = self.sizes(times, s)
        found[:, 1] = [self.angle(chord) for chord in found[:, 1].tolist()]
        return found

    @property
    def weights(self) -> Floats:
        """What makes differences comparable: one over the tolerance, shape (6 or 12,)."""
        turned = self.required.rotation_tolerance
        by_turn = 0.0 if np.isinf(turned) else 1.0 / self.chord(turned)
        columns = 3 if self.required.spin is not None else 9
        return np.concatenate((np.full(3, 1.0 / self.required.position_tolerance), np.full(columns, by_turn)))

    def candidate_fractions(self, until: float) -> Floats:
        """Increasing arc lengths along the curve [m]: evenly spaced, where pieces meet, closer near kinks."""
        edges, step = self.places.edges, until / (PLACES - 1)
        nearer = step * TOWARDS ** np.arange(1, NEARER + 1)
        around = self.places.kinked[:, None] + np.concatenate((-nearer, nearer))
        found = np.concatenate((np.linspace(0.0, until, PLACES), edges, around.ravel()))
        found = np.unique(found[(found >= 0.0) & (found <= until)])
        # Two that differ by rounding only would leave no room between neighbours.
        return found[np.append(True, np.diff(found) > SAME)]

    def _vector(self, rotation: Floats, point: Floats) -> Floats:
        spin = self.required.spin
        turned = rotation.reshape(-1, 9) if spin is None else rotation @ spin
        return np.concatenate((point, turned), axis=1)


def nearest_progress(errors: Errors, motion: Motion, until: float) -> tuple[Floats, Floats]:
    """Estimate how far along the curve the frame is, never going back: times and arc lengths, (c,) each.

    The sum of squared errors on a grid is least (dynamic time warping), from the beginning of the curve at
    time zero to `until` at the end.
    """
    times = np.linspace(0.0, motion.duration, TIMES)
    s = errors.candidate_fractions(until)
    weights = errors.weights
    frame, curve = errors.frame(times) * weights, errors.curve(s) * weights
    square = (frame**2).sum(axis=1)[:, None] + (curve**2).sum(axis=1) - 2.0 * frame @ curve.T
    cost = np.full(len(s), np.inf)
    cost[0] = square[0, 0]
    came_from = np.zeros((TIMES, len(s)), dtype=np.int64)
    columns = np.arange(len(s))
    for row in range(1, TIMES):
        least = np.minimum.accumulate(cost)
        came_from[row] = np.maximum.accumulate(np.where(cost == least, columns, 0))
        cost = least + square[row]
    column = np.empty(TIMES, dtype=np.int64)
    column[-1] = len(s) - 1
    for row in range(TIMES - 1, 0, -1):
        column[row - 1] = came_from[row, column[row]]
    low, high = s[np.maximum(column - 1, 0)], s[np.minimum(column + 1, len(s) - 1)]
    found = refined(errors, times, s[column], low, high)
    found[0], found[-1] = 0.0, until
    return times, np.minimum(np.maximum.accumulate(found), until)


def refined(errors: Errors, times: Floats, s: Floats, low: Floats, high: Floats) -> Floats:
    """Move points along the curve to where the frame is nearest, between bounds; all of shape (c,).

    Where the curve has a kink between the bounds, both sides of it are tried: beyond a sharp corner the
    other leg may be near too.
    """
    edges, frame = errors.places.edges, errors.frame(times)
    last = len(edges) - 1
    first_end = np.minimum(high, edges[np.minimum(np.searchsorted(edges, low, side="right"), last)])
    last_begin = np.maximum(low, edges[np.maximum(np.searchsorted(edges, high, side="left") - 1, 0)])
    sides = (
        _nearest(errors, frame, np.clip(s, low, first_end), low, first_end),
        _nearest(errors, frame, np.clip(s, last_begin, high), last_begin, high),
    )
    off = [(((frame - errors.curve(side)) * errors.weights) ** 2).sum(axis=1) for side in sides]
    return np.where(off[0] <= off[1], *sides)


def _nearest(errors: Errors, frame: Floats, s: Floats, low: Floats, high: Floats) -> Floats:
    """Newton's method between bounds; a step that brings the frame no nearer is shortened."""
    weights = errors.weights
    found, share = s.copy(), np.ones(len(s))
    off = (frame - errors.curve(found)) * weights
    for _ in range(ROUNDS):
        back, on = np.maximum(found - DIFFERENCE, low), np.minimum(found + DIFFERENCE, high)
        step = np.maximum(on - back, 1e-12)[:, None]
        slope = (errors.curve(on) - errors.curve(back)) / step * weights
        square = (slope**2).sum(axis=1)
        gain = share * (slope * off).sum(axis=1) / np.where(square > 0.0, square, 1.0)
        tried = np.clip(found + gain, low, high)
        nearer = (frame - errors.curve(tried)) * weights
        better = (nearer**2).sum(axis=1) < (off**2).sum(axis=1)
        found, off = np.where(better, tried, found), np.where(better[:, None], nearer, off)
        share = np.where(better, 1.0, share / 4.0)
    return found
