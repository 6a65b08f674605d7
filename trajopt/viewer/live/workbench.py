"""Workbench: the state of the live page: robot, objects and goal, as set by hand.

It does not depend on the page that shows it.
"""

from collections.abc import Mapping

import numpy as np

from trajopt.problem.problem import Problem
from trajopt.problem.stated import only_group
from trajopt.robot.configuration import ConfigurationLike, initial_positions, stated_configuration
from trajopt.robot.robot import Robot
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.reducing import reduce_model, tool_frame
from trajopt.scene.scene import Scene
from trajopt.values.arrays import Floats, readonly
from trajopt.values.errors import ProblemError, shown
from trajopt.values.placement import Placement
from trajopt.viewer.live.goal import (
    SPATIAL,
    Goal,
    Reachability,
    goal_of_hand,
    goal_of_joints,
    hand_at,
    in_posture,
)

THERE = 1e-3
"""A robot with each joint so near to its goal is there already [rad | m]."""


class Workbench:
    """The state set by hand.

    Attributes:
        group: The group that moves.
        hand: The frame that goals are set for.
        turned: Whether a goal of the hand includes its orientation.
        goal: The goal.
        held: The reason why planning is disabled although the goal is valid; empty if enabled.
    """

    def __init__(self, scene: Scene, group: str = "", start: ConfigurationLike | None = None) -> None:
        """Place the robot; its goal is its present posture.

        Args:
            scene: The robot and its surroundings.
            group: The group that moves; if empty the only one, or the first with a hand.
            start: Its configuration; by default each group in its first named state.

        Raises:
            GroupNotFound: If there is no such group.
            ProblemError: If the group has no movable joint, or the start has none of the accepted forms.
        """
        robot = scene.robot
        self.group = group or chosen_group(robot)
        if not robot.group(self.group).joints:
            raise ProblemError(f"group {shown(self.group)} has no joint to move")
        self._start = (
            initial_positions(robot)
            if start is None
            else stated_configuration(robot, "start", start, group=self.group)
        )
        self._reduced = reduce_model(scene, self.group, self._start)
        self.hand = tool_frame(self._reduced)
        self.held = ""
        self.turned = len(self._reduced.joint_names) >= SPATIAL
        self.goal: Goal = goal_of_joints(self._reduced, self.hand, self._reduced.start_positions)

    @property
    def scene(self) -> Scene:
        """The robot and its surroundings."""
        return self._reduced.scene

    @property
    def reduced(self) -> ReducedModel:
        """The robot in its present posture, with its group's joints free."""
        return self._reduced

    @property
    def positions(self) -> Floats:
        """Positions of the group's joints, shape (n,) [rad | m]."""
        return self._reduced.start_positions

    @property
    def states(self) -> Mapping[str, Floats]:
        """Named states of the group: positions of its joints, shape (n,) [rad | m]."""
        robot, place = self.scene.robot, self.scene.robot.index(self._reduced.joint_names)
        names = (name for owner, name in robot.states if owner == self.group)
        return {name: robot.positions(name, group=self.group)[place] for name in names}

    @property
    def refusal(self) -> str:
        """Why nothing can be planned now, in words; empty if it can."""
        if self.held:
            return self.held
        if self.goal.reachability is not Reachability.REACHABLE:
            return f"the goal is {self.goal.reachability.value}"
        if self.at_goal:
            return "the robot is at its goal: drag the arrows at the hand, or move a joint's slider"
        return ""

    @property
    def at_goal(self) -> bool:
        """Whether the robot is at its goal."""
        return bool(np.abs(self.goal.positions - self.positions).max() < THERE)

    @property
    def problem(self) -> Problem:
        """The planning problem."""
        return Problem(
            scene=self.scene, group=self.group, start=self._start, goal=self.goal.required, name="by hand"
        )

    def move_hand(self, placement: Placement) -> None:
        """Set the goal of the hand in the world, in the posture nearest to the present goal."""
        self.goal = goal_of_hand(self._reduced, self.hand, placement, self.goal.positions, turned=self.turned)

    def move_joints(self, positions: Floats) -> None:
        """Set the goal of the group's joints, shape (n,) [rad | m]."""
        self.goal = goal_of_joints(self._reduced, self.hand, positions)

    def move_joint(self, joint: str, position: float) -> None:
        """Set the goal of one joint [rad | m]; the others keep theirs."""
        positions = np.array(self.goal.positions)
        positions[self._reduced.joint_names.index(joint)] = position
        self.move_joints(positions)

    def take_posture(self, positions: Floats) -> None:
        """Set the posture of the goal to the end of a motion, shape (n,) [rad | m]."""
        self.goal = in_posture(self._reduced, self.goal, positions)

    def count_orientation(self, turned: bool) -> None:
        """Set whether a goal of the hand includes its orientation."""
        self.turned = turned
        self.move_hand(self.goal.placement)

    def reset_goal(self) -> None:
        """Set the goal to the present posture."""
        self.move_joints(self.positions)

    def stand(self, positions: Floats) -> None:
        """Set the posture of the robot, shape (n,) [rad | m]; the goal stays."""
        self._start = readonly(self._reduced.all_positions(positions))
        self._renew(self.scene)

    def change(self, scene: Scene) -> None:
        """Replace the scene, and check the goal again."""
        self._renew(scene)

    def placement_of(self, name: str) -> Placement:
        """Return the placement of a frame or object in the world."""
        return self.scene.placement_of(name, self._reduced.all_positions(self.positions))

    @property
    def hand_now(self) -> Placement:
        """Placement of the hand in the world."""
        return hand_at(self._reduced, self.hand, self.positions)

    def _renew(self, scene: Scene) -> None:
        self._reduced = reduce_model(scene, self.group, self._start)
        goal = self.goal
        if goal.reachability is Reachability.OUT_OF_REACH or goal.required.frames:
            self.move_hand(goal.placement)
        else:
            self.move_joints(goal.positions)


def chosen_group(robot: Robot) -> str:
    """Return the default group: the only one, or the first with a hand.

    Raises:
        ProblemError: If there are several, and none ends in a hand.
    """
    arms = [name for name, group in robot.groups.items() if group.joints and group.tip is not None]
    return arms[0] if arms else only_group(robot)
