"""Occupied cells of a grid about the world's origin.

A cell (i, j, k) is the cube from (i, j, k) * edge to (i + 1, j + 1, k + 1) * edge. Cells are stored as one
whole number each, in rising order, so that sets are merged by sorting.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from trajopt.lab.perception.sensing import MOST_CELLS_ACROSS, Workspace
from trajopt.scene.camera import Singles
from trajopt.values.arrays import Bools, Floats, Ints, Value
from trajopt.values.placement import Placement

BITS = 21
"""Bits of a number for each of the three axes."""
LOW = (1 << BITS) - 1
SAME = 1e-9
"""A workspace that ends at the side of a cell, within this share of its edge, ends there."""


def packed(cells: NDArray[np.integer]) -> Ints:
    """Return one number for each of the cells (n, 3)."""
    shifted = cells.astype(np.int64) + MOST_CELLS_ACROSS
    return (shifted[:, 0] << 2 * BITS) | (shifted[:, 1] << BITS) | shifted[:, 2]


def unpacked(keys: Ints) -> Ints:
    """Return the cells (n, 3) of their numbers."""
    split = np.stack((keys >> 2 * BITS, (keys >> BITS) & LOW, keys & LOW), axis=1)
    return split - MOST_CELLS_ACROSS


def centres(keys: Ints, edge: float) -> Floats:
    """Return the centres of cells, shape (n, 3) [m]."""
    found = np.empty((len(keys), 3))
    found[:, 0], found[:, 1], found[:, 2] = keys >> 2 * BITS, (keys >> BITS) & LOW, keys & LOW
    found += 0.5 - MOST_CELLS_ACROSS
    found *= edge
    return found


def once(keys: NDArray[np.signedinteger]) -> NDArray[np.signedinteger]:
    """Return each number once, in rising order; faster than `numpy.unique`, which hashes first."""
    if not len(keys):
        return keys
    ordered = np.sort(keys)
    return ordered[np.concatenate(([True], ordered[1:] != ordered[:-1]))]


@dataclass(frozen=True, eq=False)
class Grid(Value):
    """The range of cells that may be occupied.

    Attributes:
        edge: Of a cell [m].
        first: The lowest cell along each axis, shape (3,).
        count: Cells along each axis, shape (3,).
    """

    edge: float
    first: Ints
    count: Ints

    @staticmethod
    def around(where: Placement, reach: float, edge: float, workspace: Workspace | None) -> "Grid":
        """Return the cells that intersect a workspace, or else those within reach of a sensor.

        If the workspace does not end at a multiple of the edge, its last cells extend beyond it: a surface
        measured inside the workspace is always in a cell.

        Args:
            where: Placement of the sensor in the world.
            reach: Its range [m].
            edge: Of a cell [m].
            workspace: None for everything.
        """
        if workspace is not None:
            first = np.floor(workspace.lower / edge + SAME)
            last = np.ceil(workspace.upper / edge - SAME)
        else:
            first = np.floor((where.translation - reach) / edge)
            last = np.ceil((where.translation + reach) / edge)
        far = MOST_CELLS_ACROSS - 1
        first, last = np.clip(first, -far, far), np.clip(last, -far, far)
        return Grid(edge, first.astype(np.int64), np.maximum(last - first, 0.0).astype(np.int64))

    @property
    def across(self) -> float:
        """Its extent along the longest axis [m]."""
        return float(self.count.max()) * self.edge

    def placed(self, where: Placement) -> tuple[Singles, Singles]:
        """Return the rotation (3, 3) and shift (3,) from a sensor's frame to cells from the first."""
        turn = (where.rotation / self.edge).astype(np.float32)
        return turn, (where.translation / self.edge - self.first).astype(np.float32)

    def numbered(self, scaled: Sequence[Singles], valid: Bools) -> NDArray[np.signedinteger]:
        """Return in which cell each measurement is, as a number within this grid; -1 for none.

        Args:
            scaled: Coordinates x, y, z in units of cells from the first; any shape, the same for all.
            valid: Which were measured at all; changed to those that are in any cell.
        """
        kind = np.int32 if float(np.prod(self.count.astype(np.float64))) < 2.0**31 else np.int64
        numbers = np.zeros(valid.shape, dtype=kind)
        for values, many in zip(scaled, self.count.tolist(), strict=True):
            # Comparisons with what is not a number are false; what casts to nonsense is not valid then.
            valid &= values >= 0.0
            valid &= values < many
            numbers *= kind(many)
            with np.errstate(invalid="ignore"):
                numbers += values.astype(kind)
        numbers[~valid] = -1
        return numbers

    def keys(self, numbers: NDArray[np.signedinteger]) -> Ints:
        """Return the numbers that cells have in every grid of this edge, each once, in rising order."""
        across, deep = (numbers.dtype.type(many) for many in self.count[1:].tolist())
        columns, z = np.divmod(once(numbers), deep)
        x, y = np.divmod(columns, across)
        # Both number cells in the order of x, then y, then z: they stay sorted.
        x, y, z = (
            each.astype(np.int64) + (low + MOST_CELLS_ACROSS)
            for each, low in zip((x, y, z), self.first.tolist(), strict=True)
        )
        return (x << 2 * BITS) | (y << BITS) | z


def leaders(numbers: NDArray[np.signedinteger]) -> NDArray[np.signedinteger]:
    """Drop numbers -1, and those equal to their left or upper neighbour in an image.

    The first occurrence of each number, row by row, has no equal before it, and stays.
    """
    first = numbers >= 0
    first[..., 1:] &= numbers[..., 1:] != numbers[..., :-1]
    if numbers.ndim == 2:
        first[1:] &= numbers[1:] != numbers[:-1]
    return numbers[first]
