"""Intervals of doubles with outward rounding, as arrays.

Each sum and product of IEEE 754 is within half a unit in the last place of the exact one, so the next double
outward bounds it. Sines and cosines are balls of python-flint. An overflow or NaN fails every comparison, and
so refuses the proof.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import reduce
from typing import Any, TypeAlias

import numpy as np
from flint import arb
from numpy.typing import ArrayLike, NDArray

Floats: TypeAlias = NDArray[np.float64]


def up(values: ArrayLike) -> Floats:
    """Return the next doubles above: an upper bound of a result that was rounded to nearest."""
    return np.nextafter(values, np.inf)


def down(values: ArrayLike) -> Floats:
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
        return self._at_corners(np.multiply, other)

    def __truediv__(self, other: Interval) -> Interval:
        """Bound all quotients by positive numbers; not a number if the divisor may not be positive."""
        positive = np.where(other.low > 0.0, 1.0, np.nan)
        return self._at_corners(np.divide, Interval(other.low * positive, other.high * positive))

    def _at_corners(self, operation: Callable[[Floats, Floats], Floats], other: Interval) -> Interval:
        corners = [operation(one, two) for one in (self.low, self.high) for two in (other.low, other.high)]
        return Interval(down(reduce(np.minimum, corners)), up(reduce(np.maximum, corners)))

    def __getitem__(self, key: Any) -> Interval:
        return Interval(self.low[key], self.high[key])

    @property
    def size(self) -> Floats:
        return np.maximum(-self.low, self.high)

    @property
    def transposed(self) -> Interval:
        return on_bounds(lambda bounds: bounds[0].swapaxes(-1, -2), [self])

    def sum(self) -> Interval:
        total = self[..., 0]
        for place in range(1, self.low.shape[-1]):
            total = total + self[..., place]
        return total

    def norm(self) -> Interval:
        distance = Interval(np.maximum(np.maximum(self.low, -self.high), 0.0), self.size)
        square = (distance * distance).sum()
        return Interval(np.maximum(down(np.sqrt(np.maximum(square.low, 0.0))), 0.0), up(np.sqrt(square.high)))


def exactly(values: ArrayLike) -> Interval:
    array = np.asarray(values, dtype=np.float64)
    return Interval(array, array)


def on_bounds(function: Callable[[list[Floats]], Floats], parts: Sequence[Interval]) -> Interval:
    return Interval(function([part.low for part in parts]), function([part.high for part in parts]))


def joined(parts: Sequence[Interval], axis: int) -> Interval:
    """Stack intervals along a new axis."""
    return on_bounds(lambda bounds: np.stack(bounds, axis), parts)


def hull(parts: Sequence[Interval]) -> Interval:
    every = joined(parts, 0)
    return Interval(every.low.min(axis=0), every.high.max(axis=0))


def product(matrix: Interval, other: Interval) -> Interval:
    return (matrix[..., :, None, :] * other.transposed[..., None, :, :]).sum()


def turned(matrix: Interval, vector: Interval) -> Interval:
    return (matrix * vector[..., None, :]).sum()


def cross(one: Interval, other: Interval) -> Interval:
    ahead, behind = [1, 2, 0], [2, 0, 1]
    return one[..., ahead] * other[..., behind] - one[..., behind] * other[..., ahead]


def dot(one: Interval, other: Interval) -> Interval:
    return (one * other).sum()


def normalised(vector: ArrayLike) -> Interval:
    exact = exactly(vector)
    return exact / exact.norm()[..., None]


def skew(vector: Interval) -> Interval:
    """Return the matrix (3, 3) of the cross product with a vector."""
    return cross(vector[None], exactly(np.eye(3))).transposed


def rotation_of(quaternion: ArrayLike) -> Interval:
    """Return the rotation matrix (3, 3) of a quaternion w, x, y, z of any length but zero (Rodrigues)."""
    unit = normalised(quaternion)
    across = skew(unit[1:])
    return exactly(np.eye(3)) + (across * unit[0] + product(across, across)) * exactly(2.0)


def sine_and_cosine(angles: Interval) -> tuple[Interval, Interval]:
    """Bound sines and cosines of intervals (n,): at their middles, widened by half their widths."""
    middle = angles.low + (angles.high - angles.low) / 2.0
    radius = up(np.maximum(up(angles.high - middle), up(middle - angles.low)))
    found = [arb(value).sin_cos() if np.isfinite(value) else (arb("nan"),) * 2 for value in middle.tolist()]
    sides = np.array([[enclosed(side) for side in each] for each in found]).reshape(-1, 2, 2).T
    low, high = np.maximum(down(sides[0] - radius), -1.0), np.minimum(up(sides[1] + radius), 1.0)
    return Interval(low[0], high[0]), Interval(low[1], high[1])


def enclosed(ball: arb) -> tuple[float, float]:
    """Return doubles below and above all numbers of a ball; not a number if there are none."""
    low, high = float(down(float(ball.lower()))), float(up(float(ball.upper())))
    return (low, high) if arb(low) < ball < arb(high) else (np.nan, np.nan)
