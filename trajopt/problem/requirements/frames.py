"""Requirements on frames: placement, alignment of an axis, and gaze."""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import Enum

import numpy as np
from numpy.typing import ArrayLike

from trajopt.problem.requirement import DEGREES, MILLIMETRES, Relaxation, Requirement, ShownUnit
from trajopt.values.arrays import Floats, direction_of, floats, number, one_of, readonly
from trajopt.values.errors import ProblemError, ShapeError, shown
from trajopt.values.errors.arguments import checked
from trajopt.values.likely_units import stated_angle, stated_angles, warn_of_wide_tolerance
from trajopt.values.placement import WORLD, Placement, PlacementLike, as_placement
from trajopt.values.printed import (
    in_axis,
    in_degrees,
    in_direction,
    in_length,
    in_point,
    in_stated_angle,
    in_unit,
    seen_from,
)

POSITION_TOLERANCE = 1e-4
"""Default tolerance of a goal position, per axis [m]."""
ROTATION_TOLERANCE = 1e-3
"""Default tolerance of a goal orientation, per axis [rad]."""


class RotationCoordinates(Enum):
    """Coordinates of a rotation error (MoveIt's two parametrisations)."""

    ROTATION_VECTOR = "rotation vector"
    XYZ_EULER = "intrinsic x-y-z Euler angles"


@dataclass(frozen=True, eq=False)
class FramePlacement(Requirement):
    """A frame at a placement, within a tolerance per axis.

    The error is e = (R_goal^T (p - p_goal), rotation coordinates of R_goal^T R): position [m] and
    rotation [rad] along the axes of the goal placement. |e_i| must not exceed its tolerance.

    Fields: arguments of `frame_placement`.
    """

    frame: str
    placement: Placement
    reference: str
    position_tolerance: Floats
    rotation_tolerance: Floats
    coordinates: RotationCoordinates
    offset: Floats

    @property
    def units(self) -> tuple[str, ...]:
        return tuple(
            unit
            for unit, tolerance in (("m", self.position_tolerance), ("rad", self.rotation_tolerance))
            if np.isfinite(tolerance).any()
        )

    @property
    def relaxations(self) -> tuple[Relaxation, ...]:
        position, rotation = self.position_tolerance, self.rotation_tolerance
        found: list[Relaxation] = []
        if np.isfinite(position).any():
            found.append(
                Relaxation(
                    what=f"position tolerance of {self.frame}",
                    now=float(position.min()),
                    largest=1.0,
                    unit=MILLIMETRES,
                    apply=lambda amount: replace(self, position_tolerance=readonly(position + amount)),
                )
            )
        if np.isfinite(rotation).any():
            found.append(
                Relaxation(
                    what=f"rotation tolerance of {self.frame}",
                    now=float(rotation.min()),
                    largest=np.pi,
                    unit=DEGREES,
                    apply=lambda amount: replace(self, rotation_tolerance=readonly(rotation + amount)),
                )
            )
        return tuple(found)

    def __str__(self) -> str:
        within = [
            bound
            for bound in (
                _within(self.position_tolerance, MILLIMETRES),
                _within(self.rotation_tolerance, DEGREES),
            )
            if bound
        ]
        free = [
            f"free {how} {', '.join(axis for axis, size in zip('xyz', sizes, strict=True) if np.isinf(size))}"
            for how, sizes in (("along", self.position_tolerance), ("about", self.rotation_tolerance))
            if np.isinf(sizes).any()
        ]
        seen = "" if self.reference == WORLD else f" from {self.reference}"
        return ", ".join((f"{self.frame} at {self.placement}{seen}", f"within {' and '.join(within)}", *free))

    def in_full(self) -> str:
        """Describe it with the directions of the frame's axes, unless they may tilt freely."""
        if not np.isfinite(self.rotation_tolerance).all():
            return str(self)
        z, x = (in_direction(self.placement.rotation[:, axis], self.reference) for axis in (2, 0))
        return f"{self}; its z points {z}, its x {x}"


def _within(tolerance: Floats, unit: ShownUnit) -> str:
    sizes = {
        axis: f"{size / unit.size:.3g}"
        for axis, size in zip("xyz", tolerance, strict=True)
        if np.isfinite(size)
    }
    if len(set(sizes.values())) == 1:
        return f"{next(iter(sizes.values()))} {unit.name}"
    return f"{', '.join(f'{axis} {size}' for axis, size in sizes.items())} {unit.name}" if sizes else ""


