"""What a motion must achieve, as plain data: goals and path constraints.

Each is written once here. The optimiser's term and the judge's check are computed from it by code
of their own, so that one can catch the other's mistakes.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import ArrayLike

from trajopt.arrays import Floats, floats, number, readonly
from trajopt.errors import ProblemError, ShapeError
from trajopt.model.placement import Placement

WORLD = "world"
"""Name of the frame that everything is placed in at last."""

POSITION_TOLERANCE = 1e-4
"""Default tolerance of a goal position, per axis [m]."""
ROTATION_TOLERANCE = 1e-3
"""Default tolerance of a goal orientation, per axis [rad]."""
JOINT_TOLERANCE = 1e-4
"""Default tolerance of a goal joint position [rad | m] (MoveIt's)."""


class RotationCoordinates(Enum):
    """Which three numbers a rotation error is measured in (MoveIt's two parametrisations)."""

    ROTATION_VECTOR = "rotation vector"
    XYZ_EULER = "intrinsic x-y-z Euler angles"


@dataclass(frozen=True)
class Requirement:
    """Base of everything that a motion can be asked to hold."""


@dataclass(frozen=True, eq=False)
class JointPositions(Requirement):
    """Joints at given positions, within a tolerance below and above.

    Attributes:
        positions: Joint -> position [rad | m].
        below: Largest shortfall by joint [rad | m].
        above: Largest excess by joint [rad | m].
    """

    positions: Mapping[str, float]
    below: Mapping[str, float]
    above: Mapping[str, float]

    def __repr__(self) -> str:
        """Show joint = position."""
        parts = (f"{joint}={value:.4g}" for joint, value in self.positions.items())
        return "JointPositions(" + ", ".join(parts) + ")"


def joint_positions(
    positions: Mapping[str, float],
    *,
    tolerance: float | Mapping[str, float] = JOINT_TOLERANCE,
    below: Mapping[str, float] | None = None,
    above: Mapping[str, float] | None = None,
) -> JointPositions:
    """Require joints at given positions.

    Args:
        positions: Joint -> position [rad | m]; at least one.
        tolerance: Largest deviation, one for all or by joint [rad | m].
        below: Tolerance below by joint, where it differs.
        above: Tolerance above by joint, where it differs.

    Raises:
        ProblemError: If no joint is named, or a tolerance is negative.
        ShapeError: If a number is not finite.
    """
    if not positions:
        raise ProblemError("joint_positions: name at least one joint")
    values = {joint: number(f"position of {joint}", value) for joint, value in positions.items()}

    def bounds(side: Mapping[str, float] | None) -> dict[str, float]:
        result: dict[str, float] = {}
        for joint in values:
            common = (
                tolerance if not isinstance(tolerance, Mapping) else tolerance.get(joint, JOINT_TOLERANCE)
            )
            result[joint] = number(f"tolerance of {joint}", (side or {}).get(joint, common), infinite=True)
            if result[joint] < 0.0:
                raise ProblemError(f"tolerance of {joint} is negative: {result[joint]:g}")
        return result

    return JointPositions(values, bounds(below), bounds(above))


@dataclass(frozen=True, eq=False)
class FramePlacement(Requirement):
    """A frame at a placement, within a tolerance per axis.

    The error is e = (R_goal^T (p - p_goal), rotation coordinates of R_goal^T R): position [m] and
    rotation [rad] along the axes of the goal placement. |e_i| must not exceed its tolerance.

    Attributes:
        frame: Link or tool frame of the robot, or an attached object.
        placement: Where it must be, seen from `reference`.
        reference: "world", or a scene object or fixed link whose frame the placement is in.
        position_tolerance: Per axis, shape (3,) [m]; inf leaves an axis free.
        rotation_tolerance: Per axis, shape (3,) [rad]; inf leaves an axis free.
        coordinates: How the rotation error is expressed.
        offset: Point of the frame that is placed, in the frame, shape (3,) [m].
    """

    frame: str
    placement: Placement
    reference: str
    position_tolerance: Floats
    rotation_tolerance: Floats
    coordinates: RotationCoordinates
    offset: Floats

    def __repr__(self) -> str:
        """Show frame, placement, reference and tolerances."""
        return (
            f"FramePlacement({self.frame!r} at {self.placement} in {self.reference!r}, within "
            f"{self.position_tolerance.tolist()} m and {self.rotation_tolerance.tolist()} rad)"
        )


def frame_placement(
    frame: str,
    placement: Placement,
    *,
    reference: str = WORLD,
    position_tolerance: ArrayLike = POSITION_TOLERANCE,
    rotation_tolerance: ArrayLike = ROTATION_TOLERANCE,
    coordinates: RotationCoordinates = RotationCoordinates.ROTATION_VECTOR,
    offset: ArrayLike = (0.0, 0.0, 0.0),
) -> FramePlacement:
    """Require a frame at a placement: as a goal at the end, as a path constraint all the way.

    Args:
        frame: Link, tool frame or attached object.
        placement: Where it must be, seen from `reference`.
        reference: "world", or the name of what the placement is relative to.
        position_tolerance: One for all axes or one each [m]; inf leaves an axis free.
        rotation_tolerance: One for all axes or one each [rad]; inf leaves an axis free.
        coordinates: How the rotation error is expressed.
        offset: Point of the frame that is placed, in the frame's coordinates, shape (3,) [m].

    Raises:
        ShapeError: If a number is not usable.
        ProblemError: If a tolerance is negative or every axis is free.
    """

    def three(name: str, value: ArrayLike) -> Floats:
        try:
            spread = np.broadcast_to(np.asarray(value, dtype=float), (3,))
        except ValueError as error:
            raise ShapeError(name, "needs one number or three") from error
        array = floats(name, spread, (3,), infinite=True)
        if (array < 0.0).any():
            raise ProblemError(f"{name} is negative: {array.tolist()}")
        return array

    position = three("position_tolerance", position_tolerance)
    rotation = three("rotation_tolerance", rotation_tolerance)
    if np.isinf(position).all() and np.isinf(rotation).all():
        raise ProblemError(f"frame_placement({frame!r}): every axis is free, nothing is required")
    return FramePlacement(
        frame, placement, reference, position, rotation, coordinates, floats("offset", offset, (3,))
    )


@dataclass(frozen=True, eq=False)
class AxisAlignment(Requirement):
    """An axis of a frame points along a direction, within a cone; spin about it is free.

    Attributes:
        frame: Link, tool frame or attached object.
        axis: Unit vector in the frame, shape (3,).
        direction: Unit vector in `reference`, shape (3,).
        tolerance: Largest angle between the two [rad].
        reference: "world", or the name of what the direction is relative to.
    """

    frame: str
    axis: Floats
    direction: Floats
    tolerance: float
    reference: str

    def __repr__(self) -> str:
        """Show frame, axis, direction and cone."""
        return (
            f"AxisAlignment(axis {self.axis.round(4).tolist()} of {self.frame!r} along "
            f"{self.direction.round(4).tolist()} in {self.reference!r}, within "
            f"{np.degrees(self.tolerance):.3g} deg)"
        )


def axis_alignment(
    frame: str,
    *,
    axis: ArrayLike = (0.0, 0.0, 1.0),
    direction: ArrayLike = (0.0, 0.0, 1.0),
    tolerance: float,
    reference: str = WORLD,
) -> AxisAlignment:
    """Keep an axis of a frame along a direction: `axis_alignment("cup", tolerance=0.1)` is upright.

    Args:
        frame: Link, tool frame or attached object.
        axis: Axis in the frame, shape (3,), any length but zero.
        direction: Direction in `reference`, shape (3,), any length but zero.
        tolerance: Largest angle between the two, in (0, pi) [rad].
        reference: "world", or the name of what the direction is relative to.

    Raises:
        ShapeError: If a vector has no length or the tolerance is outside (0, pi).
    """

    def unit(name: str, value: ArrayLike) -> Floats:
        vector = floats(name, value, (3,))
        length = float(np.linalg.norm(vector))
        if length < 1e-9:
            raise ShapeError(name, "has no length, so it is no direction")
        return readonly(vector / length)

    angle = number("tolerance", tolerance)
    if not 0.0 < angle < np.pi:
        raise ShapeError("tolerance", f"must lie in (0, pi) rad, is {angle:g}")
    return AxisAlignment(frame, unit("axis", axis), unit("direction", direction), angle, reference)
