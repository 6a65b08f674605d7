"""Goal: the requested pose of the hand, the posture found for it, and whether it is reachable."""

from dataclasses import dataclass, replace
from enum import Enum
from math import inf

import numpy as np

from trajopt.optimise.kinematics import inverse_kinematics, validity
from trajopt.optimise.kinematics.validity import Validity
from trajopt.problem.requirements import FramePlacement, JointPositions, frame_placement, joint_positions
from trajopt.scene.reduced import ReducedModel
from trajopt.values.arrays import Floats, Value, readonly
from trajopt.values.placement import Placement
from trajopt.values.printed import in_length
from trajopt.viewer.clearance import ClearanceQuery
from trajopt.viewer.live.nearest_drawing import telling_pairs

STARTS = 8
"""Of the search while the goal is dragged: a goal in reach is found from a few [5 ms for seven joints]."""
SPATIAL = 6
"""Number of joints from which a hand can usually take any orientation."""
NAMED = 3
"""Number of reasons that are named; the others are counted."""
UNCHANGING = 1.0
"""Duration of the motion that represents a posture in clearance queries [s]."""


class Reachability(Enum):
    """Whether a robot can take a goal posture."""

    REACHABLE = "reachable"
    COLLIDING = "in collision"
    BEYOND_LIMITS = "beyond its joints' limits"
    OUT_OF_REACH = "out of reach"


@dataclass(frozen=True, eq=False, kw_only=True)
class Goal(Value):
    """Where the hand is asked to go.

    Attributes:
        placement: Of the hand, in the world.
        positions: Of the group's joints: that of a posture with the hand there, or, where there is none, of
            that which comes nearest, shape (n,) [rad | m].
        reachability: Whether the robot can stand so.
        words: The same, with the reason, in a sentence or two.
        required: What a motion must hold at its end.
    """

    placement: Placement
    positions: Floats
    reachability: Reachability
    words: str
    required: FramePlacement | JointPositions


def goal_of_hand(
    reduced: ReducedModel, hand: str, placement: Placement, near: Floats, *, turned: bool
) -> Goal:
    """Return the goal of a hand pose, in any posture.

    Args:
        reduced: The robot in its scene.
        hand: The hand's frame.
        placement: Required placement in the world.
        near: Preferred posture of the group, shape (n,) [rad | m].
        turned: Whether the orientation counts; otherwise the position alone.
    """
    required = frame_placement(hand, placement, rotation_tolerance=None if turned else inf)
    found = inverse_kinematics(reduced, required, near=near, starts=STARTS)
    if found.free:
        return _judged(reduced, placement, found.free[0], required)
    if found.colliding:
        return _judged(reduced, placement, found.colliding[0], required)
    free = _without_limits(reduced)
    beyond = inverse_kinematics(free, required, near=near, starts=STARTS)
    held = (*beyond.free, *beyond.colliding)
    if held:
        return _judged(reduced, placement, held[0], required)
    assert found.nearest is not None  # nothing holds the goal: the search says how near it came
    nearest = found.nearest.positions
    words = f"Out of reach: {_missed(reduced, hand, placement, nearest)}."
    return Goal(
        placement=placement,
        positions=readonly(nearest),
        reachability=Reachability.OUT_OF_REACH,
        words=words,
        required=required,
    )


def goal_of_joints(reduced: ReducedModel, hand: str, positions: Floats) -> Goal:
    """Return the goal that the group's joints are somewhere, shape (n,) [rad | m]."""
    named = dict(zip(reduced.joint_names, positions.tolist(), strict=True))
    return _judged(reduced, hand_at(reduced, hand, positions), positions, joint_positions(named))


def in_posture(reduced: ReducedModel, goal: Goal, positions: Floats) -> Goal:
    """Return a goal with another posture in which it is held, shape (n,) [rad | m]."""
    return _judged(reduced, goal.placement, positions, goal.required)


def hand_at(reduced: ReducedModel, hand: str, positions: Floats) -> Placement:
    """Return the hand's placement in the world for the group's positions, shape (n,) [rad | m]."""
    return reduced.scene.placement_of(hand, reduced.all_positions(positions))


def _judged(
    reduced: ReducedModel, placement: Placement, positions: Floats, required: FramePlacement | JointPositions
) -> Goal:
    found = validity(reduced, positions)
    reachability, words = _said(reduced, found)
    return Goal(
        placement=placement,
        positions=readonly(positions),
        reachability=reachability,
        words=words,
        required=required,
    )


def _said(reduced: ReducedModel, found: Validity) -> tuple[Reachability, str]:
    """Return whether the posture is possible, and the obstacle or the nearest pair."""
    limits, collisions = found.examination.out_of_limits, found.examination.collisions
    if limits:
        return Reachability.BEYOND_LIMITS, f"Beyond limits: {_listed([each.words for each in limits])}."
    if collisions:
        return Reachability.COLLIDING, f"In collision: {_listed([each.words for each in collisions])}."
    nearest = telling_pairs(ClearanceQuery(reduced, UNCHANGING), found.positions, 1)
    if not nearest:
        return Reachability.REACHABLE, "The robot can stand there; nothing can touch it."
    near = f"{nearest[0].owners[0]} is {in_length(nearest[0].distance)} from {nearest[0].owners[1]}"
    return Reachability.REACHABLE, f"The robot can stand there. Nearest: {near}."


def _listed(reasons: list[str]) -> str:
    more = f"; and {len(reasons) - NAMED} more" if len(reasons) > NAMED else ""
    return "; ".join(reasons[:NAMED]) + more


def _without_limits(reduced: ReducedModel) -> ReducedModel:
    """Return the robot as if its joints could turn and slide for ever."""
    everywhere = np.full(len(reduced.joint_names), inf)
    return replace(reduced, limits=replace(reduced.limits, lower=-everywhere, upper=everywhere))


def _missed(reduced: ReducedModel, hand: str, placement: Placement, positions: Floats) -> str:
    """Print the error of the hand."""
    difference = placement.inverse() * hand_at(reduced, hand, positions)
    far = float(np.linalg.norm(difference.translation))
    turned = np.degrees(np.arccos(np.clip((np.trace(difference.rotation) - 1.0) / 2.0, -1.0, 1.0)))
    if far < 1e-3:
        return f"the hand comes there, but turned by {turned:.0f} degrees"
    return f"the hand comes no nearer than {in_length(far)}, as far as was found"
