"""The largest gap between two convex bodies over all directions, in plain Python, by cutting planes.

Along a unit direction n the gap is the least n @ w over the differences w between points of the second
body and points of the first. Whichever differences are known, the least n @ w over them is never below the
gap; each direction that is measured adds the difference that decides there.
"""

from dataclasses import dataclass, field

import numpy as np

from trajopt.values.arrays import Floats
from trajopt.values.placement import Placement
from trajopt.values.shapes.mesh import Mesh
from trajopt.values.shapes.shapes import Box, Capsule, Cone, Convex, Cylinder, Plane, Shape, Sphere

_DIRECTIONS = 2000
_WIDEST = 2.0 * float(np.sqrt(4.0 * np.pi / _DIRECTIONS))
"""So that the next even directions are within it [rad]."""
_STARTS = 12
"""Between even directions a lower one may lead to a larger gap."""
_ROUNDS = 48
_ATTEMPTS = 100
_CUTS = 24
"""Of a model of the gap: its peaks grow with the square of them."""
_NEGLIGIBLE = 1e-10
"""Gaps that no model allows to be larger by more are the largest [m]."""
_ROUNDING = 1e-13
"""Of products with differences, relative to the longest of them."""


def largest_gap(first: Shape, second: Shape, where: Placement) -> float:
    """Search all directions for the largest gap: always a lower bound, nearly the distance.

    Args:
        first: One shape.
        second: The other.
        where: Placement of the second in the first one's frame.
    """

    summit = _Summit(first, second, where)
    even = _spread_evenly(_DIRECTIONS)
    gaps = np.einsum("ij,ij->i", even, summit.differences(even))
    for _ in range(_STARTS):
        middle = even[int(gaps.argmax())]
        summit.climb(middle, _WIDEST)
        gaps[even @ middle > np.cos(_WIDEST)] = -np.inf
    spread = _WIDEST
    for _ in range(_ROUNDS):
        model = summit.climb(summit.best, spread)
        if len(model.peaks):
            spread /= 4.0
        elif (model.sides @ summit.best).min() < 1e-3 * spread:
            spread = min(2.0 * spread, _WIDEST)
        else:
            break
    return summit.largest - _rounding(first) - _rounding(second)


@dataclass
class _Summit:
    """The direction of the largest gap of two shapes without their roundings, so far."""

    first: Shape
    second: Shape
    where: Placement
    best: Floats = field(default_factory=lambda: np.array((1.0, 0.0, 0.0)))
    largest: float = -np.inf

    def differences(self, n: Floats) -> Floats:
        """Return the second shape's point less the first one's that decide the gaps along n, shape (c, 3)."""
        there = self.where.translation + _core(self.second, -n @ self.where.rotation) @ self.where.rotation.T
        return there - _core(self.first, n)

    def climb(self, n: Floats, spread: float) -> "_Model":
        """Search around a direction until no gap there is larger, or the model has too many cuts."""
        model = _Model.around(n, spread)
        for _ in range(_ATTEMPTS):
            w = self.differences(n[None])[0]
            if n @ w > self.largest:
                self.best, self.largest = n, float(n @ w)
            model.cut(w, self.largest + _NEGLIGIBLE)
            if len(model.peaks) == 0 or len(model.cuts) >= _CUTS:
                break
            n = model.peaks[int(model.heights.argmax())]
        return model


