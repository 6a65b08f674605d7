"""Proofs that every configuration of a box collides, or violates a requirement.

Distances and residuals in the box differ from those at its middle by at most the travel that its joints
cause.
"""

import numpy as np

from trajopt.geometry.dynamics import DynamicsQuery
from trajopt.planning.infeasibility.cover import ConfigurationCover
from trajopt.planning.infeasibility.exclusion import between, distance, largest_turn
from trajopt.planning.infeasibility.reach import Chain
from trajopt.problem.problem import Problem
from trajopt.problem.requirements import (
    AxisAlignment,
    CoupledJoints,
    FramePlacement,
    JointPositions,
    PositionInRegion,
    Requirement,
)
from trajopt.robot.limits import EXCESS
from trajopt.scene.gravity_bound import largest_gravity_slopes
from trajopt.scene.reduced import ReducedModel
from trajopt.values.arrays import Floats

MOST_BOXES = 2000
"""Boxes that are examined before it is left undecided whether all of a goal collides."""
ACCURACY = 1e-6
"""A smaller excess proves nothing [m | rad]."""


def box_collides(reduced: ReducedModel, lower: Floats, upper: Floats) -> bool:
    """Return whether every configuration of a box is proven to be in collision.

    Args:
        reduced: The robot and its surroundings.
        lower: Shape (n,) [rad | m]; finite.
        upper: Shape (n,) [rad | m]; finite.
    """
    return (
        ConfigurationCover(reduced, MOST_BOXES).close(0.5 * (lower + upper), 0.5 * (upper - lower))
        is not None
    )


def box_breaks(required: Requirement, reduced: ReducedModel, lower: Floats, upper: Floats) -> bool:
    """Return whether every configuration of a box is proven to violate a requirement.

    Args:
        required: The requirement.
        reduced: The robot and its surroundings.
        lower: Shape (n,) [rad | m]; finite.
        upper: Shape (n,) [rad | m]; finite.
    """
    middle, half = 0.5 * (lower + upper), 0.5 * (upper - lower)
    match required:
        case JointPositions():
            return _joints_break(required, reduced, middle, half)
        case CoupledJoints():
            place, reach = _each(reduced, tuple(required.weights), middle, half)
            factors = np.array(list(required.weights.values()))
            off = abs(float(factors @ place) - required.value) - required.tolerance
            return off - float(np.abs(factors) @ reach) > EXCESS
        case AxisAlignment() | FramePlacement() | PositionInRegion():
            return _frame_breaks(required, reduced, middle, half)
        case _:
            return False


def _each(
    reduced: ReducedModel, joints: tuple[str, ...], middle: Floats, half: Floats
) -> tuple[Floats, Floats]:
    """Return the middle positions of named joints of the robot, and their largest distance from there."""
    moved = tuple(reduced.model.names[1:])
    place = reduced.all_positions(middle)[reduced.scene.robot.index(joints)]
    carried = np.abs(reduced.mimic_matrix)
    rows = [carried[moved.index(name)] if name in moved else 0.0 * half for name in joints]
    return place, np.array(rows) @ half


def _joints_break(required: JointPositions, reduced: ReducedModel, middle: Floats, half: Floats) -> bool:
    names = tuple(required.positions)
    place, reach = _each(reduced, names, middle, half)
    off = place - np.array(list(required.positions.values()))
    above = np.array([required.above[name] for name in names])
    below = np.array([required.below[name] for name in names])
    return bool((np.maximum(off - above, -off - below) - reach > EXCESS).any())


def _frame_breaks(
    required: AxisAlignment | FramePlacement | PositionInRegion,
    reduced: ReducedModel,
    middle: Floats,
    half: Floats,
) -> bool:
    place = reduced.all_positions(middle)
    frame = reduced.scene.placement_of(required.frame, place)
    base = reduced.scene.placement_of(required.reference, place)
    chain = Chain(reduced)
    carrier, within = reduced.attachment(required.frame)
    reference, _ = reduced.attachment(required.reference)
    turning = float((chain.turns(carrier) + chain.turns(reference)) @ half)
    if isinstance(required, AxisAlignment):
        tilt = between(frame.rotation @ required.axis, base.rotation @ required.direction)
        return tilt - required.tolerance - turning > ACCURACY
    point = base.inverse() * (frame * required.offset)
    # Seen from a reference that moves, a point moves in more ways than are bounded here.
    moving = float(chain.point_levers(carrier, within * required.offset) @ half) if reference == 0 else np.inf
    if isinstance(required, PositionInRegion):
        off = min(distance(shape, where.inverse() * point) for shape, where in required.members)
        return off - moving > ACCURACY
    off = np.abs(point - required.placement.translation) - required.position_tolerance
    if float(off.max()) - moving > ACCURACY:
        return True
    turned = required.placement.rotation.T @ base.rotation.T @ frame.rotation
    angle = float(np.arccos(np.clip((np.trace(turned) - 1.0) / 2.0, -1.0, 1.0)))
    return angle - largest_turn(required) - turning > ACCURACY


def box_overloads(problem: Problem, lower: Floats, upper: Floats) -> bool:
    """Return whether a joint is proven too weak to hold still at every configuration of a box.

    Args:
        problem: The problem; has the load and the limits.
        lower: Shape (n,) [rad | m].
        upper: Shape (n,) [rad | m].
    """
    middle, half = 0.5 * (lower + upper), 0.5 * (upper - lower)
    torque = DynamicsQuery.loaded(problem.reduced).gravity(middle[None]).torque[0]
    excess = np.abs(torque) - problem.limits.effort
    return bool((excess > largest_gravity_slopes(problem.reduced) @ half).any())
