"""The smooth path: a cubic spline q(s) with continuous curvature."""

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from trajopt.arrays import Floats

if TYPE_CHECKING:
    from scipy.interpolate import BSpline

DEGREE = 3
"""Degree of the spline; the second derivative is continuous and piecewise linear."""


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
