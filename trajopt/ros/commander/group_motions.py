"""Following lines, picking and placing: motions that are more than one plan."""

import logging
from collections.abc import Callable, Sequence
from functools import wraps
from typing import Any, TypeVar

from trajopt.files.messages import document_of, field_names, is_message
from trajopt.files.moveit.constraints import read_constraints
from trajopt.files.moveit.scene_edits import without_collisions
from trajopt.files.moveit.trajectory_message import trajectory_message
from trajopt.problem.requirements import Requirement
from trajopt.ros.commander.conversions import framed_placement
from trajopt.ros.commander.group_base import GroupBase
from trajopt.ros.commander.moveit_msgs.msg import Constraints, MoveItErrorCodes, RobotTrajectory
from trajopt.ros.commander.pick_place import executed, grasp_of, place_of
from trajopt.ros.commander.planning import reading_in
from trajopt.ros.commander.robot_states import state_positions
from trajopt.ros.commander.targets import Part, PoseTarget
from trajopt.scene.scene import Scene
from trajopt.server.move_group.functions import followed_through, picked, put_down
from trajopt.server.move_group.outcome import MoveItCommanderException, Outcome
from trajopt.tasks.cartesian import Followed
from trajopt.tasks.grasping import PickPlaceResult, grasps_of, gripper_of
from trajopt.values.errors import shown

R = TypeVar("R")
_LOG = logging.getLogger("trajopt.ros.commander")

THIRD = 3
"""Place of the third argument, after `self`."""


def without_jump_threshold(function: Callable[..., R]) -> Callable[..., R]:
    """Return `compute_cartesian_path` called as MoveIt's years ask for: with a `jump_threshold`, or without.

    Until 2023 the third argument was a number, the largest jump of joints, and those after it came one
    later. What is followed here never jumps, so that any threshold is kept.
    """

    @wraps(function)
    def call(*args: Any, **kwargs: Any) -> R:
        kwargs.pop("jump_threshold", None)
        number = len(args) > THIRD and isinstance(args[THIRD], int | float)
        if number and not isinstance(args[THIRD], bool):
            args = (*args[:THIRD], *args[THIRD + 1 :])
        return function(*args, **kwargs)

    return call


class GroupMotions(GroupBase):
    """Following lines, picking and placing."""

    @without_jump_threshold
    def compute_cartesian_path(
        self,
        waypoints: Sequence[Any],
        eef_step: float,
        avoid_collisions: Any = True,
        path_constraints: Any = None,
    ) -> tuple[RobotTrajectory, float]:
        """Follow straight lines with the end effector, from where it is through poses.

        Args:
            waypoints: Poses, in the pose reference frame or stamped.
            eef_step: As in MoveIt, > 0 [m]; the lines are followed and judged at all places, not at steps.
            avoid_collisions: Whether to stop where something comes too near. A number before it, the
                `jump_threshold` that scripts of before 2023 have, is accepted: nothing jumps.
            path_constraints: What else must hold (Constraints): where it holds no longer the motion ends.

        Returns:
            The motion, and the part of the way that it follows; `get_last_followed` says why not more.

        Raises:
            MoveItCommanderException: If a pose is none.
            FileFormatError: If the constraints cannot be read.
        """
        if not isinstance(avoid_collisions, bool):
            raise MoveItCommanderException(
                f"compute_cartesian_path: avoid_collisions is True or False, not {shown(avoid_collisions)}"
            )
        if not eef_step > 0.0:
            raise MoveItCommanderException(f"eef_step must be positive, is {eef_step}")
        start = state_positions(self._start, self._world)
        targets = [framed_placement(each, self._reference) for each in waypoints]
        message = Constraints() if path_constraints is None else path_constraints
        reading = reading_in(self._world.scene, start)
        constraints, scene = read_constraints(
            document_of(message, "path_constraints"), self._world.scene, reading
        )
        followed = self._world.ask(
            followed_through,
            scene if avoid_collisions else without_collisions(scene),
            [self._placed(PoseTarget(Part.POSE, where, frame), start) for where, frame in targets],
            link=self._link(""),
            group=self._group.name,
            start=start,
            settings=self._settings,
            constraints=constraints,
        )
        self._followed = followed
        _LOG.info("compute_cartesian_path: %s", followed.reason)
        if not followed.verified:
            return RobotTrajectory(), 0.0
        return trajectory_message(followed.trajectory, self._planning_frame), followed.fraction

    def get_last_followed(self) -> Followed | None:
        """Return trajopt's own result of the last Cartesian path, with why it ended; None before."""
        return self._followed

    def pick(self, object_name: str, grasp: Any = (), plan_only: bool = False) -> int:
        """Take an object and lift it; path constraints hold while it is in the hand.

        Args:
            object_name: The object.
            grasp: A Grasp or several, the best first; grasps are made from its shape where there are none.
            plan_only: Whether to plan without moving.

        Returns:
            MoveIt's number of how it ended; `get_last_pick_place` says more.
        """
        at = self._world.positions
        constraints, scene = self._while_held(self._world.scene)
        gripper = gripper_of(scene.robot)
        given = [grasp] if is_message(grasp, "grasp_pose") else list(grasp)
        made = [
            grasp_of(each, object_name, scene, gripper, link=self._link(""), at=at) for each in given
        ] or grasps_of(scene, object_name, gripper)
        result = self._world.ask(
            picked,
            scene,
            object_name,
            start=at,
            grasps=made,
            group=self._group.name,
            gripper=gripper,
            constraints=constraints,
            settings=self._settings,
        )
        return self._finish(result, plan_only)

    def place(self, object_name: str, location: Any = None, plan_only: bool = False) -> int:
        """Put down an object that is in the hand; path constraints hold until it stands.

        Args:
            object_name: The object.
            location: Where it will be: a Pose, PoseStamped or PlaceLocation, or several, the best first.
            plan_only: Whether to plan without moving.

        Returns:
            MoveIt's number of how it ended; `get_last_pick_place` says more.

        Raises:
            MoveItCommanderException: If no location is given.
        """
        at = self._world.positions
        constraints, scene = self._while_held(self._world.scene)
        places: list[Any] = [location] if field_names(location) else list(location or ())
        if not places:
            raise MoveItCommanderException(f"place: say where {shown(object_name)} is put: a pose or several")
        result = self._world.ask(
            put_down,
            scene,
            object_name,
            start=at,
            places=[place_of(each, scene, link=self._link(""), at=at) for each in places],
            group=self._group.name,
            constraints=constraints,
            settings=self._settings,
        )
        return self._finish(result, plan_only)

    def get_last_pick_place(self) -> PickPlaceResult | None:
        """Return trajopt's own result of the last picking or placing; None before."""
        return self._pick_place

    def _finish(self, result: PickPlaceResult, plan_only: bool) -> int:
        self._pick_place = result
        if not result.verified:
            code = MoveItErrorCodes(MoveItErrorCodes.PLANNING_FAILED, str(result.explain()), "grasping")
            self._world.report(Outcome(code))
            return code.val
        if plan_only or executed(result, self._world, self._tip):
            return MoveItErrorCodes.SUCCESS
        outcome = self._world.outcome
        assert outcome is not None
        return outcome.error_code.val

    def _while_held(self, scene: Scene) -> tuple[tuple[Requirement, ...], Scene]:
        """Return what the path constraints require, and the scene with the frames that they need."""
        reading = reading_in(scene, self._world.positions)
        return read_constraints(document_of(self._path_constraints, "path constraints"), scene, reading)
