"""Planning settings of a script: tolerances, time, planner, speed."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

from trajopt.optimise.methods import METHODS
from trajopt.problem.requirements import POSITION_TOLERANCE, ROTATION_TOLERANCE
from trajopt.problem.requirements.joints import JOINT_TOLERANCE
from trajopt.problem.tool_speed import ToolSpeed
from trajopt.server.move_group.outcome import MoveItCommanderException
from trajopt.values.arrays import floats

PIPELINE = "trajopt"
"""The one planning pipeline."""
PLANNERS = tuple(METHODS)
"""Planner ids: the planning methods, the default first."""

PerAxis: TypeAlias = tuple[float, float, float]
"""A number for each of three axes."""


@dataclass(frozen=True, eq=False)
class Settings:
    """Settings of a script; the defaults are MoveIt's.

    Attributes:
        joint_tolerance: Of a joint goal [rad | m].
        position_tolerance: Of a pose, along each of its axes [m]; inf frees an axis.
        orientation_tolerance: Of a pose, about each of its axes [rad].
        planning_time: Time limit [s].
        attempts: Number of plans, of which the one of least duration is returned.
        planner: One of `PLANNERS`.
        velocity_scaling: Factor in (0, 1] on the velocity limits.
        acceleration_scaling: Factor in (0, 1] on the acceleration limits.
        tool_speed: Largest speed of a link; None for no limit.
        workspace: Smallest and largest corner of a box: x, y, z of each [m].
        replanning: Whether `go` plans again after a change of the scene.
        support_surface: The surface on which `place` puts objects.
    """

    joint_tolerance: float = JOINT_TOLERANCE
    position_tolerance: PerAxis = (POSITION_TOLERANCE, POSITION_TOLERANCE, POSITION_TOLERANCE)
    orientation_tolerance: PerAxis = (ROTATION_TOLERANCE, ROTATION_TOLERANCE, ROTATION_TOLERANCE)
    planning_time: float = 5.0
    attempts: int = 1
    planner: str = PLANNERS[0]
    velocity_scaling: float = 0.1
    acceleration_scaling: float = 0.1
    tool_speed: ToolSpeed | None = None
    workspace: tuple[float, ...] = (0.0,) * 6
    replanning: bool = False
    support_surface: str = ""


def per_axis(name: str, value: float | Sequence[float]) -> PerAxis:
    """Return a tolerance for each of three axes, from one number or three; inf frees an axis.

    Raises:
        ShapeError: If it is neither.
        MoveItCommanderException: If a tolerance is negative.
    """
    given = [value] * 3 if isinstance(value, int | float) else value
    x, y, z = floats(name, given, (3,), infinite=True).tolist()
    if min(x, y, z) < 0.0:
        raise MoveItCommanderException(f"{name} is negative: {[x, y, z]}")
    return x, y, z


def one_or_three(tolerance: PerAxis) -> float | list[float]:
    """Return a tolerance in MoveIt's form: one number if all axes have the same."""
    return tolerance[0] if len(set(tolerance)) == 1 else list(tolerance)


def scaling(name: str, value: float) -> float:
    """Return a factor on limits.

    Raises:
        MoveItCommanderException: If it is outside (0, 1].
    """
    if not 0.0 < value <= 1.0:
        raise MoveItCommanderException(f"{name} must lie in (0, 1], is {value}")
    return float(value)
