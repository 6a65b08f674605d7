"""Parameters of the conversion of measurements to obstacles, and the occupied cells of a grid."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from trajopt.scene.camera import Singles
from trajopt.values.arrays import Bools, Floats, Ints, Value, above_zero, at_least, floats, number, several
from trajopt.values.errors import ProblemError, ShapeError, SizeError
from trajopt.values.errors.arguments import checked
from trajopt.values.placement import Placement

MOST_CELLS_ACROSS = 1 << 20
"""Most cells to each side of the world's origin: three such numbers fit into one."""


@checked
@dataclass(frozen=True, eq=False)
class Workspace(Value):
    """The relevant box of the world, from `lower` to `upper` (3,) [m]: measurements outside are skipped."""

    lower: Floats
    upper: Floats

    def __post_init__(self) -> None:
        for name in ("lower", "upper"):
            object.__setattr__(self, name, floats(f"Workspace.{name}", getattr(self, name), (3,)))
        if not (self.lower < self.upper).all():
            raise ShapeError(
                "Workspace.upper", f"must be beyond {self.lower.tolist()} m, is {self.upper.tolist()} m"
            )


@checked
@dataclass(frozen=True, eq=False)
class Sensing(Value):
    """Parameters of the conversion.

    Attributes:
        workspace: The relevant box of the world; None for the whole range.
        cell: Edge of the cubes, each of which becomes one point if occupied [m]. Use a tenth of the gaps that
            a gripper has to fit into.
        padding: Measurements this near to the robot, or to its attached objects, count as robot [m], to cover
            errors of the camera's placement and of the robot's model.
        sigmas: Standard deviations of the noise within the balls: 3 covers 99.7 % of normal errors.
        tilt: Largest tilt of a surface, relative to facing the camera, at which no gap is left between
            neighbouring pixels [rad].
        bridged: A pixel without a measurement takes the nearest one within this number of pixels, if most of
            these measured; 0 turns this off. Thinner things may be missed.
        known: Objects of the scene that are measured too, and stay: measurements within `padding` are
            skipped.
    """

    workspace: Workspace | None = None
    cell: float = 0.005
    padding: float = 0.02
    sigmas: float = 3.0
    tilt: float = float(np.deg2rad(60.0))
    bridged: int = 2
    known: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        above_zero(self, "cell")
        at_least(self, 0.0, "padding", "sigmas", "tilt", "bridged")
        for name in ("cell", "padding", "sigmas"):
            number(f"Sensing.{name}", getattr(self, name))
        if self.tilt > np.deg2rad(89.0):
            raise ProblemError(f"Sensing: tilt must be at most 89 degrees, is {self.tilt:g} rad")
        object.__setattr__(self, "known", several("known", self.known, str))
        if self.workspace is not None:
            farthest = float(np.abs((self.workspace.lower, self.workspace.upper)).max())
            if farthest / self.cell >= MOST_CELLS_ACROSS:
                raise SizeError(
                    "Sensing.cell", f"of {self.cell:g} m is too small for a workspace {farthest:g} m away"
                )

    @property
    def spread(self) -> float:
        """Largest distance of a point of a cell from its centre [m]."""
        return self.cell * np.sqrt(3.0) / 2.0


DEFAULT = Sensing()


ROUNDING = 8.0 * 2.0**-24
"""Relative rounding error of single-precision coordinates: of three products and the sums with the shift."""


@dataclass(frozen=True)
class Radius(Value):
    """Parts of a ball's radius [m].

    Attributes:
        cell: From the centre of a cell to its corner.
        noise: The requested number of standard deviations of the camera's noise, at its largest.
        gap: From a pixel's centre to its corner, on the farthest measured surface.
    """

    cell: float
    noise: float
    gap: float

    @property
    def whole(self) -> float:
        return self.cell + self.noise + self.gap

    def __str__(self) -> str:
        parts = (
            f"{1e3 * getattr(self, name):.1f} mm for {words}" for name, words in PARTS if getattr(self, name)
        )
        return f"{1e3 * self.whole:.1f} mm: {', '.join(parts)}"


PARTS = (("cell", "its cell"), ("noise", "the camera's noise"), ("gap", "what is between pixels"))


@dataclass(frozen=True, eq=False)
class Taken(Value):
    """One processed measurement.

    Attributes:
        radius: Of balls about their centres, whose union contains the measured surface.
    """

    keys: Ints
    radius: Radius
    counts: Mapping[str, int]
    positions: Floats


def radius_for(sensing: Sensing, *, largest: float, noise: float, gap: float) -> Radius:
    """Return the radius of balls about the centres of cells.

    Args:
        largest: Largest coordinate in the computation, for its rounding errors [m].
        noise: Largest error of a measured point [m].
        gap: Largest distance of a surface point from the next measured point [m].
    """
    return Radius(float(sensing.spread) + ROUNDING * largest, float(noise), float(gap))


BITS = 21
"""Bits of a number for each of the three axes."""
LOW = (1 << BITS) - 1
SAME = 1e-9
"""A workspace that ends at the side of a cell, within this share of its edge, ends there."""


def packed(cells: NDArray[np.integer]) -> Ints:
    shifted = cells.astype(np.int64) + MOST_CELLS_ACROSS
    return (shifted[:, 0] << 2 * BITS) | (shifted[:, 1] << BITS) | shifted[:, 2]


def unpacked(keys: Ints) -> Ints:
    split = np.stack((keys >> 2 * BITS, (keys >> BITS) & LOW, keys & LOW), axis=1)
    return split - MOST_CELLS_ACROSS


def centres(keys: Ints, edge: float) -> Floats:
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
    """The range of cells that may be occupied, from the lowest one on."""

    edge: float
    first: Ints
    count: Ints

    @staticmethod
    def around(where: Placement, reach: float, edge: float, workspace: Workspace | None) -> "Grid":
        """Return the cells that intersect a workspace, or else those within reach of a sensor.

        If the workspace does not end at a multiple of the edge, its last cells extend beyond it.
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
        return float(self.count.max()) * self.edge

    def placed(self, where: Placement) -> tuple[Singles, Singles]:
        """Return the rotation (3, 3) and shift (3,) from a sensor's frame to cells from the first."""
        turn = (where.rotation / self.edge).astype(np.float32)
        return turn, (where.translation / self.edge - self.first).astype(np.float32)

    def numbered(self, scaled: Sequence[Singles], valid: Bools) -> NDArray[np.signedinteger]:
        """Return in which cell each measurement is, as a number within this grid; -1 for none.

        Args:
            scaled: Coordinates x, y, z in units of cells from the first; any shape, the same for all.
            valid: Which were measured; changed to those that are in any cell.
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

    The first occurrence of each number, row by row, stays.
    """
    first = numbers >= 0
    first[..., 1:] &= numbers[..., 1:] != numbers[..., :-1]
    if numbers.ndim == 2:
        first[1:] &= numbers[1:] != numbers[:-1]
    return numbers[first]