@dataclass
class _Model:
    """Upper model of the gap in a pyramid of directions.

    Attributes:
        middle: Of the pyramid.
        sides: Normals of its sides, inward, shape (4, 3).
        cuts: Differences that decide somewhere, shape (k, 3) [m].
        peaks: Directions in which the model may be highest, shape (p, 3).
        heights: The model there, shape (p,) [m].
        size: Of the longest difference [m].
    """

    middle: Floats
    sides: Floats
    cuts: Floats
    peaks: Floats
    heights: Floats
    size: float = 0.0

    @classmethod
    def around(cls, middle: Floats, spread: float) -> "_Model":
        least = np.eye(3)[int(np.abs(middle).argmin())]
        across = least - middle * float(middle @ least)
        across /= float(np.linalg.norm(across))
        up = np.asarray(np.cross(middle, across), dtype=np.float64)
        sides = np.sin(spread) * middle + np.cos(spread) * np.stack((across, -across, up, -up))
        return cls(middle, sides, np.empty((0, 3)), np.empty((0, 3)), np.empty(0))

    def cut(self, w: Floats, found: float) -> None:
        """Add a difference, and forget what does not rise above `found`."""
        self.size = max(self.size, float(np.linalg.norm(w)))
        same = _ROUNDING * self.size
        kept = (self.heights > found) & (self.peaks @ w >= self.heights - same)
        directions = self._meetings(w)
        heights = directions @ w
        # Where another difference or the border decides, w does not.
        new = (heights > found) & (directions @ self.sides.T >= -_ROUNDING).all(axis=1)
        new &= (directions @ self.cuts.T >= heights[:, None] - same).all(axis=1)
        self.peaks = np.vstack((self.peaks[kept], directions[new]))
        self.heights = np.concatenate((self.heights[kept], heights[new]))
        cuts = np.vstack((self.cuts, w))
        self.cuts = cuts[np.any(self.peaks @ cuts.T <= self.heights[:, None] + same, axis=0)]

    def _meetings(self, w: Floats) -> Floats:
        """Return the best direction of w alone, and those where w meets one or two others or the border."""
        edges = np.vstack((self.sides, self.cuts[(self.cuts != w).any(axis=1)] - w))
        one, other = np.triu_indices(len(edges), 1)
        single = w - edges * (edges @ w / (edges**2).sum(axis=1))[:, None]
        directions = np.vstack((w, single, np.cross(edges[one], edges[other])))
        length = np.linalg.norm(directions, axis=1)
        directions = directions[length > 0.0] / length[length > 0.0, None]
        return np.where((directions @ self.middle < 0.0)[:, None], -directions, directions)


def _core(shape: Shape, directions: Floats) -> Floats:
    """Return the farthest points of a shape along directions, without its rounding, shape (c, 3) [m]."""
    x, y, z = directions.T
    across = np.hypot(x, y)
    rim = np.where(across > 0.0, across, 1.0)
    match shape:
        case Box():
            return np.copysign((shape.x / 2, shape.y / 2, shape.z / 2), directions)
        case Sphere():
            return np.zeros_like(directions)
        case Capsule():
            return np.stack((0.0 * x, 0.0 * y, np.copysign(shape.length / 2, z)), axis=1)
        case Cylinder():
            end = np.copysign(shape.length / 2, z)
            return np.stack((shape.radius * x / rim, shape.radius * y / rim, end), axis=1)
        case Cone():
            tip = z * shape.length >= across * shape.radius
            round_ = np.where(tip, 0.0, shape.radius / rim)
            return np.stack((round_ * x, round_ * y, np.where(tip, 0.5, -0.5) * shape.length), axis=1)
        case Convex() | Mesh():
            return shape.vertices[(directions @ shape.vertices.T).argmax(axis=1)]
        case Plane():
            raise TypeError("a half-space has no farthest point")


def _rounding(shape: Shape) -> float:
    return shape.radius if isinstance(shape, Sphere | Capsule) else 0.0


def _spread_evenly(count: int) -> Floats:
    """Return unit vectors spread evenly over the sphere along a spiral, shape (count, 3)."""
    height = 1.0 - (2.0 * np.arange(count) + 1.0) / count
    angle = np.pi * (1.0 + np.sqrt(5.0)) * np.arange(count)
    radius = np.sqrt(1.0 - height**2)
    return np.stack((radius * np.cos(angle), radius * np.sin(angle), height), axis=1)
