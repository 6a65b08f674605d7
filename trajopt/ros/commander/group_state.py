"""What a group is and where it is: names, joints, links, poses, Jacobian."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from trajopt.files.moveit.state_message import state_message
from trajopt.geometry import Query
from trajopt.robot.loading.mimics import followed_limits
from trajopt.ros.commander.conversions import stamped
from trajopt.ros.commander.geometry_msgs.msg import PoseStamped
from trajopt.ros.commander.group_base import GroupBase
from trajopt.ros.commander.moveit_msgs.msg import PlannerInterfaceDescription, RobotState
from trajopt.ros.commander.robot_states import joint_names, state_positions, within_bounds
from trajopt.scene.reduced import ReducedModel, reduce_model
from trajopt.server.move_group.settings import PIPELINE, PLANNERS
from trajopt.values.arrays import Floats, floats


class GroupState(GroupBase):
    """What a group is and where it is."""

    def get_name(self) -> str:
        """Return the name of the group."""
        return self._group.name

    def get_active_joints(self) -> list[str]:
        """Return the names of the joints that are planned for."""
        return list(self._group.joints)

    def get_joints(self) -> list[str]:
        """Return the names of all joints of the group, fixed and mimicking ones included."""
        return joint_names(self._world.robot, self._group)

    def get_variable_count(self) -> int:
        """Return the number of joints that are planned for."""
        return len(self._group.joints)

    def has_end_effector_link(self) -> bool:
        """Say whether the group has an end effector."""
        return bool(self._tip)

    def get_end_effector_link(self) -> str:
        """Return the link that poses are about; empty for none."""
        return self._tip

    def set_end_effector_link(self, link_name: str) -> None:
        """Choose the link, tool frame or attached object that poses are about."""
        self._tip = self._link(link_name)

    def get_interface_description(self) -> PlannerInterfaceDescription:
        """Return the names of the pipeline and its planners."""
        return PlannerInterfaceDescription(PIPELINE, PIPELINE, list(PLANNERS))

    def get_pose_reference_frame(self) -> str:
        """Return the frame that poses without one of their own are in."""
        return self._reference

    def set_pose_reference_frame(self, reference_frame: str) -> None:
        """Choose the frame that poses without one of their own are in: a link, tool frame or object."""
        self._frame(reference_frame)
        self._reference = reference_frame

    def get_planning_frame(self) -> str:
        """Return the frame that planning is done in: the root link, which is where the world is."""
        return self._planning_frame

    def get_current_joint_values(self) -> list[float]:
        """Return where the joints that are planned for are now [rad | m]."""
        return list(self._current().values())

    def get_current_pose(self, end_effector_link: str = "") -> PoseStamped:
        """Return where the end effector, or another link, is now, in the planning frame."""
        return self._pose(end_effector_link, self._world.positions)

    def get_current_rpy(self, end_effector_link: str = "") -> list[float]:
        """Return roll, pitch and yaw of the end effector, or of another link [rad]."""
        where = self._world.scene.placement_of(self._link(end_effector_link), self._world.positions)
        return list(where.rpy)

    def get_random_joint_values(self) -> list[float]:
        """Return random positions within the limits; the same ones every time a script is run [rad | m]."""
        limits = followed_limits(self._world.robot.limits, self._group.joints, self._world.robot.mimics)
        lower = np.where(np.isfinite(limits.lower), limits.lower, -np.pi)
        upper = np.where(np.isfinite(limits.upper), limits.upper, np.pi)
        return self._world.rng.uniform(lower, upper).tolist()

    def get_random_pose(self, end_effector_link: str = "") -> PoseStamped:
        """Return where the end effector, or another link, is at random joint values."""
        values = dict(zip(self._group.joints, self.get_random_joint_values(), strict=True))
        return self._pose(end_effector_link, state_positions(values, self._world))

    def get_current_state(self) -> RobotState:
        """Return where all joints of the robot are now, and what it carries."""
        return state_message(self._world.scene, self._world.positions)

    def get_current_state_bounded(self) -> RobotState:
        """Return the same with every joint moved inside its limits."""
        return self.enforce_bounds(self.get_current_state())

    def enforce_bounds(self, robot_state_msg: Any) -> RobotState:
        """Return a state with every joint moved inside its limits, continuous ones between -pi and pi."""
        return within_bounds(robot_state_msg, self._world.robot)

    def get_jacobian_matrix(
        self, joint_values: Sequence[float], reference_point: Sequence[float] | None = None
    ) -> list[list[float]]:
        """Return the Jacobian of a point of the end effector.

        Args:
            joint_values: Of the joints that are planned for, in their order [rad | m].
            reference_point: In the end effector's frame [m]; its origin when None.

        Returns:
            Six rows, three of the linear velocity [m/s] and three of the angular one [rad/s] along the
            axes of the world, with a column a joint.
        """
        values = floats("joint_values", joint_values, (len(self._group.joints),))
        reduced = reduce_model(self._world.scene, self._group.name, self._world.positions)
        point = (0.0, 0.0, 0.0) if reference_point is None else reference_point
        return jacobian(reduced, self._link(""), values, point).tolist()

    def _pose(self, link: str, positions: Floats) -> PoseStamped:
        where = self._world.scene.placement_of(self._link(link), positions)
        return stamped(where, self._planning_frame)


def jacobian(reduced: ReducedModel, link: str, values: Floats, reference_point: ArrayLike) -> Floats:
    """Return the Jacobian of a point of a link, shape (6, n).

    Args:
        reduced: The robot in its scene, the group's joints free.
        link: The link.
        values: Positions of the group's joints, shape (n,) [rad | m].
        reference_point: The point in the link's frame, shape (3,) [m].

    Returns:
        Three rows of the linear and three of the angular velocity, in the axes of the world.
    """
    point = floats("reference_point", reference_point, (3,))
    query, (joint, where) = Query(reduced), reduced.attachment(link)
    kinematics = query.kinematics(values[None])
    carrier = kinematics.rotation[:, joint] @ (where * point) + kinematics.translation[:, joint]
    linear = query.point_jacobian(kinematics.jacobian, np.array([joint], dtype=np.int64), carrier)
    angular = query.angular_jacobian(kinematics.jacobian, joint)
    return np.concatenate((linear[0], angular[0]))
