"""Convex parts, and upper bounds of their support functions."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from intervals import Floats, Interval, exactly, up
from reading import Reader, mapping, numbers, one_of, record, size, text

FEW_ULPS = 4.0 * np.finfo(np.float64).eps
"""Bounds the rounding of a sum of three products, relative to the sum of their sizes: Higham, Accuracy and
Stability of Numerical Algorithms, 2002, section 3.1."""


@dataclass(frozen=True, eq=False)
class Hull:
    """The points within a distance of the convex hull of some points: box, sphere, capsule, polyhedron.

    Attributes:
        vertices: The points, shape (v, 3) [m].
        radius: The distance [m].
    """

    vertices: Floats
    radius: float

    def support(self, direction: Interval) -> Floats:
        """Bound the largest inner product of its points with directions (m, 3) from above, (m,) [m]."""
        middle = direction.low + (direction.high - direction.low) / 2.0
        apart = up(np.maximum(direction.high - middle, middle - direction.low))
        x, y, z = self.vertices.T[:, None, :]
        along = middle[:, :1] * x + middle[:, 1:2] * y + middle[:, 2:] * z
        farthest = np.abs(self.vertices).max(axis=0)
        error = 2.0 * (farthest * (FEW_ULPS * np.abs(middle) + 2.0 * apart)).sum(axis=1)
        tiny = 1e-300  # covers underflow
        return up(up(along.max(axis=1) + error + tiny) + up(self.radius * direction.norm().high)) + tiny

    @property
    def sphere(self) -> tuple[Floats, float]:
        """Centre and radius of a sphere around it [m]."""
        centre = (self.vertices.min(axis=0) + self.vertices.max(axis=0)) / 2.0
        reach = (exactly(self.vertices) - exactly(centre)).norm().high.max()
        return centre, float(up(reach + self.radius))


@dataclass(frozen=True, eq=False)
class Frustum:
    """Cylinder, cone or truncated cone about the z axis.

    Attributes:
        bottom: Radius at z = -length / 2 [m].
        top: Radius at z = length / 2 [m].
        length: Along z [m].
    """

    bottom: float
    top: float
    length: float

    def support(self, direction: Interval) -> Floats:
        across = direction[..., :2].norm()
        along = direction[..., 2] * exactly(self.length / 2.0)
        ends = (across * exactly(self.bottom) - along, across * exactly(self.top) + along)
        return np.maximum(ends[0].high, ends[1].high)

    @property
    def sphere(self) -> tuple[Floats, float]:
        corner = exactly((max(self.bottom, self.top), self.length / 2.0))
        return np.zeros(3), float(corner.norm().high)


@dataclass(frozen=True)
class HalfSpace:
    """All points with z <= 0. It must rest in the frame that it is seen from."""

    def support(self, direction: Interval) -> Floats:
        """Return the largest inner product of its points with its normal, which is the only direction."""
        return np.zeros(len(direction.low))

    @property
    def sphere(self) -> tuple[Floats, float]:
        """Centre and radius of a sphere at its origin, as it rests."""
        return np.zeros(3), 0.0


Shape: TypeAlias = Hull | Frustum | HalfSpace


def read_shape(where: str, value: object) -> Shape:
    kind, readers = KINDS[one_of(KINDS)(f"kind of {where}", mapping(where, value).get("kind"))]
    return kind(*record(where, value, {"kind": text, **readers})[1:])


KINDS: Mapping[str, tuple[Callable[..., Shape], Mapping[str, Reader]]] = {
    "hull": (Hull, {"vertices": numbers(None, 3), "radius": size}),
    "frustum": (Frustum, {"bottom": size, "top": size, "length": size}),
    "half-space": (HalfSpace, {}),
}