@checked
def frame_placement(
    frame: str,
    placement: PlacementLike,
    *,
    reference: str = WORLD,
    position_tolerance: ArrayLike = POSITION_TOLERANCE,
    rotation_tolerance: ArrayLike | None = None,
    coordinates: RotationCoordinates = RotationCoordinates.ROTATION_VECTOR,
    offset: ArrayLike = (0.0, 0.0, 0.0),
    degrees: bool = False,
) -> FramePlacement:
    """Require a frame at a placement: as a goal at the end, as a path constraint all the way.

    Args:
        frame: Link, tool frame or attached object.
        placement: Required placement in `reference`.
        reference: "world", or the frame in which the placement is given.
        position_tolerance: One for all axes or one each [m]; inf leaves an axis free.
        rotation_tolerance: One for all axes or one each [rad]; inf leaves an axis free; 1e-3 rad by default.
        coordinates: Coordinates of the rotation error.
        offset: Point of the frame to place, in the frame's coordinates, shape (3,) [m].
        degrees: Whether the rotation tolerance is in degrees.

    Raises:
        ShapeError: If a number is not usable.
        ProblemError: If a tolerance is negative or every axis is free.

    Warns:
        UnitWarning: If a rotation tolerance in radians is beyond a whole turn, or a finite position
            tolerance is two metres or more.
    """

    def three(name: str, value: ArrayLike) -> Floats:
        try:
            spread = np.broadcast_to(np.asarray(value, dtype=float), (3,))
        except (TypeError, ValueError, OverflowError) as error:
            raise ShapeError(name, f"must be one number or three, is {shown(value)}") from error
        array = floats(name, spread, (3,), infinite=True)
        if (array < 0.0).any():
            least, unit = float(array.min()), "m" if name.startswith("position") else "rad"
            raise ProblemError(f"{name} is negative: {in_unit(least, unit)}")
        return array

    position = three("position_tolerance", position_tolerance)
    warn_of_wide_tolerance("position_tolerance", position)
    if rotation_tolerance is None:
        one_of("degrees", degrees, bool)
        rotation = three("rotation_tolerance", ROTATION_TOLERANCE)
    else:
        given = three("rotation_tolerance", rotation_tolerance)
        rotation = stated_angles("rotation_tolerance", given, (3,), degrees=degrees, infinite=True)
    if np.isinf(position).all() and np.isinf(rotation).all():
        raise ProblemError(f"frame_placement({shown(frame)}): every axis is free, nothing is required")
    return FramePlacement(
        frame,
        as_placement("placement", placement),
        reference,
        position,
        rotation,
        coordinates,
        floats("offset", offset, (3,)),
    )


@dataclass(frozen=True, eq=False)
class AxisAlignment(Requirement):
    """An axis of a frame lies within a cone about a direction; spin about it is free.

    Fields: arguments of `axis_alignment`.
    """

    frame: str
    axis: Floats
    direction: Floats
    tolerance: float
    reference: str

    @property
    def units(self) -> tuple[str, ...]:
        return ("rad",)

    @property
    def relaxations(self) -> tuple[Relaxation, ...]:
        return (self.relaxed("tolerance", f"tilt of {self.frame}", np.pi - self.tolerance - 1e-3, DEGREES),)

    def __str__(self) -> str:
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
        reference: "world", or the frame in which the direction is given.

    Raises:
        ShapeError: If a vector has no length or the tolerance is outside (0, pi).
        ProblemError: If `degrees` is not a bool.
    """
    angle = stated_angle("tolerance", tolerance, degrees=degrees)
    if not 0.0 < angle < np.pi:
        raise ShapeError(
            "tolerance", f"must lie in (0, pi) rad, is {in_stated_angle(angle, degrees=degrees)}"
        )
    return AxisAlignment(
        frame, direction_of("axis", axis), direction_of("direction", direction), angle, reference
    )


@dataclass(frozen=True, eq=False)
class Gaze(Requirement):
    """A target lies within the view cone of a frame's axis and within a range of distances.

    Occlusion is a separate requirement, `LineOfSight`.

    Fields: arguments of `gaze`.
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
    def units(self) -> tuple[str, ...]:
        return ("rad", "m") if self.nearest > 0.0 or np.isfinite(self.farthest) else ("rad",)

    @property
    def relaxations(self) -> tuple[Relaxation, ...]:
        return (self.relaxed("angle", f"view angle of {self.frame}", np.pi - self.angle - 1e-3, DEGREES),)

    def __str__(self) -> str:
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
        frame: Camera: link, tool frame or attached object.
        target: Target point in `reference`, shape (3,) [m].
        angle: Largest angle between the view axis and the direction to the target, in (0, pi) [rad].
        axis: View axis in the frame, shape (3,), any length but zero.
        origin: Optical centre in the frame, shape (3,) [m].
        nearest: Smallest distance of the target [m]; 0 for none.
        farthest: Largest distance of the target [m]; inf for none.
        reference: "world", or the frame that carries the target; it may move.

    Raises:
        ShapeError: If a number is not usable, or the angle is outside (0, pi).
        ProblemError: Unless 0 <= nearest < farthest.
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
