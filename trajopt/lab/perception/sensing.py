"""Parameters of the conversion of measurements to obstacles: workspace, resolution and noise."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from trajopt.values.arrays import Floats, Ints, Value, above_zero, at_least, floats, number, several
from trajopt.values.errors import ProblemError, ShapeError, SizeError
from trajopt.values.errors.arguments import checked

MOST_CELLS_ACROSS = 1 << 20
"""Largest number of cells to each side of the world's origin: three such numbers fit into one."""


@checked
@dataclass(frozen=True, eq=False)
class Workspace(Value):
    """The relevant box of the world, along its axes: measurements outside are skipped.

    Attributes:
        lower: Its lower corner, shape (3,) in the world [m].
        upper: Its upper corner, shape (3,) in the world [m].
    """

    lower: Floats
    upper: Floats

    def __post_init__(self) -> None:
        """Check the corners."""
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
        cell: Edge of the cubes, each of which becomes one point if occupied [m]. A gripper fits between
            things that are some centimetres apart; use a tenth of that.
        padding: Measurements this near to the robot, or to its attached objects, count as robot [m]. It
            covers errors of the camera's placement and of the robot's model.
        sigmas: Number of standard deviations of the noise within the balls: 3 covers 99.7 % of normally
            distributed errors.
        tilt: Largest tilt of a surface, relative to facing the camera, at which no gap is left between
            neighbouring pixels [rad]. Beyond 60 degrees cameras are unreliable.
        bridged: Depth cameras lose single pixels, and lines of them along edges. A pixel without a
            measurement takes the nearest one within this number of pixels around it, if most of these
            measured; 0 turns this off. Thinner things may be missed anyway.
        known: Objects of the scene that are measured too, and stay as they are: measurements within `padding`
            of them are skipped.
    """

    workspace: Workspace | None = None
    cell: float = 0.005
    padding: float = 0.02
    sigmas: float = 3.0
    tilt: float = float(np.deg2rad(60.0))
    bridged: int = 2
    known: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        """Check the numbers."""
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
"""Relative rounding error of single-precision coordinates: half a step in each factor, of three products and
of
the sums with the shift.
"""


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
        """All of it [m]."""
        return self.cell + self.noise + self.gap

    def __str__(self) -> str:
        """Return its parts, in millimetres."""
        parts = (
            f"{1e3 * getattr(self, name):.1f} mm for {words}" for name, words in PARTS if getattr(self, name)
        )
        return f"{1e3 * self.whole:.1f} mm: {', '.join(parts)}"


PARTS = (("cell", "its cell"), ("noise", "the camera's noise"), ("gap", "what is between pixels"))


@dataclass(frozen=True, eq=False)
class Taken(Value):
    """One processed measurement.

    Attributes:
        keys: Numbers of the occupied cells, in rising order, shape (n,).
        radius: Of balls about their centres, whose union contains the measured surface.
        counts: Numbers of measurements, in total and in the workspace.
        positions: Of all joints of the robot at its time, shape (number of joints,) [rad | m].
    """

    keys: Ints
    radius: Radius
    counts: Mapping[str, int]
    positions: Floats


def radius_for(sensing: Sensing, *, largest: float, noise: float, gap: float) -> Radius:
    """Return the radius of balls about the centres of cells.

    Args:
        sensing: With the size of the cells.
        largest: Bound of coordinates in the sensor's frame and relative to the first cell [m].
        noise: Largest error of a measured point [m].
        gap: Largest distance of a surface point from the next measured point [m].
    """
    return Radius(float(sensing.spread) + ROUNDING * largest, float(noise), float(gap))
