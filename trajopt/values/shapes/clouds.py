"""Clouds of measurements: points as balls of one radius, occupied cells, and surfaces that show them."""

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

    The radius should be at least half the distance of neighbouring points plus the error of the sensor.

    Attributes:
        points: Centres of the balls, shape (n, 3) [m], read-only; at least one.
        radius: Of each ball [m].

    Raises:
        ShapeError: If there is no point, or a coordinate is not finite.
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
        from trajopt.values.shapes.cloud_files import read_points

        return Points(read_points(path), radius)

    @checked
    def thinned(self, cell: float) -> "Points":
        """Return fewer points with larger balls that contain every ball of this cloud.

        The points in each cube of edge v are replaced by the centre of their bounding box. The radius grows
        by the largest distance of a point from its replacement: at most v * sqrt(3) / 2.

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
    try:
        points = np.array(value, dtype=np.float64, order="C")
    except (TypeError, ValueError, OverflowError) as error:
        raise ShapeError(name, f"must be numbers, is {shown(value)}") from error
    if points.ndim != 2 or points.shape[1] != 3:
        raise ShapeError(name, f"needs shape (any, 3), has {points.shape}")
    if not len(points):
        raise ShapeError(name, "is empty: omit the object if nothing was measured")
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
            "Crop the farthest points",
        )
    return readonly(points)


ROUNDED_UP = 1.0 + 1e-12
"""Factor that covers the rounding of the largest distance, so that the balls contain the originals."""


def one_in_each_cell(points: Floats, cell: float) -> tuple[Floats, float]:
    """Replace the points in each cube by the centre of their box; also return the largest shift [m]."""
    order, begins = _by_cell(points, cell)
    sorted_points = points[order]
    lower = np.minimum.reduceat(sorted_points, begins, axis=0)
    upper = np.maximum.reduceat(sorted_points, begins, axis=0)
    middles = (lower + upper) / 2.0
    sizes = np.diff(np.append(begins, len(points)))
    apart = np.linalg.norm(sorted_points - np.repeat(middles, sizes, axis=0), axis=1)
    return readonly(middles), float(apart.max()) * ROUNDED_UP


def _by_cell(points: Floats, cell: float) -> tuple[Ints, Ints]:
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


@dataclass(frozen=True, eq=False)
class Voxels(Value):
    """Occupied cells of a grid, as in octrees and occupancy maps: exactly these cubes are solid.

    The cell with the key (i, j, k) is the cube from (i, j, k) * size to (i + 1, j + 1, k + 1) * size.

    Attributes:
        keys: Whole numbers, shape (n, 3), read-only; at least one cell. Duplicates count once.
        size: Edge of a cube [m].

    Raises:
        ShapeError: If there is no cell, or a key is not a whole number.
        SizeError: If the size is not positive, or the grid is wider than 50 m.
    """

    keys: Ints
    size: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "size", length("Voxels.size", self.size))
        object.__setattr__(self, "keys", _keys_of("Voxels.keys", self.keys, self.size))

    def __repr__(self) -> str:
        many = "1 cell" if len(self.keys) == 1 else f"{len(self.keys)} cells"
        return f"Voxels({many}, size={self.size:.4g})"

    def __len__(self) -> int:
        return len(self.keys)

    @staticmethod
    @checked
    def from_file(path: Path | str) -> "Voxels":
        """Read the occupied cells of an octree file; needs the extra `octomap`.

        Cells are split to the smallest size in the file; unknown and free space is skipped.

        Args:
            path: A `.bt` or `.ot` file of OctoMap.

        Raises:
            MissingExtra: Without octomap-python.
            FileFormatError: If the file is missing, malformed, of another format, or has no occupied cell.
        """
        from trajopt.values.shapes.cloud_files import read_octree

        return Voxels(*read_octree(path))

    @cached_property
    def centres(self) -> Floats:
        """Centres of the cubes, shape (n, 3) [m], read-only."""
        return readonly((self.keys.astype(np.float64) + 0.5) * self.size)

    @cached_property
    def box(self) -> tuple[Floats, Floats]:
        """Lower and upper corner of the axis-aligned box around the cubes, (3,) [m]."""
        return readonly(self.keys.min(axis=0) * self.size), readonly((self.keys.max(axis=0) + 1) * self.size)

    @cached_property
    def sphere(self) -> tuple[Floats, float]:
        """Centre (3,) and radius [m] of a sphere around all cubes."""
        centre = (self.box[0] + self.box[1]) / 2
        apart = np.abs(self.centres - centre) + self.size / 2
        return readonly(centre), float(np.linalg.norm(apart, axis=1).max())


def _keys_of(name: str, value: ArrayLike, size: float) -> Ints:
    try:
        numbers = np.array(value, dtype=np.float64)
    except (TypeError, ValueError, OverflowError) as error:
        raise ShapeError(name, f"must be whole numbers, is {shown(value)}") from error
    if numbers.ndim != 2 or numbers.shape[1] != 3:
        raise ShapeError(name, f"needs shape (any, 3), has {numbers.shape}")
    if not len(numbers):
        raise ShapeError(name, "is empty: omit the object if no cell is occupied")
    whole = (np.abs(numbers) < 2.0**52).all(axis=1) & (numbers == np.floor(numbers)).all(axis=1)
    if not whole.all():
        first = int(np.argmin(whole))
        raise ShapeError(name, f"is not a whole number at [{first}]: {numbers[first].tolist()}")
    wide = float(np.ptp(numbers, axis=0).max() + 1.0) * size
    if wide > LARGEST_SIZE:
        raise SizeError(name, f"reach over {wide:g} m, and {LARGEST_SIZE:g} m are the most")
    order, begins = _by_cell(numbers, 1.0)  # numpy.unique of rows takes ten times as long
    keys = numbers[order[begins]].astype(np.int64)
    keys.flags.writeable = False
    return keys


MOST_SHOWN = 20_000
"""Most drawn balls or cubes; larger clouds are drawn coarser."""


def cloud_surface(cloud: Points | Voxels) -> tuple[Floats, Ints]:
    """Return triangles that show a cloud, outward: an octahedron for each ball, outer faces of cubes."""
    shown = fewer(cloud, MOST_SHOWN)
    if isinstance(shown, Voxels):
        return _cubes(shown)
    corners = np.concatenate((np.eye(3), -np.eye(3))) * shown.radius
    faces = np.array([(0, 1, 2), (1, 3, 2), (3, 4, 2), (4, 0, 2), (1, 0, 5), (3, 1, 5), (4, 3, 5), (0, 4, 5)])
    first = 6 * np.arange(len(shown))
    vertices = (centres_of(shown)[:, None] + corners).reshape(-1, 3)
    return vertices, (first[:, None, None] + faces).reshape(-1, 3)


def _cubes(cloud: Voxels) -> tuple[Floats, Ints]:
    vertices: list[Floats] = []
    square = np.array(((0, 0), (1, 0), (1, 1), (0, 1)))
    keys = cloud.keys - cloud.keys.min(axis=0) + 1
    span = keys.max(axis=0) + 2
    flat = (keys[:, 0] * span[1] + keys[:, 1]) * span[2] + keys[:, 2]
    strides = (span[1] * span[2], span[2], 1)
    for axis in range(3):
        for side in (0, 1):
            open_ = ~np.isin(flat + (2 * side - 1) * strides[axis], flat)
            corners = np.zeros((4, 3), dtype=np.int64)
            corners[:, (axis + 1) % 3], corners[:, (axis + 2) % 3] = square[:: 2 * side - 1].T
            corners[:, axis] = side
            vertices.append(
                ((cloud.keys[open_][:, None] + corners).astype(np.float64) * cloud.size).reshape(-1, 3)
            )
    found = np.concatenate(vertices)
    first = 4 * np.arange(len(found) // 4)[:, None, None]
    return found, (first + np.array(((0, 1, 2), (0, 2, 3)))).reshape(-1, 3)


def fewer(cloud: Points | Voxels, most: int) -> Points | Voxels:
    """Return a coarser cloud with at most `most` (>= 8) balls or cubes, which contain the original ones."""
    while len(cloud) > most:
        if isinstance(cloud, Voxels):
            cloud = Voxels(cloud.keys >> 1, 2.0 * cloud.size)
        else:
            cell, thin = cloud.radius / 2.0, cloud
            while len(thin) > most:
                cell *= 2.0
                thin = cloud.thinned(min(cell, LARGEST_SIZE))
            cloud = thin
    return cloud


def centres_of(cloud: Points | Voxels) -> Floats:
    """Return the centres of the balls or cubes of a cloud, shape (n, 3) [m]."""
    return cloud.points if isinstance(cloud, Points) else cloud.centres
