"""A frame looks at a point: the point is in a view cone, and in range."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from trajopt.problem.requirements.requirement import DEGREES, Relaxation, Requirement
from trajopt.values.arrays import Floats, direction_of, floats, number
from trajopt.values.errors import ProblemError, ShapeError
from trajopt.values.errors.arguments import checked
from trajopt.values.likely_units import stated_angle
from trajopt.values.placement import WORLD
from trajopt.values.printed import in_degrees, in_length, in_point, in_stated_angle, seen_from


@dataclass(frozen=True, eq=False)
class Gaze(Requirement):
    """A target point lies within a view cone of a frame's axis and within a range of distances.

    Whether something stands in between is what `LineOfSight` requires.

    Made by `gaze`, whose arguments are its fields.
    """

    frame: str
    target: Floats
    angle: float
    axis: Floats
    origin: Floats
    nearest: float
    farthest: float
    reference: str

    @property
    def frames(self) -> tuple[str, ...]:
        """Camera and reference."""
        return (self.frame, self.reference)

    @property
    def units(self) -> tuple[str, ...]:
        """Radians, and metres where the distance is bounded."""
        return ("rad", "m") if self.nearest > 0.0 or np.isfinite(self.farthest) else ("rad",)

    @property
    def relaxations(self) -> tuple[Relaxation, ...]:
        """The cone."""
        return (
            Relaxation.of(
                self, "angle", f"view angle of {self.frame}", largest=np.pi - self.angle - 1e-3, unit=DEGREES
            ),
        )

    def __str__(self) -> str:
        """Say the target, the cone in degrees and the range where it is bounded."""
        target = f"{in_point(self.target)}{seen_from(self.reference)}"
        away = [
            f"{how} {in_length(distance)} away"
            for how, distance, bounds in (
                ("at least", self.nearest, self.nearest > 0.0),
                ("at most", self.farthest, np.isfinite(self.farthest)),
            )
            if bounds
        ]
        return ", ".join((f"{self.frame} looks at {target}", f"within {in_degrees(self.angle)}", *away))


@checked
def gaze(
    frame: str,
    target: ArrayLike,
    *,
    angle: float,
    axis: ArrayLike = (0.0, 0.0, 1.0),
    origin: ArrayLike = (0.0, 0.0, 0.0),
    nearest: float = 0.0,
    farthest: float = np.inf,
    reference: str = WORLD,
    degrees: bool = False,
) -> Gaze:
    """Keep looking at a point: `gaze("camera", (0.5, 0, 0.2), angle=0.3)`.

    Args:
        frame: The camera: link, tool frame or attached object.
        target: The point, in `reference`, shape (3,) [m].
        angle: Largest angle between the camera's axis and the direction to the target, in (0, pi) [rad].
        axis: Direction in which the camera looks, in the frame, shape (3,), any length but zero.
        origin: Where in the frame it looks from, shape (3,) [m].
        nearest: Smallest distance of the target [m]; 0 for none.
        farthest: Largest distance of the target [m]; inf for none.
        reference: "world", or the name of what the target is fixed to; it may move.
        degrees: Whether the angle is in degrees.

    Raises:
        ShapeError: If a number is not usable, or the angle is outside (0, pi).
        ProblemError: If the range is not 0 <= nearest < farthest.
    """
    half = stated_angle("angle", angle, degrees=degrees)
    if not 0.0 < half < np.pi:
        raise ShapeError("angle", f"must lie in (0, pi) rad, is {in_stated_angle(half, degrees=degrees)}")
    near, far = number("nearest", nearest), number("farthest", farthest, infinite=True)
    if not 0.0 <= near < far:
        raise ProblemError(f"gaze: needs 0 <= nearest < farthest, has {near:g} m and {far:g} m")
    return Gaze(
        frame,
        floats("target", target, (3,)),
        half,
        direction_of("axis", axis),
        floats("origin", origin, (3,)),
        near,
        far,
        reference,
    )
