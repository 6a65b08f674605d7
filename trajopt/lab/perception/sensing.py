"""What is made of what a camera measures: the part of the world that counts, and how coarse it may become."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from trajopt.values.arrays import Floats, Ints, Value, above_zero, at_least, floats, number, several
from trajopt.values.errors import ProblemError, ShapeError, SizeError
from trajopt.values.errors.arguments import checked

MOST_CELLS_ACROSS = 1 << 20
"""A grid of cells reaches so many to each side of the world's origin: three such numbers fit into one."""


@checked
@dataclass(frozen=True, eq=False)
class Workspace(Value):
    """The box of the world that matters, along its axes: what is measured outside is left out.

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
    """How measurements become obstacles.

    Attributes:
        workspace: The box of the world that matters; None for all that is in range.
        cell: Edge of the cubes of which each becomes one point, if anything was measured in it [m]. A gripper
            goes between things that are some centimetres apart: a tenth of that.
        padding: What is measured this near to the robot, or to what it carries, is taken for it [m]. It
            makes up for errors of the camera's placement and of the robot's model.
        sigmas: Of the camera's noise, so many standard deviations are within the balls: with 3, of normally
            distributed errors 99.7 in 100 are.
        tilt: Between neighbouring pixels nothing slips through a surface that is tilted away from facing
            the camera by no more than this [rad]. Beyond 60 degrees cameras measure badly anyway.
        bridged: Depth cameras lose single pixels, and lines of them along edges. A pixel that measured
            nothing is taken to have seen as far as the nearest of those up to so many pixels around it, if
            most of these measured; 0 for none. What is thinner than that may be missed anyway.
        known: Objects of the scene that are measured too, and stay what they are: what is measured as near
            to them as `padding` is left out.
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
        """How far a point of a cell is from its centre at most [m]."""
        return self.cell * np.sqrt(3.0) / 2.0


DEFAULT = Sensing()


ROUNDING = 8.0 * 2.0**-24
"""What coordinates lose in single precision, of the largest of them: half a step in each of the numbers that
they are made of, of three products and of the sums with the shift."""


@dataclass(frozen=True)
class Radius(Value):
    """Of what a ball's radius is made [m].

    Attributes:
        cell: From the middle of a cell to its corner.
        noise: So many standard deviations of the camera's noise as were asked for, where it is largest.
        gap: From a pixel's middle to its corner, on the farthest surface that was measured.
    """

    cell: float
    noise: float
    gap: float

    @property
    def whole(self) -> float:
        """All of it [m]."""
        return self.cell + self.noise + self.gap

    def __str__(self) -> str:
        """Say what it is made of, in millimetres."""
        parts = (
            f"{1e3 * getattr(self, name):.1f} mm for {words}" for name, words in PARTS if getattr(self, name)
        )
        return f"{1e3 * self.whole:.1f} mm: {', '.join(parts)}"


PARTS = (("cell", "its cell"), ("noise", "the camera's noise"), ("gap", "what is between pixels"))


@dataclass(frozen=True, eq=False)
class Taken(Value):
    """What one measurement tells.

    Attributes:
        keys: Numbers of the occupied cells, in rising order, shape (n,).
        radius: Of balls about their centres, of which the union contains what was measured.
        counts: How much was measured, and how much of that is in the workspace.
        positions: Of all joints of the robot then, shape (number of joints,) [rad | m].
    """

    keys: Ints
    radius: Radius
    counts: Mapping[str, int]
    positions: Floats


def radius_for(sensing: Sensing, *, largest: float, noise: float, gap: float) -> Radius:
    """Return the radius of balls about the centres of cells.

    Args:
        sensing: Has the size of the cells.
        largest: No coordinate is larger, of those in the sensor's frame and of those from the first cell [m].
        noise: How far a measured point may be from what was there [m].
        gap: How far what is there may be from the next measured point [m].
    """
    return Radius(float(sensing.spread) + ROUNDING * largest, float(noise), float(gap))
