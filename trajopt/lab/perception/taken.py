"""What one measurement tells: occupied cells, and how far their points may be from what was there."""

from collections.abc import Mapping
from dataclasses import dataclass

from trajopt.lab.perception.sensing import Sensing
from trajopt.values.arrays import Floats, Ints, Value

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
