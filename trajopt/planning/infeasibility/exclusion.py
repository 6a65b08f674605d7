"""Requirements that exclude each other: a proof for two, or a smallest conflicting set.

Proofs are by the triangle inequality of angles, and by the fixed distance of two points of a body.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from trajopt.geometry import Evaluator
from trajopt.optimise.kinematics.inverse import random_starts
from trajopt.optimise.kinematics.projection import Projection
from trajopt.optimise.terms.joint_positions import without_followers
from trajopt.problem.requirements import (
    AxisAlignment,
    FramePlacement,
    JointPositions,
    PositionInRegion,
    Requirement,
    RotationCoordinates,
)
from trajopt.robot.joints import EXCESS, joint_unit
from trajopt.scene.reduced import ReducedModel
from trajopt.values.arrays import Floats
from trajopt.values.printed import in_unit
from trajopt.values.shapes.shapes import Box, Cylinder, Shape, Sphere

ACCURACY = 1e-6
"""A smaller excess proves nothing [m | rad]."""


@dataclass(frozen=True, eq=False)
class _Direction:
    """An axis of a joint's frame within a cone about a direction of another joint's frame."""

    axis: Floats
    direction: Floats
    cone: float


@dataclass(frozen=True, eq=False)
class _Place:
    """A point of a joint's frame within a radius of a point of another joint's frame."""

    point: Floats
    centre: Floats
    radius: float


def exclusion(first: Requirement, second: Requirement, reduced: ReducedModel) -> str:
    """Return why two requirements cannot be held together; empty without a proof."""
    if isinstance(first, JointPositions) and isinstance(second, JointPositions):
        pairs = product(without_followers((first,), reduced), without_followers((second,), reduced))
        return next(filter(None, (_joints(one, other, reduced) for one, other in pairs)), "")
    if _bodies(first, reduced) is None or _bodies(first, reduced) != _bodies(second, reduced):
        return ""
    return (
        _turned(first, second, reduced)
        or _apart(first, second, reduced)
        or _outside(first, second, reduced)
        or _outside(second, first, reduced)
    )


def _bodies(required: Requirement, reduced: ReducedModel) -> tuple[int, int] | None:
    if isinstance(required, AxisAlignment | FramePlacement | PositionInRegion):
        return reduced.attachment(required.frame)[0], reduced.attachment(required.reference)[0]
    return None


def _joints(first: Requirement, second: Requirement, reduced: ReducedModel) -> str:
    assert isinstance(first, JointPositions) and isinstance(second, JointPositions)
    for joint in filter(second.positions.__contains__, first.positions):  # a set has no order
        apart = max(
            first.positions[joint] - first.below[joint] - second.positions[joint] - second.above[joint],
            second.positions[joint] - second.below[joint] - first.positions[joint] - first.above[joint],
        )
        if apart > 2.0 * EXCESS:  # the judge accepts as much of each
            excess = in_unit(apart, joint_unit(reduced.scene.robot.model, joint))
            return f"the two positions of {joint} are {excess} farther apart than their tolerances allow"
    return ""


def _turned(first: Requirement, second: Requirement, reduced: ReducedModel) -> str:
    pair = (first, second)
    for one, other in (pair, pair[::-1]):
        if not isinstance(one, AxisAlignment):
            continue
        held = _direction(one, reduced)
        if isinstance(other, AxisAlignment):
            also = _direction(other, reduced)
            have = between(held.axis, also.axis)
            wanted = between(held.direction, also.direction)
            excess = abs(have - wanted) - held.cone - also.cone
        elif isinstance(other, FramePlacement):
            turn = _turn(other, reduced)
            excess = between(turn @ held.axis, held.direction) - held.cone - largest_turn(other)
        else:
            continue
        if excess > ACCURACY:
            return (
                f"the directions that they require are {np.degrees(excess):.1f} deg farther apart than "
                "their tolerances allow"
            )
    if isinstance(first, FramePlacement) and isinstance(second, FramePlacement):
        apart = _turn(first, reduced).T @ _turn(second, reduced)
        angle = float(np.arccos(np.clip((np.trace(apart) - 1.0) / 2.0, -1.0, 1.0)))
        excess = angle - largest_turn(first) - largest_turn(second)
        if excess > ACCURACY:
            return (
                f"the rotations that they require are {np.degrees(excess):.1f} deg farther apart than "
                "their tolerances allow"
            )
    return ""


def _apart(first: Requirement, second: Requirement, reduced: ReducedModel) -> str:
    if not (isinstance(first, FramePlacement) and isinstance(second, FramePlacement)):
        return ""
    one, other = _place(first, reduced), _place(second, reduced)
    wanted = float(np.linalg.norm(one.centre - other.centre))
    have = float(np.linalg.norm(one.point - other.point))
    excess = abs(wanted - have) - one.radius - other.radius
    if excess > ACCURACY:
        return f"the two places are {1000 * excess:.1f} mm farther apart than their tolerances allow"
    return ""


def _outside(first: Requirement, second: Requirement, reduced: ReducedModel) -> str:
    if not (isinstance(first, FramePlacement) and isinstance(second, PositionInRegion)):
        return ""
    one = _place(first, reduced)
    carried = reduced.attachment(second.frame)[1] * second.offset
    base = reduced.attachment(second.reference)[1]
    off = min(distance(shape, (base * where).inverse() * one.centre) for shape, where in second.members)
    excess = off - one.radius - float(np.linalg.norm(one.point - carried))
    if excess > ACCURACY:
        return f"the place is {1000 * excess:.1f} mm farther outside of the region than its tolerance allows"
    return ""


def _direction(required: AxisAlignment, reduced: ReducedModel) -> _Direction:
    frame, base = reduced.attachment(required.frame)[1], reduced.attachment(required.reference)[1]
    return _Direction(frame.rotation @ required.axis, base.rotation @ required.direction, required.tolerance)


def _turn(required: FramePlacement, reduced: ReducedModel) -> Floats:
    """Return the rotation of the carrying joint as seen from the reference's, at the placement itself."""
    frame, base = reduced.attachment(required.frame)[1], reduced.attachment(required.reference)[1]
    return base.rotation @ required.placement.rotation @ frame.rotation.T


