"""The smooth path: a cubic spline q(s) with continuous curvature; and the same over a clock.

From rest with bounded jerk a path parameter begins like t^3, so that its squared speed is no smooth function
of it. Over a clock on which the parameter itself begins like clock^3, it is: the squared speed of the clock
is positive everywhere, and any smooth one starts and ends at rest with zero acceleration.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from trajopt.values.arrays import Bools, Floats

if TYPE_CHECKING:
    from scipy.interpolate import BSpline

DEGREE = 3
"""Degree of the spline; the second derivative is continuous and piecewise linear."""
CLOCK_DEGREE = 4
"""Degree of the path parameter over the clock: its third derivative is continuous."""
FLAT = 3
"""Control values at each end that are equal, so that two derivatives vanish there."""
APART = 0.1
"""Knots of the path nearer to each other than this part of an even interval become one point of the grid."""
SPARED = 0.2
"""Part of an even interval by which one between two knots may be longer before it is cut."""


@dataclass(frozen=True, eq=False)
class SmoothPath:
    """A cubic B-spline in joint space over the path parameter s.

    Every point of it is an average, with weights that are not negative, of four control points.

    Attributes:
        origin: Position at s = 0, shape (n,) [rad | m]; control points are relative to it, so
            that a joint that stands still has derivatives of exactly zero.
        goal: Position at the end, shape (n,) [rad | m].
        knots: Where the third derivative may jump, increasing from 0, shape (k,) [s]. The
            parameter is the time that the polyline takes at full speed: see `parameter`.
        control: Control points relative to the origin, shape (k + 2, n) [rad | m].
    """

    origin: Floats
    goal: Floats
    knots: Floats
    control: Floats

    @property
    def length(self) -> float:
        """The parameter at the goal [s]."""
        return float(self.knots[-1])

    @cached_property
    def _position(self) -> "BSpline":
        from scipy.interpolate import BSpline

        return BSpline(full_knots(self.knots), self.control, DEGREE)

    @cached_property
    def _slope(self) -> "BSpline":
        return self._position.derivative(1)

    @cached_property
    def _curvature(self) -> "BSpline":
        return self._slope.derivative(1)

    @cached_property
    def _bend(self) -> "BSpline":
        return self._curvature.derivative(1)

    def __call__(self, s: Floats, order: int = 0) -> Floats:
        """Evaluate the path or a derivative with respect to s.

        Args:
            s: Parameters, shape (m,) [s].
            order: 0 to 3.

        Returns:
            Shape (m, n), joint units per s^order.
        """
        if order > 0:
            return (self._slope, self._curvature, self._bend)[order - 1](s)
        position = self.origin + self._position(s)
        position[s >= self.length] = self.goal  # not off by the last bit
        return position


def full_knots(knots: Floats) -> Floats:
    """Repeat the end knots so that the spline starts and ends in a control point: (k,) -> (k + 6,)."""
    return np.concatenate((np.full(DEGREE, knots[0]), knots, np.full(DEGREE, knots[-1])))


def greville(knots: Floats) -> Floats:
    """Parameters at which control points reproduce a straight line: (k,) -> (k + 2,).

    Source: Greville abscissae; de Boor, A Practical Guide to Splines, 2001, chapter IX.
    """
    t = full_knots(knots)
    middle = (t[1:-3] + t[2:-2] + t[3:-1]) / 3.0
    # The sum of three equal numbers, divided by three, may differ from them in the last bit.
    middle[0], middle[-1] = knots[0], knots[-1]
    return middle


def design(knots: Floats, s: Floats) -> Floats:
    """Weights of the control points at parameters s: shape (m, k + 2), dense."""
    from scipy.interpolate import BSpline

    unit = BSpline(full_knots(knots), np.eye(len(knots) + DEGREE - 1), DEGREE)
    return unit(s)


@dataclass(frozen=True, eq=False)
class RampedPath:
    """A smooth path q(s) with s a monotone spline of the clock.

    Attributes:
        path: The path.
        clock: Knots of the spline, which are the grid for timing, from 0, shape (k,) [s].
        control: Control values of s over the clock, never decreasing, shape (k + 3,).
    """

    path: SmoothPath
    clock: Floats
    control: Floats

    @cached_property
    def _ways(self) -> tuple["BSpline", ...]:
        """The path parameter over the clock, and its first three derivatives."""
        from scipy.interpolate import BSpline

        way = BSpline(_clock_knots(self.clock), self.control, CLOCK_DEGREE)
        return (way, way.derivative(1), way.derivative(2), way.derivative(3))

    def way(self, clock: Floats, order: int = 0) -> Floats:
        """Evaluate the path parameter or a derivative of it at clocks (k,), order 0 to 3."""
        value: Floats = self._ways[order](clock)
        if order > 0:
            return value
        value[clock >= self.clock[-1]] = self.path.length  # not off by the last bit
        return np.clip(value, 0.0, self.path.length)

    def __call__(self, clock: Floats, order: int = 0) -> Floats:
        """Evaluate the positions or a derivative by the clock: (k,) -> (k, n), order 0 to 2."""
        s = self.way(clock)
        if order == 0:
            return self.path(s)
        first = self.way(clock, 1)[:, None]
        if order == 1:
            return self.path(s, 1) * first
        return self.path(s, 2) * first**2 + self.path(s, 1) * self.way(clock, 2)[:, None]

    def third(self, clock: Floats) -> tuple[Floats, Floats]:
        """Evaluate the third derivative of the positions by the clock, in the intervals of a grid.

        Args:
            clock: The grid, shape (k,); the path's third derivative jumps at points of it only.

        Returns:
            At the start and at the end of each interval, shape (k - 1, n) each.
        """
        middle = (clock[:-1] + clock[1:]) / 2.0
        constant, s = self.path(self.way(middle), 3), self.way(clock)
        one, two, three = (self.way(clock, order)[:, None] for order in (1, 2, 3))
        others = 3.0 * self.path(s, 2) * (one * two) + self.path(s, 1) * three
        cube = one**3
        return constant * cube[:-1] + others[:-1], constant * cube[1:] + others[1:]


@dataclass(frozen=True, eq=False)
class RoughMotion:
    """A motion along a path, to be smoothed.

    Attributes:
        times: Of its points, from 0, shape (k,) [s].
        s: The path parameter there, from 0 to the length of the path, increasing, shape (k,).
        speed: Its rate there, shape (k,).
    """

    times: Floats
    s: Floats
    speed: Floats


def ramped(path: SmoothPath, rough: RoughMotion, *, average: float, count: int) -> RampedPath:
    """Lay a path over the clock of a rough motion along it.

    The motion is averaged over a time that gives the acceleration time to rise. Control values that
    reproduce cubics are taken where they increase, else the values of the motion itself, which always do.

    Args:
        path: The path.
        rough: The motion.
        average: The time to average over [s]; 0 for a motion that starts and ends without acceleration.
        count: Intervals of the grid to aim at.
    """
    from scipy.interpolate import CubicHermiteSpline

    moved, end = CubicHermiteSpline(rough.times, rough.s, rough.speed), float(rough.times[-1])
    knots = np.interp(path.knots, rough.s, rough.times) + average / 2.0
    clock = _clock_grid(knots, end + average, count)
    places = _clock_greville(clock)
    if average > 0.0:
        summed = moved.antiderivative()

        def until(t: Floats) -> Floats:
            return summed(np.clip(t, 0.0, end)) + path.length * np.maximum(t - end, 0.0)

        value = (until(places) - until(places - average)) / average
    else:
        value: Floats = moved(places)
    value = np.clip(np.maximum.accumulate(value), 0.0, path.length)
    value[:FLAT], value[-FLAT:] = 0.0, path.length
    return RampedPath(path, clock, _cubic_control(clock, places, value))


def _clock_knots(clock: Floats) -> Floats:
    return np.concatenate((np.full(CLOCK_DEGREE, clock[0]), clock, np.full(CLOCK_DEGREE, clock[-1])))


def _clock_greville(clock: Floats) -> Floats:
    """Clocks at which control values reproduce a straight line: (k,) -> (k + 3,)."""
    full = _clock_knots(clock)
    count = len(full) - CLOCK_DEGREE - 1
    return np.mean([full[1 + i : 1 + i + count] for i in range(CLOCK_DEGREE)], axis=0)


def _clock_grid(knots: Floats, length: float, count: int) -> Floats:
    """Cut the clock evenly between the knots of the path that are apart."""
    cell, kept = length / count, [0.0]
    for knot in knots[1:-1].tolist():
        if knot - kept[-1] > APART * cell and length - knot > APART * cell:
            kept.append(knot)
    kept.append(length)
    parts = np.maximum(np.ceil(np.diff(kept) / cell - SPARED), 1.0).astype(np.int64)
    places = [0, *np.cumsum(parts).tolist()]
    return np.interp(np.arange(places[-1] + 1), places, kept)


def _cubic_control(clock: Floats, places: Floats, value: Floats) -> Floats:
    """Correct values of a function at Greville abscissae to control values that reproduce cubics.

    A control value is the blossom of the function at four knots; for a cubic that is its value at their
    mean less its second derivative times a sixth of their variance.
    """
    full, count = _clock_knots(clock), len(value)
    spread = np.mean([(full[1 + i : 1 + i + count] - places) ** 2 for i in range(CLOCK_DEGREE)], axis=0)
    step, rise = np.diff(places), np.diff(value)
    slope = rise / step
    bend = 2.0 * np.diff(slope) / (step[:-1] + step[1:])
    control = value.copy()
    control[FLAT:-FLAT] -= (spread[1:-1] / 6.0 * bend)[FLAT - 1 : 1 - FLAT]
    control[_beside_falls(control)] = value[_beside_falls(control)]
    return control


def _beside_falls(control: Floats) -> Bools:
    """Which control values are near a place where they do not increase, but for the flat ends."""
    falls = np.diff(control) <= 0.0
    falls[: FLAT - 1] = falls[1 - FLAT :] = False
    return np.convolve(falls, np.ones(6), mode="full")[2:-2] > 0.0
