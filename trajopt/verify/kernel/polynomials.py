"""Piecewise polynomials with bounds that hold at every time, not only at samples.

In Bernstein form a polynomial lies between its smallest and its largest control value. Source:
Farouki, The Bernstein polynomial basis: a centennial retrospective, CAGD 2012.
"""

from dataclasses import dataclass

import numpy as np

from trajopt.native import proof
from trajopt.values.arrays import Floats, Ints, readonly

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
        sides = (np.ascontiguousarray(side) for side in (begin, end))
        return proof.ranges(self.times, np.ascontiguousarray(self.coefficients), *sides)

    def extremes(self) -> tuple[Extremes, Extremes]:
        """Find largest and smallest values of each function by branch and bound, to within `TIGHTNESS`."""
        coefficients = np.ascontiguousarray(self.coefficients)
        high, time_of_high = proof.largest(self.times, coefficients, 1.0, TIGHTNESS)
        low, time_of_low = proof.largest(self.times, coefficients, -1.0, TIGHTNESS)
        return Extremes(high, time_of_high), Extremes(-low, time_of_low)

    def at(self, piece: Ints, since: Floats) -> Floats:
        """Return the values in pieces at times since these begin, both of shape (s,), shape (s, n)."""
        return proof.sampled(np.ascontiguousarray(self.coefficients), piece, since)
