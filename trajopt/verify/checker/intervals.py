"""Intervals of doubles with outward rounding, as arrays.

Each sum and product of IEEE 754 is within half a unit in the last place of the exact one, so the next double
outward bounds it. Sines and cosines are balls of python-flint. An overflow or NaN fails every comparison, and
so refuses the proof.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from flint import arb
from numpy.typing import ArrayLike, NDArray

Floats: TypeAlias = NDArray[np.float64]


def up(values: ArrayLike) -> Floats:
    """Return the next doubles above: an upper bound of a result that was rounded to nearest."""
    return np.nextafter(values, np.inf)


def down(values: ArrayLike) -> Floats:
    """Return the next doubles below."""
    return np.nextafter(values, -np.inf)


@dataclass(frozen=True, eq=False)
class Interval:
    """Sets of real numbers between two bounds, element by element.

    Attributes:
        low: Lower bounds, any shape.
        high: Upper bounds, same shape.
    """

    low: Floats
    high: Floats

    def __add__(self, other: Interval) -> Interval:
        return Interval(down(self.low + other.low), up(self.high + other.high))

    def __sub__(self, other: Interval) -> Interval:
        return Interval(down(self.low - other.high), up(self.high - other.low))

    def __neg__(self) -> Interval:
        return Interval(-self.high, -self.low)

    def __mul__(self, other: Interval) -> Interval:
        a, b, c, d = (one * two for one in (self.low, self.high) for two in (other.low, other.high))
        low = np.minimum(np.minimum(a, b), np.minimum(c, d))
        return Interval(down(low), up(np.maximum(np.maximum(a, b), np.maximum(c, d))))

    def __truediv__(self, other: Interval) -> Interval:
        """Bound all quotients by positive numbers; not a number if the divisor may not be positive."""
        positive = np.where(other.low > 0.0, 1.0, np.nan)
        a, b, c, d = (one / two for one in (self.low, self.high) for two in (other.low, other.high))
        low = np.minimum(np.minimum(a, b), np.minimum(c, d))
        return Interval(down(low) * positive, up(np.maximum(np.maximum(a, b), np.maximum(c, d))) * positive)

    def __getitem__(self, key: Any) -> Interval:
        return Interval(self.low[key], self.high[key])

    @property
    def size(self) -> Floats:
        return np.maximum(-self.low, self.high)

    @property
    def transposed(self) -> Interval:
        return Interval(self.low.swapaxes(-1, -2), self.high.swapaxes(-1, -2))

    def sum(self) -> Interval:
        total = self[..., 0]
        for place in range(1, self.low.shape[-1]):
            total = total + self[..., place]
        return total

    def norm(self) -> Interval:
        least = np.where(
            (self.low <= 0.0) & (self.high >= 0.0), 0.0, np.minimum(abs(self.low), abs(self.high))
        )
        magnitude = Interval(least + 0.0 * self.low, self.size)
        square = (magnitude * magnitude).sum()
        return Interval(np.maximum(down(np.sqrt(np.maximum(square.low, 0.0))), 0.0), up(np.sqrt(square.high)))


def exactly(values: ArrayLike) -> Interval:
    array = np.asarray(values, dtype=np.float64)
    return Interval(array, array)


def joined(parts: list[Interval], axis: int) -> Interval:
    """Stack intervals along a new axis."""
    return Interval(np.stack([p.low for p in parts], axis), np.stack([p.high for p in parts], axis))


def product(matrix: Interval, other: Interval) -> Interval:
    total = matrix[..., :, 0, None] * other[..., None, 0, :]
    for inner in range(1, matrix.low.shape[-1]):
        total = total + matrix[..., :, inner, None] * other[..., None, inner, :]
    return total


def turned(matrix: Interval, vector: Interval) -> Interval:
    return (matrix * vector[..., None, :]).sum()


def cross(one: Interval, other: Interval) -> Interval:
    """Multiply vectors (..., 3) by vectors (..., 3)."""
    ahead, behind = [1, 2, 0], [2, 0, 1]
    return one[..., ahead] * other[..., behind] - one[..., behind] * other[..., ahead]


def dot(one: Interval, other: Interval) -> Interval:
    """Bound inner products over the last axis."""
    return (one * other).sum()


def normalised(vector: ArrayLike) -> Interval:
    exact = exactly(vector)
    return exact / exact.norm()[..., None]


def sine_and_cosine(angles: Interval) -> tuple[Interval, Interval]:
    """Bound sines and cosines of intervals (n,): at their middles, widened by half their widths."""
    middle = angles.low + (angles.high - angles.low) / 2.0
    radius = up(np.maximum(up(angles.high - middle), up(middle - angles.low)))
    found = [arb(value).sin_cos() if np.isfinite(value) else (arb("nan"),) * 2 for value in middle.tolist()]
    bounds = [[enclosed(each[which]) for each in found] for which in (0, 1)]
    sine, cosine = (np.array(side, dtype=np.float64).reshape(-1, 2) for side in bounds)
    return tuple(
        Interval(np.maximum(down(side[:, 0] - radius), -1.0), np.minimum(up(side[:, 1] + radius), 1.0))
        for side in (sine, cosine)
    )  # pyright: ignore[reportReturnType]


def enclosed(ball: arb) -> tuple[float, float]:
    """Return doubles below and above all numbers of a ball; not a number if there are none."""
    low, high = float(down(float(ball.lower()))), float(up(float(ball.upper())))
    return (low, high) if arb(low) < ball < arb(high) else (np.nan, np.nan)
