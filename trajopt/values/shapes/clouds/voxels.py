"""Occupied cells of a grid: the union of cubes."""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from trajopt.values.arrays import LARGEST_SIZE, Floats, Ints, Value, length, readonly
from trajopt.values.errors import ShapeError, SizeError, shown
from trajopt.values.errors.arguments import checked


@dataclass(frozen=True, eq=False)
class Voxels(Value):
    """Occupied cells of a grid, as in octrees and occupancy maps: exactly these cubes are solid.

    The cell with the key (i, j, k) is the cube from (i, j, k) * size to (i + 1, j + 1, k + 1) * size.

    Attributes:
        keys: Whole numbers, shape (n, 3), read-only; at least one cell. Duplicates count once.
        size: Edge of a cube [m].

    Raises:
        ShapeError: If there is no cell, or a key is not a whole number; the message names it.
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
            MissingExtra: If octomap-python is not installed.
            FileFormatError: If the file is missing, malformed, of another format, or has no occupied cell.
        """
        from trajopt.values.shapes.clouds.files import read_octree

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
    """Return keys as a read-only sorted copy without duplicates.

    Raises:
        ShapeError: If there are none, or one is not a whole number.
        SizeError: If the grid is too wide.
    """
    try:
        numbers = np.array(value, dtype=np.float64)
    except (TypeError, ValueError, OverflowError) as error:
        raise ShapeError(name, f"must be whole numbers, is {shown(value)}") from error
    if numbers.ndim != 2 or numbers.shape[1] != 3:
        raise ShapeError(name, f"needs shape (any, 3), has {numbers.shape}")
    if not len(numbers):
        raise ShapeError(name, "holds no cell: where nothing is occupied, leave the object out")
    whole = (np.abs(numbers) < 2.0**52).all(axis=1) & (numbers == np.floor(numbers)).all(axis=1)
    if not whole.all():
        first = int(np.argmin(whole))
        raise ShapeError(name, f"is no whole number at [{first}]: {numbers[first].tolist()}")
    wide = float(np.ptp(numbers, axis=0).max() + 1.0) * size
    if wide > LARGEST_SIZE:
        raise SizeError(name, f"reach over {wide:g} m, and {LARGEST_SIZE:g} m are the most")
    keys = np.unique(numbers.astype(np.int64), axis=0)
    keys.flags.writeable = False
    return keys
