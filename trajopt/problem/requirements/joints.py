"""Requirements on joints: positions, couplings, gravity torques, distance from singularities."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import cast

import numpy as np
from numpy.typing import ArrayLike

from trajopt.problem.requirement import PERCENT, PLAIN, RADIANS, Relaxation, Requirement
from trajopt.robot.joints import EXCESS
from trajopt.values.arrays import Floats, floats, mapping, number, positive
from trajopt.values.errors import JointNotFound, ProblemError
from trajopt.values.errors.arguments import checked
from trajopt.values.likely_units import stated_angle

JOINT_TOLERANCE = 1e-4
"""Default tolerance of a goal joint position [rad | m] (MoveIt's)."""


@dataclass(frozen=True, eq=False)
class JointPositions(Requirement):
    """Joints at given positions, within a tolerance below and above.

    Made by `joint_positions`: `below` and `above` are the tolerances by joint. All values are in radians or
    metres; `in_degrees` records that they were given in degrees, which requires revolute joints.
    """

    positions: Mapping[str, float]
    below: Mapping[str, float]
    above: Mapping[str, float]
    in_degrees: bool = False

    @property
    def joints(self) -> tuple[str, ...]:
        return tuple(self.positions)

    @property
    def relaxations(self) -> tuple[Relaxation, ...]:
        what = f"tolerance of {', '.join(self.positions)}"
        now = min((*self.below.values(), *self.above.values()))
        return (Relaxation(what=what, now=now, largest=2.0 * np.pi, unit=RADIANS, apply=self._widened),)

    def _widened(self, amount: float) -> JointPositions:
        below, above = (
            {joint: value + amount for joint, value in side.items()} for side in (self.below, self.above)
        )
        return replace(self, below=below, above=above)

    def __str__(self) -> str:
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

    Unnamed joints are free: they end wherever the motion leads them. Name them to keep them at the start.

    Args:
        positions: Joint -> position [rad | m]; at least one.
        tolerance: Largest deviation, one for all or by joint [rad | m]; 1e-4 by default.
        below: Lower tolerance by joint, if different.
        above: Upper tolerance by joint, if different.
        degrees: Whether positions and tolerances are in degrees; requires revolute joints.

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
    """Merge joint positions of the same joint into one requirement.

    The merged requirement allows the intersection of their ranges and aims at its middle. Joint positions
    with an empty intersection, and other requirements, are unchanged.
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


@dataclass(frozen=True, eq=False)
class CoupledJoints(Requirement):
    """A weighted sum of joint positions equals a value, within a tolerance.

    Fields: arguments of `coupled_joints`.
    """

    weights: Mapping[str, float]
    value: float
    tolerance: float

    @property
    def joints(self) -> tuple[str, ...]:
        return tuple(self.weights)

    @property
    def relaxations(self) -> tuple[Relaxation, ...]:
        return (
            self.relaxed("tolerance", f"tolerance of {' and '.join(self.weights)}", 2.0 * np.pi, RADIANS),
        )

    def __str__(self) -> str:
        total = ""
        for joint, weight in self.weights.items():
            sign = ("-" if weight < 0.0 else "") if not total else (" - " if weight < 0.0 else " + ")
            total += sign + (joint if abs(weight) == 1.0 else f"{abs(weight):.4g} {joint}")
        return f"{total} = {self.value:.4g}, within {self.tolerance:.3g}"


def coupled_joints(weights: Mapping[str, float], value: float = 0.0, *, tolerance: float) -> CoupledJoints:
    """Couple joints: `coupled_joints({"left": 1, "right": -1}, tolerance=0.01)` keeps two equal.

    Args:
        weights: Joint -> its factor in the sum of positions [rad | m]; at least one that is not zero.
        tolerance: Largest deviation to either side, > 0.

    Raises:
        ProblemError: If no joint has a factor, or the tolerance is not positive.
        ShapeError: If a number is not finite.
    """
    factors = {
        joint: number(f"weight of {joint}", weight)
        for joint, weight in mapping("coupled_joints: weights", weights).items()
    }
    if not any(factors.values()):
        raise ProblemError("coupled_joints: give at least one joint a factor that is not zero")
    return CoupledJoints(factors, number("value", value), positive("tolerance", tolerance))


SHARE = 0.9
"""Default share of an effort limit for gravity: with r left, a motion takes 1 / sqrt(r) times as long."""


@dataclass(frozen=True, eq=False)
class GravityTorque(Requirement):
    """The gravity torque of each joint stays within a share of its effort limit.

    No timing helps if a joint cannot hold a posture. Attached objects count if the scene gives them a mass.
    Joints without an effort limit are unconstrained.

    Fields: arguments of `gravity_torque`.
    """

    share: float

    @property
    def relaxations(self) -> tuple[Relaxation, ...]:
        return (
            self.relaxed(
                "share", "share of the effort limits that gravity may take", 1.0 - self.share, PERCENT
            ),
        )

    def __str__(self) -> str:
        return f"gravity takes at most {100.0 * self.share:.3g}% of the effort limits"


def gravity_torque(share: float = SHARE) -> GravityTorque:
    """Require that the joints can hold the arm and its attached objects.

    Args:
        share: Share of each joint's effort limit for gravity, in (0, 1].

    Raises:
        ProblemError: If the share is outside (0, 1].
    """
    if positive("share", share) > 1.0:
        raise ProblemError(f"gravity_torque: share is a part in (0, 1] of the effort limits, is {share:g}")
    return GravityTorque(float(share))


LENGTH = 0.3
"""Default length that weights a radian of the frame's rotation [m]."""


@dataclass(frozen=True, eq=False)
class SingularityDistance(Requirement):
    """The smallest singular value of a frame's Jacobian stays above a bound.

    The Jacobian maps joint velocities to (velocity of a point of the frame [m/s], length times angular
    velocity [m/s]), 6 by n. The smallest of its min(6, n) singular values is the speed of the frame in its
    slowest direction (for n < 6: among the directions in which it can move) at joint velocities of Euclidean
    norm one. With length 0 only the point counts: the Jacobian is 3 by n.

    Fields: arguments of `singularity_distance`.
    """

    frame: str
    smallest: float
    length: float
    offset: Floats

    @property
    def relaxations(self) -> tuple[Relaxation, ...]:
        return (
            self.relaxed(
                "smallest",
                f"smallest singular value of {self.frame}",
                0.99 * self.smallest,
                PLAIN,
                shrinks=True,
            ),
        )

    def __str__(self) -> str:
        return f"smallest singular value of {self.frame} at least {self.smallest:.3g}"


@checked
def singularity_distance(
    frame: str,
    smallest: float,
    *,
    length: float = LENGTH,
    offset: ArrayLike = (0.0, 0.0, 0.0),
) -> SingularityDistance:
    """Keep a frame away from singular configurations.

    Args:
        smallest: Smallest accepted singular value, > 0 [m/rad; m/m].
        length: Length that weights a radian of rotation [m]; 0 ignores rotation.
        offset: Point in the frame's coordinates, shape (3,) [m].

    Raises:
        ShapeError: If a number is not usable.
        ProblemError: If the bound is not positive, or the length is negative.
    """
    weight = number("length", length)
    if weight < 0.0:
        raise ProblemError(f"length must not be negative, is {weight:g}")
    return SingularityDistance(frame, positive("smallest", smallest), weight, floats("offset", offset, (3,)))