def largest_turn(required: FramePlacement) -> float:
    """Return the largest angle by which the frame may be turned from its placement [rad]."""
    tolerance = required.rotation_tolerance
    if required.coordinates is RotationCoordinates.ROTATION_VECTOR:
        return float(np.linalg.norm(tolerance))
    return float(tolerance.sum())


def _place(required: FramePlacement, reduced: ReducedModel) -> _Place:
    frame, base = reduced.attachment(required.frame)[1], reduced.attachment(required.reference)[1]
    return _Place(
        frame * required.offset,
        base * required.placement.translation,
        float(np.linalg.norm(required.position_tolerance)),
    )


def between(a: Floats, b: Floats) -> float:
    return float(np.arctan2(np.linalg.norm(np.cross(a, b)), a @ b))


def distance(shape: Shape, point: Floats) -> float:
    """Return the distance of a point from a shape, 0 inside [m]."""
    match shape:
        case Box():
            half = np.array((shape.x, shape.y, shape.z)) / 2.0
            return float(np.linalg.norm(np.maximum(np.abs(point) - half, 0.0)))
        case Sphere():
            return max(float(np.linalg.norm(point)) - shape.radius, 0.0)
        case Cylinder():
            off = np.array((np.hypot(*point[:2]) - shape.radius, abs(point[2]) - shape.length / 2.0))
            return float(np.linalg.norm(np.maximum(off, 0.0)))
        case _:
            return max(float(point[2]), 0.0)


STARTS = 1024
"""Starts of the search of each subset: a set that can be held must not be called a conflict."""


def conflicting(
    query: Evaluator, requirements: Sequence[Requirement], *, rng: np.random.Generator
) -> tuple[Requirement, ...]:
    """Return requirements for which no common configuration was found, a minimal set.

    Without any one of them, the others can be held together. Source: the deletion filter of Chinneck and
    Dravnieks, Locating minimal infeasible constraint sets in linear programs, ORSA J. Computing 1991, with
    the search of goal configurations as its oracle.

    Args:
        query: Of the robot and its limits; collisions are not considered.
    """
    reduced, begin = query.reduced, random_starts(query.reduced, rng, STARTS)
    kept = list(requirements)
    for item in requirements:
        rest = [other for other in kept if other is not item]
        if rest and (Projection(reduced, rest, query)(begin).violation > 0.0).all():
            kept = rest
    return tuple(kept)
