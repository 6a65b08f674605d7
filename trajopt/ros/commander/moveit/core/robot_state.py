"""Stand-in for `moveit.core.robot_state`: positions of all joints, which a script may change."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from trajopt.files.messages import Pose
from trajopt.files.messages import RobotState as RobotStateMessage
from trajopt.files.moveit.frames import pose_of
from trajopt.files.moveit.planning_scene import without_collisions
from trajopt.files.moveit.scene_messages import state_message
from trajopt.optimise.kinematics import Validity, inverse_kinematics, validity
from trajopt.problem.requirements import Requirement
from trajopt.ros.commander.conversions import placement_of
from trajopt.ros.commander.group_state import jacobian
from trajopt.ros.commander.moveit.core.robot_model import InPart, RobotModel
from trajopt.ros.commander.robot_states import random_positions, variable_names
from trajopt.scene.group_tools import end_link
from trajopt.scene.reducing import reduce_model
from trajopt.scene.scene import Scene
from trajopt.server.move_group.functions import held_pose
from trajopt.server.move_group.outcome import MoveItCommanderException, speaks_moveit
from trajopt.values.arrays import Floats, floats
from trajopt.values.errors import shown

DRAWS = 100
"""Most draws of random positions to find a state without self-collision."""


@speaks_moveit
class RobotState(InPart):
    """Positions of all joints, shape (number of joints,) [rad | m]."""

    def __init__(self, robot_model: RobotModel) -> None:
        """Set each joint to 0, or to the middle of its limits if they exclude 0."""
        self.robot_model = robot_model
        self.set_to_default_values()

    def __copy__(self) -> "RobotState":
        state = RobotState(self.robot_model)
        state.positions = self.positions
        return state

    def __deepcopy__(self, memo: dict[int, Any]) -> "RobotState":
        return self.__copy__()

    @property
    def joint_positions(self) -> dict[str, float]:
        """Positions of all joints by name [rad | m]."""
        return dict(zip(self.robot_model.robot.joint_names, self.positions.tolist(), strict=True))

    @joint_positions.setter
    def joint_positions(self, values: Mapping[str, float]) -> None:
        """Change the positions of the given joints [rad | m]."""
        robot = self.robot_model.robot
        robot.index(values)  # names the joint that does not exist
        stated = {**self.joint_positions, **values}
        self.positions = robot.positions(
            {name: at for name, at in stated.items() if name not in robot.mimics}
        )

    @property
    def dirty(self) -> bool:
        """Whether transforms are out of date: always False."""
        return False

    def update(self, force: bool = False, category: str = "all") -> None:
        """Do nothing; transforms are computed on use."""

    def set_to_default_values(self, joint_model_group: Any = None, name: str = "") -> bool:
        """Set a group to a named state, or all joints to their defaults."""
        robot = self.robot_model.robot
        if not name:
            lower, upper = robot.limits.lower, robot.limits.upper
            outside = (lower > 0.0) | (upper < 0.0)
            middle = np.where(outside, (lower + upper) / 2.0, 0.0)
            self.positions: Floats = robot.followed(middle)
        else:
            group = getattr(joint_model_group, "name", joint_model_group)
            self.joint_positions = dict(
                robot.state(name, group=self.robot_model.get_joint_model_group(group).name)
            )
        return True

    def set_to_random_positions(self, joint_model_group: Any = None) -> None:
        """Draw positions within limits, of a group or of all joints.

        The draw is repeated up to `DRAWS` times while the robot collides with itself.
        """
        robot = self.robot_model.robot
        joints = [name for name in robot.joint_names if name not in robot.mimics]
        if joint_model_group is not None:
            joints = joint_model_group.active_joint_model_names
        groups = self.robot_model.joint_model_group_names
        for _ in range(DRAWS):
            self.joint_positions = random_positions(robot, joints, self.robot_model.rng)
            if not any(
                each.examination.collisions for each in judged(self.robot_model.scene, groups, self.positions)
            ):
                break

    def get_joint_group_positions(self, joint_model_group_name: str) -> Floats:
        """Return positions of a group's planned and mimic joints, shape (n,) [rad | m]."""
        return self.positions[self.robot_model.robot.index(self._variables(joint_model_group_name))].copy()

    def set_joint_group_positions(self, joint_model_group_name: str, position_values: ArrayLike) -> None:
        """Set positions of a group, shape (n,); those of mimic joints are ignored [rad | m]."""
        self._set(self._variables(joint_model_group_name), position_values)

    def set_joint_group_active_positions(self, joint_model_group_name: str, values: ArrayLike) -> None:
        """Set positions of a group's planned joints, shape (n,) [rad | m]."""
        self._set(self._joints(joint_model_group_name), values)

    def get_pose(self, link_name: str) -> Pose:
        """Return the pose of a link in the root link."""
        return pose_of(self.robot_model.scene.placement_of(link_name, self.positions))

    def get_frame_transform(self, frame_id: str) -> Floats:
        """Return the placement of a link or tool frame in the root link, shape (4, 4)."""
        return self.robot_model.scene.placement_of(frame_id, self.positions).homogeneous

    get_global_link_transform = get_frame_transform

    def get_jacobian(
        self,
        joint_model_group_name: str,
        *where: Any,
        reference_point_position: Any = None,
        link_name: str = "",
    ) -> Floats:
        """Return the Jacobian of a point of a link in world axes, shape (6, n).

        Args:
            where: The point, preceded by the link unless it is the group's last link.
            reference_point_position: The point in the link's frame, shape (3,) [m].
        """
        link = next((each for each in where if isinstance(each, str)), link_name)
        points = [each for each in where if not isinstance(each, str | bool)]
        point = points[0] if points else reference_point_position
        group = self.robot_model.get_joint_model_group(joint_model_group_name).name
        reduced = reduce_model(self.robot_model.scene, group, self.positions)
        values = self.get_joint_group_positions(group)
        return jacobian(reduced, link or end_link(self.robot_model.robot, group), values, point)

    def set_from_ik(
        self, joint_model_group_name: str, geometry_pose: Any, tip_name: str, timeout: float = 0.0
    ) -> bool:
        """Move a group to the nearest configuration with a link at a pose, ignoring collisions.

        Args:
            geometry_pose: A Pose, in the root link.
            timeout: As in MoveIt; ignored, the search is finite.

        Returns:
            Whether such a configuration exists; if not, the state is unchanged.
        """
        group = self.robot_model.get_joint_model_group(joint_model_group_name).name
        reduced = reduce_model(without_collisions(self.robot_model.scene), group, self.positions)
        found = inverse_kinematics(reduced, held_pose(tip_name, placement_of(geometry_pose))).free
        if len(found):
            self.positions = reduced.all_positions(found[0])
        return bool(len(found))

    def message(self) -> RobotStateMessage:
        """Return the positions as a message."""
        return state_message(self.robot_model.scene, self.positions)

    def _set(self, joints: Sequence[str], values: ArrayLike) -> None:
        given = floats("position_values", values, (len(joints),))
        self.joint_positions = dict(zip(joints, given.tolist(), strict=True))

    def _variables(self, group: str) -> list[str]:
        robot = self.robot_model.robot
        return variable_names(robot, robot.group(self.robot_model.get_joint_model_group(group).name))

    def _joints(self, group: str) -> list[str]:
        return self.robot_model.get_joint_model_group(group).active_joint_model_names


def robotStateToRobotStateMsg(state: RobotState, copy_attached_bodies: bool = True) -> RobotStateMessage:
    return state.message()


def judged(
    scene: Scene, groups: Sequence[str], positions: Floats, required: Sequence[Requirement] = ()
) -> list[Validity]:
    reduced = (reduce_model(scene, group, positions) for group in groups)
    return [validity(each, each.start_positions, requirements=required) for each in reduced]


def of_robot(state: Any) -> RobotState:
    if not isinstance(state, RobotState):
        raise MoveItCommanderException(
            f"robot_state must be a moveit.core.robot_state.RobotState, is {shown(state)}"
        )
    return state
