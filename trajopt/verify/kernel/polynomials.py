"""Piecewise polynomials with bounds that hold at every time, not only at samples.

In Bernstein form a polynomial lies between its smallest and its largest control value. Source:
Farouki, The Bernstein polynomial basis: a centennial retrospective, CAGD 2012.
"""

from dataclasses import dataclass
from functools import cache
from math import comb

import numpy as np

from trajopt.arrays import Floats, Ints, readonly

TIGHTNESS = 1e-9
"""Extremes are found to within this, relative to the larger of their size and one."""
_MOST_HALVINGS = 50


@dataclass(frozen=True, eq=False)
class Extremes:
    """Largest values of n functions and where they are taken.

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

    def largest(self) -> Extremes:
        """Find the largest value of each function by branch and bound, to within `TIGHTNESS`."""
        pieces, count = len(self.times) - 1, int(self.coefficients.shape[2])
        every = np.arange(pieces, dtype=np.int64)
        lengths = np.diff(self.times)
        control = self._control(every, np.zeros(pieces), lengths).reshape(-1, pieces * count)
        return _largest(
            control,
            np.tile(np.arange(count), pieces),
            np.repeat(self.times[:-1], count),
            np.repeat(lengths, count),
        )

    def smallest(self) -> Extremes:
        """Find the smallest value of each function, as `largest` does."""
        found = Polynomials(self.times, readonly(-self.coefficients)).largest()
        return Extremes(-found.values, found.times)

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


def _largest(control: Floats, function: Ints, begin: Floats, width: Floats) -> Extremes:
    """Split the pieces that may hold a larger value than the largest seen, until none may.

    Args:
        control: Bernstein coefficients of each piece, shape (degree + 1, m).
        function: Which function a piece belongs to, shape (m,).
        begin: Start of each piece, shape (m,) [s].
        width: Length of each piece, shape (m,) [s].
    """
    count = int(function.max()) + 1
    best, when = np.full(count, -np.inf), np.zeros(count)
    for _ in range(_MOST_HALVINGS):
        for edge, moment in ((control[0], begin), (control[-1], begin + width)):
            rising = np.argsort(edge)
            rising = rising[edge[rising] > best[function[rising]]]
            best[function[rising]] = edge[rising]
            when[function[rising]] = moment[rising]
        slack = TIGHTNESS * np.maximum(1.0, np.abs(best))
        open_ = control.max(axis=0) > (best + slack)[function]
        if not open_.any():
            return Extremes(best, when)
        left, right = _halves(control[:, open_])
        half = width[open_] / 2
        function = np.concatenate((function[open_],) * 2)
        begin = np.concatenate((begin[open_], begin[open_] + half))
        width = np.concatenate((half, half))
        control = np.concatenate((left, right), axis=1)
    np.maximum.at(best, function, control.max(axis=0))
    return Extremes(best, when)


def _halves(control: Floats) -> tuple[Floats, Floats]:
    """Bernstein coefficients of both halves (de Casteljau), each of shape (degree + 1, m)."""
    rows = control.copy()
    left, right = np.empty_like(rows), np.empty_like(rows)
    for level in range(len(rows)):
        left[level], right[-1 - level] = rows[0], rows[-1 - level]
        rows[: len(rows) - 1 - level] = (rows[: len(rows) - 1 - level] + rows[1 : len(rows) - level]) / 2
    return left, right
