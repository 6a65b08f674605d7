"""Largest and smallest values of piecewise polynomials in plain Python, all functions at once."""

from functools import cache
from math import comb

import numpy as np

from trajopt.values.arrays import Floats, Ints, readonly
from trajopt.verify.kernel.motion import TIGHTNESS, Extremes, Polynomials

_MOST_HALVINGS = 50


def largest(polynomials: Polynomials) -> Extremes:
    """Find the largest value of each function by branch and bound, to within `TIGHTNESS`."""
    times, coefficients = polynomials.times, polynomials.coefficients
    pieces, count = len(times) - 1, int(coefficients.shape[2])
    lengths = np.diff(times)
    values = control(polynomials, np.arange(pieces), np.zeros(pieces), lengths)
    return _largest(
        values.reshape(-1, pieces * count),
        np.tile(np.arange(count), pieces),
        np.repeat(times[:-1], count),
        np.repeat(lengths, count),
    )


def smallest(polynomials: Polynomials) -> Extremes:
    """Find the smallest value of each function, as `largest` does."""
    found = largest(Polynomials(polynomials.times, -polynomials.coefficients))
    return Extremes(-found.values, found.times)


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


def bounds(polynomials: Polynomials, begin: Floats, end: Floats) -> tuple[Floats, Floats]:
    """Bound functions over intervals, as `Polynomials.range` does."""
    last_piece = len(polynomials.times) - 2
    first = np.clip(np.searchsorted(polynomials.times, begin, side="right") - 1, 0, last_piece)
    last = np.clip(np.searchsorted(polynomials.times, end, side="left") - 1, first, last_piece)
    counts = last - first + 1
    starts = np.concatenate(([0], np.cumsum(counts)[:-1]))
    owner = np.repeat(np.arange(len(begin)), counts)
    piece = np.arange(len(owner)) - starts[owner] + first[owner]
    left = np.maximum(begin[owner], polynomials.times[piece]) - polynomials.times[piece]
    right = np.minimum(end[owner], polynomials.times[piece + 1]) - polynomials.times[piece]
    values = control(polynomials, piece, left, np.maximum(right - left, 0.0))
    return (
        np.minimum.reduceat(values.min(axis=0), starts),
        np.maximum.reduceat(values.max(axis=0), starts),
    )


def control(polynomials: Polynomials, piece: Ints, left: Floats, width: Floats) -> Floats:
    """Bernstein coefficients on [left, left + width] of pieces, (degree + 1, m, n)."""
    taylor = polynomials.coefficients[:, piece]
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
