"""Piecewise polynomials with bounds that hold at every time, not only at samples.

In Bernstein form a polynomial lies between its smallest and its largest control value. Source:
Farouki, The Bernstein polynomial basis: a centennial retrospective, CAGD 2012.
"""

from dataclasses import dataclass
from functools import cache
from math import comb

import numpy as np

from trajopt.arrays import Floats, Ints, readonly
from trajopt.native import proof

TIGHTNESS = 1e-9
"""Extremes are found to within this, relative to the larger of their size and one."""


@dataclass(frozen=True, eq=False)
class Extremes:
    """Largest or smallest values of n functions, and when they are taken.

    Attributes:
        values: Shape (n,).
        times: Shape (n,) [s].
    """

    values: Floats
    times: Floats


@dataclass(frozen=True, eq=False)
class Polynomials:
    """n functions of time, polynomial between breakpoints.

    Attributes:
        times: Breakpoints, increasing, shape (k,) [s].
        coefficients: Of the time since the start of each piece, highest power first, shape
            (degree + 1, k - 1, n).
    """

    times: Floats
    coefficients: Floats

    def derivative(self) -> "Polynomials":
        """Return the derivative in time."""
        degree = len(self.coefficients) - 1
        if degree == 0:
            return Polynomials(self.times, readonly(np.zeros_like(self.coefficients)))
        powers = np.arange(degree, 0, -1.0)[:, None, None]
        return Polynomials(self.times, readonly(self.coefficients[:-1] * powers))

    def combined(self, matrix: Floats, offset: Floats) -> "Polynomials":
        """Return the m functions `matrix @ f + offset`, for a matrix (m, n) and offsets (m,)."""
        coefficients = self.coefficients @ matrix.T
        coefficients[-1] += offset
        return Polynomials(self.times, readonly(coefficients))

    def range(self, begin: Floats, end: Floats) -> tuple[Floats, Floats]:
        """Bound the functions over intervals.

        Args:
            begin: Start of each interval, shape (c,) [s].
            end: End of each interval, later than its start, shape (c,) [s].

        Returns:
            Lower and upper bounds, each of shape (c, n).
        """
        last_piece = len(self.times) - 2
        first = np.clip(np.searchsorted(self.times, begin, side="right") - 1, 0, last_piece)
        last = np.clip(np.searchsorted(self.times, end, side="left") - 1, first, last_piece)
        counts = last - first + 1
        starts = np.concatenate(([0], np.cumsum(counts)[:-1]))
        owner = np.repeat(np.arange(len(begin)), counts)
        piece = np.arange(len(owner)) - starts[owner] + first[owner]
        left = np.maximum(begin[owner], self.times[piece]) - self.times[piece]
        right = np.minimum(end[owner], self.times[piece + 1]) - self.times[piece]
        control = self._control(piece, left, np.maximum(right - left, 0.0))
        return (
            np.minimum.reduceat(control.min(axis=0), starts),
            np.maximum.reduceat(control.max(axis=0), starts),
        )

    def extremes(self) -> tuple[Extremes, Extremes]:
        """Find largest and smallest values of each function by branch and bound, to within `TIGHTNESS`."""
        coefficients = np.ascontiguousarray(self.coefficients)
        high, time_of_high = proof.largest(self.times, coefficients, 1.0, TIGHTNESS)
        low, time_of_low = proof.largest(self.times, coefficients, -1.0, TIGHTNESS)
        return Extremes(high, time_of_high), Extremes(-low, time_of_low)

    def within(self, lower: Floats, upper: Floats) -> bool:
        """Say whether every function is proven to stay within its bounds, each of shape (n,)."""
        coefficients, bounds = np.ascontiguousarray(self.coefficients), (lower, upper)
        return proof.within(self.times, coefficients, *(np.ascontiguousarray(side) for side in bounds))

    def at(self, piece: Ints, since: Floats) -> Floats:
        """Return the values in pieces at times since these begin, both of shape (s,), shape (s, n)."""
        return proof.sampled(np.ascontiguousarray(self.coefficients), piece, since)

    def _control(self, piece: Ints, left: Floats, width: Floats) -> Floats:
        """Bernstein coefficients on [left, left + width] of pieces, (degree + 1, m, n)."""
        taylor = self.coefficients[:, piece]
        degree = len(taylor) - 1
        for done in range(degree):
            for power in range(1, degree + 1 - done):
                taylor[power] += left[:, None] * taylor[power - 1]
        scale = width[None, :, None] ** np.arange(degree, -1, -1)[:, None, None]
        return np.asarray(
            np.tensordot(_to_bernstein(degree), taylor * scale, axes=1),
            dtype=np.float64,
        )


@cache
def _to_bernstein(degree: int) -> Floats:
    """Matrix from coefficients on [0, 1], highest power first, to Bernstein coefficients."""
    rows = [
        [comb(row, power) / comb(degree, power) if power <= row else 0.0 for power in range(degree, -1, -1)]
        for row in range(degree + 1)
    ]
    return readonly(np.array(rows))
