"""An axis of a frame along a direction."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from trajopt.problem.requirements.requirement import DEGREES, Relaxation, Requirement
from trajopt.values.arrays import Floats, direction_of
from trajopt.values.errors import ShapeError
from trajopt.values.errors.arguments import checked
from trajopt.values.likely_units import stated_angle
from trajopt.values.placement import WORLD
from trajopt.values.printed import in_axis, in_degrees, in_stated_angle


@dataclass(frozen=True, eq=False)
class AxisAlignment(Requirement):
    """An axis of a frame points along a direction, within a cone; spin about it is free.

    Made by `axis_alignment`, whose arguments are its fields.
    """

    frame: str
    axis: Floats
    direction: Floats
    tolerance: float
    reference: str

    @property
    def frames(self) -> tuple[str, ...]:
        """Frame and reference."""
        return (self.frame, self.reference)

    @property
    def units(self) -> tuple[str, ...]:
        """Radians."""
        return ("rad",)

    @property
    def relaxations(self) -> tuple[Relaxation, ...]:
        """The cone."""
        return (
            Relaxation.of(
                self,
                "tolerance",
                f"tilt of {self.frame}",
                largest=np.pi - self.tolerance - 1e-3,
                unit=DEGREES,
            ),
        )

    def __str__(self) -> str:
        """Say it in degrees."""
        aligned = f"{in_axis(self.axis)} of {self.frame} along {in_axis(self.direction)} of {self.reference}"
        return f"{aligned}, within {in_degrees(self.tolerance)}"


@checked
def axis_alignment(
    frame: str,
    *,
    axis: ArrayLike = (0.0, 0.0, 1.0),
    direction: ArrayLike = (0.0, 0.0, 1.0),
    tolerance: float,
    reference: str = WORLD,
    degrees: bool = False,
) -> AxisAlignment:
    """Keep an axis of a frame along a direction: `axis_alignment("cup", tolerance=0.1)` is upright.

    Args:
        frame: Link, tool frame or attached object.
        axis: Axis in the frame, shape (3,), any length but zero.
        direction: Direction in `reference`, shape (3,), any length but zero.
        tolerance: Largest angle between the two, in (0, pi) [rad].
        reference: "world", or the name of what the direction is relative to.
        degrees: Whether the tolerance is in degrees.

    Raises:
        ShapeError: If a vector has no length or the tolerance is outside (0, pi).
        ProblemError: If `degrees` is neither true nor false.
    """
    angle = stated_angle("tolerance", tolerance, degrees=degrees)
    if not 0.0 < angle < np.pi:
        raise ShapeError(
            "tolerance", f"must lie in (0, pi) rad, is {in_stated_angle(angle, degrees=degrees)}"
        )
    return AxisAlignment(
        frame, direction_of("axis", axis), direction_of("direction", direction), angle, reference
    )
