"""Workbench: the state of the live page, independent of it."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from enum import Enum
from math import inf

import numpy as np

from trajopt.optimise.kinematics import inverse_kinematics, validity
from trajopt.optimise.kinematics.validity import Validity
from trajopt.problem.problem import Problem
from trajopt.problem.requirements import FramePlacement, JointPositions, frame_placement, joint_positions
from trajopt.problem.stated import only_group
from trajopt.robot.configuration import ConfigurationLike, initial_positions, stated_configuration
from trajopt.robot.robot import Robot
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.reducing import reduce_model, tool_frame
from trajopt.scene.scene import Scene
from trajopt.values.arrays import Floats, Value, readonly
from trajopt.values.errors import ProblemError, shown
from trajopt.values.placement import Placement
from trajopt.values.printed import in_length
from trajopt.viewer.clearance import ClearanceQuery
from trajopt.viewer.drawing import telling_pairs

THERE = 1e-3
"""A robot this near to its goal in each joint is there [rad | m]."""


class Workbench:
    """The state set by hand.

    Attributes:
        held: The reason why planning is disabled although the goal is valid; empty if enabled.
    """

    def __init__(self, scene: Scene, group: str = "", start: ConfigurationLike | None = None) -> None:
        """Place the robot, its goal is its present posture; for defaults see `live_view`."""
        robot = scene.robot
        self.group = group or chosen_group(robot)
        if not robot.group(self.group).joints:
            raise ProblemError(f"group {shown(self.group)} has no joint to move")
        self._start = (
            initial_positions(robot)
            if start is None
            else stated_configuration(robot, "start", start, group=self.group)
        )
        self.reduced = reduce_model(scene, self.group, self._start)
        self.hand = tool_frame(self.reduced)
        self.held = ""
        self.turned = len(self.reduced.joint_names) >= SPATIAL
        self.goal: Goal = goal_of_joints(self.reduced, self.hand, self.reduced.start_positions)

    @property
    def scene(self) -> Scene:
        return self.reduced.scene

    @property
    def positions(self) -> Floats:
        return self.reduced.start_positions

    @property
    def states(self) -> Mapping[str, Floats]:
        robot, place = self.scene.robot, self.scene.robot.index(self.reduced.joint_names)
        names = (name for owner, name in robot.states if owner == self.group)
        return {name: robot.positions(name, group=self.group)[place] for name in names}

    @property
    def refusal(self) -> str:
        if self.held:
            return self.held
        if self.goal.reachability is not Reachability.REACHABLE:
            return f"the goal is {self.goal.reachability.value}"
        if self.at_goal:
            return "the robot is at its goal: drag the arrows at the hand, or move a joint's slider"
        return ""

    @property
    def at_goal(self) -> bool:
        return bool(np.abs(self.goal.positions - self.positions).max() < THERE)

    @property
    def problem(self) -> Problem:
        return Problem(
            scene=self.scene, group=self.group, start=self._start, goal=self.goal.required, name="by hand"
        )

    def move_hand(self, placement: Placement) -> None:
        self.goal = goal_of_hand(self.reduced, self.hand, placement, self.goal.positions, turned=self.turned)

    def move_joints(self, positions: Floats) -> None:
        self.goal = goal_of_joints(self.reduced, self.hand, positions)

    def move_joint(self, joint: str, position: float) -> None:
        positions = np.array(self.goal.positions)
        positions[self.reduced.joint_names.index(joint)] = position
        self.move_joints(positions)

    def take_posture(self, positions: Floats) -> None:
        self.goal = _judged(self.reduced, self.goal.placement, positions, self.goal.required)

    def count_orientation(self, turned: bool) -> None:
        self.turned = turned
        self.move_hand(self.goal.placement)

    def reset_goal(self) -> None:
        self.move_joints(self.positions)

    def stand(self, positions: Floats) -> None:
        self._start = readonly(self.reduced.all_positions(positions))
        self.change(self.scene)

    def placement_of(self, name: str) -> Placement:
        return self.scene.placement_of(name, self.reduced.all_positions(self.positions))

    def change(self, scene: Scene) -> None:
        self.reduced = reduce_model(scene, self.group, self._start)
        goal = self.goal
        if goal.reachability is Reachability.OUT_OF_REACH or goal.required.frames:
            self.move_hand(goal.placement)
        else:
            self.move_joints(goal.positions)


def chosen_group(robot: Robot) -> str:
    arms = [name for name, group in robot.groups.items() if group.joints and group.tip is not None]
    return arms[0] if arms else only_group(robot)


STARTS = 8
"""Of the search while the goal is dragged, 5 ms for seven joints."""
SPATIAL = 6
"""Number of joints from which a hand can usually take any orientation."""
NAMED = 3
"""Number of reasons named; the others are counted."""
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
    """The goal of the hand or the joints.

    Attributes:
        positions: Of the group's joints, with the hand there or nearest to there, shape (n,) [rad | m].
        reachability: Whether the robot can stand so.
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
        near: Preferred posture of the group, shape (n,) [rad | m].
    """
    required = frame_placement(hand, placement, rotation_tolerance=None if turned else inf)
    found = inverse_kinematics(reduced, required, near=near, starts=STARTS)
    if found.free:
        return _judged(reduced, placement, found.free[0], required)
    if found.colliding:
        return _judged(reduced, placement, found.colliding[0], required)
    everywhere = np.full(len(reduced.joint_names), inf)
    free = replace(reduced, limits=replace(reduced.limits, lower=-everywhere, upper=everywhere))
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
    named = dict(zip(reduced.joint_names, positions.tolist(), strict=True))
    return _judged(reduced, hand_at(reduced, hand, positions), positions, joint_positions(named))


def hand_at(reduced: ReducedModel, hand: str, positions: Floats) -> Placement:
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
    limits, collisions = found.examination.out_of_limits, found.examination.collisions
    if limits:
        return Reachability.BEYOND_LIMITS, f"Beyond limits: {_listed([each.words for each in limits])}."
    if collisions:
        return Reachability.COLLIDING, f"In collision: {_listed([each.words for each in collisions])}."
    nearest = telling_pairs(ClearanceQuery(reduced, UNCHANGING), found.positions, 1)
    if not nearest:
        return Reachability.REACHABLE, "The robot can be there; nothing can touch it."
    near = f"{nearest[0].owners[0]} is {in_length(nearest[0].distance)} from {nearest[0].owners[1]}"
    return Reachability.REACHABLE, f"The robot can be there. Nearest: {near}."


def _listed(reasons: list[str]) -> str:
    more = f"; and {len(reasons) - NAMED} more" if len(reasons) > NAMED else ""
    return "; ".join(reasons[:NAMED]) + more


def _missed(reduced: ReducedModel, hand: str, placement: Placement, positions: Floats) -> str:
    difference = placement.inverse() * hand_at(reduced, hand, positions)
    far = float(np.linalg.norm(difference.translation))
    turned = np.degrees(np.arccos(np.clip((np.trace(difference.rotation) - 1.0) / 2.0, -1.0, 1.0)))
    if far < 1e-3:
        return f"the hand comes there, but turned by {turned:.0f} degrees"
    return f"the hand comes no nearer than {in_length(far)}, as far as was found"
