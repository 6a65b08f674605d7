"""Joints at given positions."""

from collections.abc import Mapping
from dataclasses import dataclass

from trajopt.arrays import mapping, number
from trajopt.errors import ProblemError
from trajopt.model.requirements.requirement import Requirement

JOINT_TOLERANCE = 1e-4
"""Default tolerance of a goal joint position [rad | m] (MoveIt's)."""


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

    @property
    def joints(self) -> tuple[str, ...]:
        """The joints that are placed."""
        return tuple(self.positions)

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
    given = mapping("joint_positions: positions", positions)
    values = {joint: number(f"position of {joint}", value) for joint, value in given.items()}

    if not values:
        raise ProblemError("joint_positions: name at least one joint")

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
