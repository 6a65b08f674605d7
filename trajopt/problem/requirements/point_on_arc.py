"""A point of a frame on a circle or an arc of one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from trajopt.problem.requirements.requirement import MILLIMETRES, Relaxation, Requirement
from trajopt.values.arrays import Floats, floats, positive
from trajopt.values.errors import ProblemError
from trajopt.values.errors.arguments import checked
from trajopt.values.likely_units import stated_angle
from trajopt.values.placement import WORLD, Placement, PlacementLike, as_placement
from trajopt.values.printed import in_degrees, in_length, in_stated_angle, seen_from


@dataclass(frozen=True, eq=False)
class PointOnArc(Requirement):
    """A point of a frame is within a distance of an arc.

    Made by `point_on_arc`, whose arguments are its fields.
    """

    frame: str
    centre: Placement
    radius: float
    sweep: float
    tolerance: float
    reference: str
    offset: Floats

    @property
    def frames(self) -> tuple[str, ...]:
        """Frame and reference."""
        return (self.frame, self.reference)

    @property
    def units(self) -> tuple[str, ...]:
        """Metres."""
        return ("m",)

    @property
    def relaxations(self) -> tuple[Relaxation, ...]:
        """The distance from the arc."""
        return (
            Relaxation.of(
                self,
                "tolerance",
                f"distance of {self.frame} from the arc",
                largest=0.99 * self.radius - self.tolerance,
                unit=MILLIMETRES,
            ),
        )

    def __str__(self) -> str:
        """Say circle or arc, where it is, and the tolerance."""
        whole = self.sweep >= 2.0 * np.pi - 1e-9
        shape = "a circle" if whole else f"an arc of {in_degrees(self.sweep)}"
        where = f"{self.centre}{seen_from(self.reference)}"
        on = f"{self.frame} on {shape} of radius {in_length(self.radius)} about {where}"
        return f"{on}, within {in_length(self.tolerance)}"


@checked
def point_on_arc(
    frame: str,
    centre: PlacementLike,
    *,
    radius: float,
    tolerance: float,
    sweep: float | None = None,
    reference: str = WORLD,
    offset: ArrayLike = (0.0, 0.0, 0.0),
    degrees: bool = False,
) -> PointOnArc:
    """Require a point of a frame on an arc.

    Args:
        frame: Link, tool frame or attached object.
        centre: Placement of the circle in `reference`: about its z axis, the arc begins on its x
            axis and turns towards y.
        radius: Radius of the circle [m].
        tolerance: Largest distance from the arc, less than the radius [m].
        sweep: Angle of the arc, in (0, 2 pi] [rad]; the whole circle when None.
        reference: "world", or the name of what the circle is placed in; it may move.
        offset: The point, in the frame's coordinates, shape (3,) [m].
        degrees: Whether `sweep` is in degrees.

    Raises:
        ShapeError: If a number is not usable.
        ProblemError: If radius, tolerance or sweep is out of its range.
    """
    size, within = positive("radius", radius), positive("tolerance", tolerance)
    if within >= size:
        raise ProblemError(
            f"tolerance must be less than the radius {in_length(size)}, is {in_length(within)}"
        )
    angle = stated_angle("sweep", sweep, degrees=degrees, default=2.0 * np.pi)
    if not 0.0 < angle <= 2.0 * np.pi:
        raise ProblemError(f"sweep must lie in (0, 2 pi] rad, is {in_stated_angle(angle, degrees=degrees)}")
    where = as_placement("centre", centre)
    return PointOnArc(frame, where, size, angle, within, reference, floats("offset", offset, (3,)))
