"""A cloud of points: the union of balls of one radius about them."""

from dataclasses import dataclass
from functools import cached_property
from math import prod
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from trajopt.values.arrays import LARGEST_SIZE, Bools, Floats, Ints, Value, length, readonly
from trajopt.values.errors import ShapeError, SizeError, shown
from trajopt.values.errors.arguments import checked


@dataclass(frozen=True, eq=False)
class Points(Value):
    """A cloud of measured points, each the centre of a ball: exactly the union of these balls is solid.

    Nothing is solid between the balls, so the radius should be at least half the distance of neighbouring
    points plus the error of the sensor.

    Attributes:
        points: Centres of the balls, shape (n, 3) [m], read-only; at least one.
        radius: Of each ball [m].

    Raises:
        ShapeError: If there is no point, or a coordinate is not finite; the message names the point.
        SizeError: If the radius is not positive, or the cloud is wider than 50 m.
    """

    points: Floats
    radius: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "points", _points_of("Points.points", self.points))
        object.__setattr__(self, "radius", length("Points.radius", self.radius))

    def __repr__(self) -> str:
        many = "1 point" if len(self.points) == 1 else f"{len(self.points)} points"
        return f"Points({many}, radius={self.radius:.4g})"

    def __len__(self) -> int:
        return len(self.points)

    @staticmethod
    @checked
    def from_file(path: Path | str, *, radius: float) -> "Points":
        """Read a cloud from a file.

        Points with a coordinate that is not finite are skipped.

        Args:
            path: A `.ply`, `.pcd`, `.npy` or `.npz` file, with coordinates in metres. An array has shape (n,
                3) or more columns, of which the first three are used; an `.npz` file contains it under the
                name `points`, or as its only array.
            radius: Of each ball [m].

        Raises:
            FileFormatError: If the file is missing, malformed, of another format, or has no point.
        """
        from trajopt.values.shapes.clouds.files import read_points

        return Points(read_points(path), radius)

    @checked
    def thinned(self, cell: float) -> "Points":
        """Return fewer points with larger balls that contain every ball of this cloud.

        Space is divided into cubes of edge v, and the points in each are replaced by the centre of their
        bounding box. The radius grows by the largest distance of a point from its replacement: at most v *
        sqrt(3) / 2, half the diagonal of a cube.

        Args:
            cell: Edge v of the cubes [m].

        Raises:
            SizeError: If it is not positive, or larger than any shape may be.
        """
        middles, farthest = one_in_each_cell(self.points, length("cell", cell))
        return Points(middles, self.radius + farthest)

    @cached_property
    def box(self) -> tuple[Floats, Floats]:
        """Lower and upper corner of the axis-aligned box around the balls, (3,) [m]."""
        columns = self.points.T  # one after the other: along the rows numpy is ten times slower
        lower, upper = (np.array([side(column) for column in columns]) for side in (np.min, np.max))
        return readonly(lower - self.radius), readonly(upper + self.radius)

    @cached_property
    def sphere(self) -> tuple[Floats, float]:
        """Centre (3,) and radius [m] of a sphere around all balls."""
        centre = (self.box[0] + self.box[1]) / 2
        return readonly(centre), float(np.linalg.norm(self.points - centre, axis=1).max()) + self.radius


def _points_of(name: str, value: ArrayLike) -> Floats:
    """Return points as a read-only copy.

    Raises:
        ShapeError: If there are none, or one is not finite.
        SizeError: If the cloud is too wide.
    """
    try:
        points = np.array(value, dtype=np.float64, order="C")
    except (TypeError, ValueError, OverflowError) as error:
        raise ShapeError(name, f"must be numbers, is {shown(value)}") from error
    if points.ndim != 2 or points.shape[1] != 3:
        raise ShapeError(name, f"needs shape (any, 3), has {points.shape}")
    if not len(points):
        raise ShapeError(name, "holds no point: where nothing was seen, leave the object out")
    if not np.isfinite(points).all():
        finite = np.isfinite(points).all(axis=1)
        first, many = int(np.argmin(finite)), int((~finite).sum())
        others = f", and {many - 1} more" * (many > 1)
        raise ShapeError(
            name, f"is not finite at [{first}]: {points[first].tolist()}{others}; leave such points out"
        )
    wide = max(float(np.ptp(column)) for column in points.T)  # along the rows numpy is ten times slower
    if wide > LARGEST_SIZE:
        raise SizeError(
            name,
            f"are spread over {wide:g} m, and {LARGEST_SIZE:g} m are the most: were millimetres meant? "
            "Crop what is far away",
        )
    return readonly(points)


ROUNDED_UP = 1.0 + 1e-12
"""Factor that covers the rounding of the largest distance, so that the balls contain the originals."""


def one_in_each_cell(points: Floats, cell: float) -> tuple[Floats, float]:
    """Replace the points in each cube of a grid by one.

    Args:
        points: Shape (n, 3) [m].
        cell: Edge of the cubes [m].

    Returns:
        Centre of the bounding box of the points of each cube, shape (m, 3) [m], in the order of the cubes;
        and the largest distance of a point from its centre [m].
    """
    order, begins = _by_cell(points, cell)
    sorted_points = points[order]
    lower = np.minimum.reduceat(sorted_points, begins, axis=0)
    upper = np.maximum.reduceat(sorted_points, begins, axis=0)
    middles = (lower + upper) / 2.0
    sizes = np.diff(np.append(begins, len(points)))
    apart = np.linalg.norm(sorted_points - np.repeat(middles, sizes, axis=0), axis=1)
    return readonly(middles), float(apart.max()) * ROUNDED_UP


def _by_cell(points: Floats, cell: float) -> tuple[Ints, Ints]:
    """Return an order of the points by cube, and the first index of each cube in it."""
    keys: Ints = np.floor((points - points.min(axis=0)) / cell).astype(np.int64)
    span = keys.max(axis=0) + 1
    changes: Bools
    if prod(span.tolist()) < 2**62:
        flat = (keys[:, 0] * span[1] + keys[:, 1]) * span[2] + keys[:, 2]
        order = np.argsort(flat, kind="stable")
        changes = np.diff(flat[order]) != 0
    else:
        order = np.lexsort(keys.T[::-1])
        changes = (np.diff(keys[order], axis=0) != 0).any(axis=1)
    return order, np.append(0, np.flatnonzero(changes) + 1)
