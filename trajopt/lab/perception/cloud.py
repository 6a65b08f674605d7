"""What was seen, as a scene has it: points in the world with balls about them that contain it."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

from trajopt.lab.perception.cells import centres
from trajopt.lab.perception.taken import Radius
from trajopt.values.arrays import Floats, Ints, Value, readonly
from trajopt.values.shapes.shapes import Points


@dataclass(frozen=True, eq=False)
class Cloud(Value):
    """What was seen of the world.

    Attributes:
        keys: Numbers of the cells in which something was measured, in rising order, shape (n,).
        cell: Edge of the cells [m].
        radius: Of balls about the cells' centres. Their union contains what was measured, each point by as
            much as its noise, and what is between neighbouring pixels.
        counts: How much was measured, was in the workspace, became cells, and was taken for the robot.
    """

    keys: Ints
    cell: float
    radius: Radius
    counts: Mapping[str, int]

    @cached_property
    def points(self) -> Floats:
        """Centres of the cells, shape (n, 3) in the world [m]."""
        return readonly(centres(self.keys, self.cell))

    @property
    def shape(self) -> Points | None:
        """The balls; None where nothing was seen."""
        return Points(self.points, self.radius.whole) if len(self.keys) else None

    def __len__(self) -> int:
        """Count the points."""
        return len(self.keys)

    def __repr__(self) -> str:
        """Say how many points there are, how large their balls are, and why."""
        told = ", ".join(f"{count} {name}" for name, count in self.counts.items())
        return f"Cloud({len(self)} points with balls of {self.radius}; {told})"
