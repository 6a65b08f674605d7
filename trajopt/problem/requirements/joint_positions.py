"""Joints at given positions."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import cast

import numpy as np

from trajopt.problem.requirements.requirement import RADIANS, Relaxation, Requirement
from trajopt.robot.limits import EXCESS
from trajopt.values.arrays import mapping
from trajopt.values.errors import JointNotFound, ProblemError
from trajopt.values.likely_units import stated_angle

JOINT_TOLERANCE = 1e-4
"""Default tolerance of a goal joint position [rad | m] (MoveIt's)."""


@dataclass(frozen=True, eq=False)
class JointPositions(Requirement):
    """Joints at given positions, within a tolerance below and above.

    Made by `joint_positions`: `below` and `above` are its tolerances, by joint. All are in radians or metres;
    `in_degrees` says that they were given in degrees, so that all joints must be ones that turn.
    """

    positions: Mapping[str, float]
    below: Mapping[str, float]
    above: Mapping[str, float]
    in_degrees: bool = False

    @property
    def joints(self) -> tuple[str, ...]:
        """The joints with a required position."""
        return tuple(self.positions)

    @property
    def relaxations(self) -> tuple[Relaxation, ...]:
        """The tolerances, all by the same amount."""
        what = f"tolerance of {', '.join(self.positions)}"
        now = min((*self.below.values(), *self.above.values()))
        return (Relaxation(what=what, now=now, largest=2.0 * np.pi, unit=RADIANS, apply=self._widened),)

    def _widened(self, amount: float) -> "JointPositions":
        below, above = (
            {joint: value + amount for joint, value in side.items()} for side in (self.below, self.above)
        )
        return replace(self, below=below, above=above)

    def __str__(self) -> str:
        """Say joint = position, with one tolerance where all are the same."""
        sizes = {f"{size:.3g}" for side in (self.below, self.above) for size in side.values()}
        if len(sizes) == 1:
            placed = ", ".join(f"{joint} = {q:.4g}" for joint, q in self.positions.items())
            return f"{placed}, within {sizes.pop()}"
        return ", ".join(
            f"{joint} = {q:.4g} (-{self.below[joint]:.3g}, +{self.above[joint]:.3g})"
            for joint, q in self.positions.items()
        )


def joint_positions(
    positions: Mapping[str, float],
    *,
    tolerance: float | Mapping[str, float] | None = None,
    below: Mapping[str, float] | None = None,
    above: Mapping[str, float] | None = None,
    degrees: bool = False,
) -> JointPositions:
    """Require joints at given positions.

    Joints that are not named are free: a goal for some joints leaves the others wherever suits the motion
    and what else is required, often where they start. To keep them there, name them too.

    Args:
        positions: Joint -> position [rad | m]; at least one.
        tolerance: Largest deviation, one for all or by joint [rad | m]; 1e-4 where none is given.
        below: Tolerance below by joint, where it differs.
        above: Tolerance above by joint, where it differs.
        degrees: Whether positions and tolerances are in degrees; then all joints must turn.

    Raises:
        ProblemError: If no joint is named, or a tolerance is negative.
        ShapeError: If a number is not finite.
        JointNotFound: If a tolerance names a joint without a position.
    """
    given = mapping("joint_positions: positions", positions)
    values = {
        joint: stated_angle(f"position of {joint}", value, degrees=degrees) for joint, value in given.items()
    }

    if not values:
        raise ProblemError("joint_positions: name at least one joint")

    for label, by_joint in (("tolerance", tolerance), ("below", below), ("above", above)):
        if isinstance(by_joint, Mapping) or (label != "tolerance" and by_joint is not None):
            for joint in mapping(label, cast("Mapping[str, float]", by_joint)):
                if joint not in values:
                    raise JointNotFound(f"joint with a position (for {label})", joint, values)

    def bounds(side: Mapping[str, float] | None) -> dict[str, float]:
        result: dict[str, float] = {}
        for joint in values:
            common = tolerance.get(joint) if isinstance(tolerance, Mapping) else tolerance
            given, name = (side or {}).get(joint, common), f"tolerance of {joint}"
            size = stated_angle(name, given, degrees=degrees, default=JOINT_TOLERANCE, infinite=True)
            if size < 0.0:
                raise ProblemError(f"{name} is negative: {given:g}")
            result[joint] = size
        return result

    return JointPositions(values, bounds(below), bounds(above), degrees)


def together(required: Sequence[Requirement]) -> tuple[Requirement, ...]:
    """Return requirements with joint positions of the same joint merged into one.

    Where several name a joint, the merged one allows the range that they share, and aims at its middle.
    Joint positions that share nothing stay as they are, and so does what names no joint twice.

    Args:
        required: What must hold at one moment.
    """
    asked = [item for item in required if isinstance(item, JointPositions)]
    names = list(dict.fromkeys(joint for item in asked for joint in item.positions))
    if len(names) == sum(len(item.positions) for item in asked):
        return tuple(required)
    positions, below, above = dict[str, float](), dict[str, float](), dict[str, float]()
    for joint in names:
        naming = [item for item in asked if joint in item.positions]
        lower = max(item.positions[joint] - item.below[joint] for item in naming)
        upper = min(item.positions[joint] + item.above[joint] for item in naming)
        if lower - upper > 2.0 * EXCESS:
            return tuple(required)
        centre = naming[0].positions[joint]
        if len(naming) > 1:
            mean = float(np.mean([item.positions[joint] for item in naming]))
            middle = 0.5 * (lower + upper)
            centre = middle if np.isfinite(middle) else float(np.clip(mean, lower, upper))
        positions[joint] = centre
        below[joint], above[joint] = max(centre - lower, 0.0), max(upper - centre, 0.0)
    others = (item for item in required if not isinstance(item, JointPositions))
    return (JointPositions(positions, below, above), *others)
