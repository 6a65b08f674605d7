"""Targets of a group: joint values, poses, and named or remembered states."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from trajopt.files.messages import Constraints, TrajectoryConstraints, decode, document_of, is_message
from trajopt.files.moveit.constraints import read_constraints
from trajopt.files.moveit.frames import reading_at
from trajopt.files.moveit.robot_state import checked_joint_positions
from trajopt.optimise.kinematics import goal_configurations
from trajopt.problem.problem import Problem
from trajopt.problem.requirements import frame_placement
from trajopt.robot.joints import joint_unit
from trajopt.robot.loading.mimics import followed_limits
from trajopt.ros.commander.conversions import framed_placement
from trajopt.ros.commander.group_state import GroupBase, PoseTarget, TargetKind
from trajopt.server.move_group.outcome import MoveItCommanderException
from trajopt.values.arrays import floats
from trajopt.values.documents.document import Node, read_document
from trajopt.values.errors import JointNotFound, NameNotFound, ProblemError, StateNotFound, shown
from trajopt.values.likely_units import meant_in_joint
from trajopt.values.placement import placement
from trajopt.values.printed import in_joint_position, in_range

SMALLER = {
    "rad": "degrees meant? Angles are in radians",
    "m": "millimetres meant? Lengths are in metres",
}
"""Likely mistake if a position is far outside a joint's limits, by the joint's unit."""


class GroupTargets(GroupBase):
    """Targets of a group."""

    def get_joint_value_target(self) -> list[float]:
        """Return the last joint-space target [rad | m]."""
        return list(self._targets.joints.values())

    def set_joint_value_target(self, arg1: Any, arg2: Any = None, arg3: Any = None) -> None:
        """Set a joint-space target.

        Args:
            arg1: Positions of all joints in order, joint -> position, a JointState or a RobotState; or the
                name of a joint; or a Pose or PoseStamped, replaced by its nearest collision-free
                configuration [rad | m].
            arg2: For a joint: its position. For a pose: the link, the end effector if None.
            arg3: For a pose: the link, as `arg2`.

        Raises:
            MoveItCommanderException: If a joint is unknown or outside its limits, or no configuration reaches
                the pose.
        """
        if isinstance(arg1, str):
            self._set_joints({arg1: float(floats(f"position of {arg1}", arg2, ()))})
        elif is_message(arg1, "header", "pose") or is_message(arg1, "position", "orientation"):
            self._set_joints(self._reaching(arg1, arg2, arg3))
        elif arg2 is not None or arg3 is not None:
            raise MoveItCommanderException("set_joint_value_target: values for a joint's name or a pose only")
        elif isinstance(arg1, Mapping):
            self._set_joints({str(joint): float(value) for joint, value in arg1.items()})  # pyright: ignore[reportUnknownVariableType, reportUnknownArgumentType]
        elif is_message(arg1, "joint_state"):
            self._set_joints(self._of_group(arg1))
        elif is_message(arg1, "name", "position"):
            self._set_joints(self._of_group({"joint_state": arg1}))
        else:
            self._set_joints(self._by_place("joint values", arg1))

    def set_rpy_target(self, rpy: Sequence[float], end_effector_link: str = "") -> None:
        """Set a target orientation of the end effector, [roll, pitch, yaw] [rad], at any position."""
        self._aim(end_effector_link, TargetKind.ORIENTATION, [placement(rpy=rpy)])

    def set_orientation_target(self, q: Sequence[float], end_effector_link: str = "") -> None:
        """Set a target orientation of the end effector, [qx, qy, qz, qw], at any position."""
        self._aim(end_effector_link, TargetKind.ORIENTATION, [placement(quaternion=q)])

    def set_position_target(self, xyz: Sequence[float], end_effector_link: str = "") -> None:
        """Set a target position of the end effector [m], at any orientation."""
        self._aim(end_effector_link, TargetKind.POSITION, [placement(xyz)])

    def set_pose_target(self, pose: Any, end_effector_link: str = "") -> None:
        """Set a target pose of the end effector.

        Args:
            pose: A PoseStamped, or in the pose reference frame a Pose, [x, y, z, roll, pitch, yaw] or
                [x, y, z, qx, qy, qz, qw] [m, rad].
            end_effector_link: Link to use instead of the end effector.
        """
        self.set_pose_targets([pose], end_effector_link)

    def set_pose_targets(self, poses: Sequence[Any], end_effector_link: str = "") -> None:
        """Set alternative poses of the end effector; the planner reaches any one of them."""
        self._aim(end_effector_link, TargetKind.POSE, poses)

    def shift_pose_target(self, axis: int, value: float, end_effector_link: str = "") -> None:
        """Set a target by moving the end effector along or about one axis of the planning frame.

        Args:
            axis: 0 to 5: x, y, z [m], roll, pitch, yaw [rad].
            value: Displacement from the current pose.
            end_effector_link: Link to use instead of the end effector.

        Raises:
            MoveItCommanderException: If the axis is not 0 to 5.
        """
        if axis not in range(6):
            raise MoveItCommanderException(f"axis must be 0 to 5 (x, y, z, roll, pitch, yaw), is {axis}")
        here = self._world.scene.placement_of(self._link(end_effector_link), self._world.positions)
        shifted = [*here.translation.tolist(), *here.rpy]
        shifted[axis] += value
        turned = placement(rpy=shifted[3:]) if axis > 2 else here
        where = placement(shifted[:3], rotation=turned.rotation)
        self._aim(end_effector_link, TargetKind.POSE, [where], self._planning_frame)

    def clear_pose_target(self, end_effector_link: str) -> None:
        """Clear the pose targets of a link."""
        link = self._link(end_effector_link)
        poses = {key: value for key, value in self._targets.poses.items() if key != link}
        self._targets = replace(self._targets, poses=poses)

    def clear_pose_targets(self) -> None:
        """Clear all pose targets; the joint target applies again."""
        self._targets = replace(self._targets, poses={})

    def set_random_target(self) -> None:
        """Set random joint values within the limits as the target."""
        limits = followed_limits(self._world.robot.limits, self._group.joints, self._world.robot.mimics)
        lower, upper = np.maximum(limits.lower, -np.pi), np.minimum(limits.upper, np.pi)
        self._set_joints(self._by_place("random values", self._world.rng.uniform(lower, upper).tolist()))

    def get_named_targets(self) -> list[str]:
        """Return the names of the described and the remembered states."""
        described = [state for owner, state in self._world.robot.states if owner == self._group.name]
        return list(dict.fromkeys((*described, *self._remembered)))

    def set_named_target(self, name: str) -> None:
        """Set a remembered or described state as the target."""
        self._set_joints(self.get_named_target_values(name))

    def get_named_target_values(self, target: str) -> dict[str, float]:
        """Return the joint values of a named state, joint -> position [rad | m]."""
        if target in self._remembered:
            return self._by_place(target, self._remembered[target])
        if target not in self.get_named_targets():
            raise StateNotFound(f"state of group {shown(self._group.name)}", target, self.get_named_targets())
        values = self._world.robot.state(target, group=self._group.name)
        return {joint: value for joint, value in values.items() if joint in self._group.joints}

    def remember_joint_values(self, name: str, values: Sequence[float] | None = None) -> None:
        """Store joint values under a name; by default the current ones [rad | m]."""
        here = list(self._current().values())
        self._remembered[name] = here if values is None else list(self._by_place(name, values).values())

    def get_remembered_joint_values(self) -> dict[str, list[float]]:
        """Return the remembered joint values, by name [rad | m]."""
        return {name: list(values) for name, values in self._remembered.items()}

    def forget_joint_values(self, name: str) -> None:
        """Forget remembered joint values."""
        if name not in self._remembered:
            raise StateNotFound("remembered state", name, self._remembered)
        del self._remembered[name]

    def _take(self, goal: Any) -> None:
        if isinstance(goal, str):
            self.set_named_target(goal)
        elif is_message(goal, "header", "pose") or is_message(goal, "position", "orientation"):
            self.set_pose_target(goal)
        elif goal is not None:
            self.set_joint_value_target(goal)

    def _aim(self, link: str, part: TargetKind, poses: Sequence[Any], frame: str = "") -> None:
        known = self._link(link)
        placed = [framed_placement(pose, frame or self._reference) for pose in poses]
        if not placed:
            raise MoveItCommanderException("set_pose_targets: give at least one pose")
        targets = tuple(PoseTarget(part, where, self._named(name)) for where, name in placed)
        # These poses replace an earlier joint target, and are combined with the poses of other links.
        self._targets = replace(self._targets, poses={**self._targets.poses, known: targets})

    def _named(self, frame: str) -> str:
        self._frame(frame)
        return frame

    def _set_joints(self, values: Mapping[str, float]) -> None:
        """Change joint values of the target.

        Raises:
            JointNotFound: If a joint is not in the group.
            MoveItCommanderException: If a position is outside its limits.
        """
        limits = self._world.robot.limits
        for joint, value in values.items():
            if joint not in self._group.joints:
                raise JointNotFound(f"joint of group {shown(self._group.name)}", joint, self._group.joints)
            place = int(self._world.robot.index([joint])[0])
            lower, upper = float(limits.lower[place]), float(limits.upper[place])
            if not lower <= float(floats(f"position of {joint}", value, ())) <= upper:
                unit = joint_unit(self._world.robot.model, joint)
                where, span = in_joint_position(float(value), unit), in_range(lower, upper, unit)
                meant = meant_in_joint(joint, float(value), lower, upper, unit)
                hint = f"; were {SMALLER[unit]}" if meant else ""
                raise MoveItCommanderException(
                    f"joint {shown(joint)} cannot go to {where}: its limits are {span}{hint}"
                )
        self._targets = replace(self._targets, joints={**self._targets.joints, **values}, poses={})

    def _by_place(self, name: str, values: Any) -> dict[str, float]:
        checked = floats(name, values, (len(self._group.joints),))
        return dict(zip(self._group.joints, checked.tolist(), strict=True))

    def _of_group(self, state: Any) -> dict[str, float]:
        named = checked_joint_positions(document_of(state, "joint state"), self._world.robot)
        return {joint: value for joint, value in named.items() if joint in self._group.joints}

    def _reaching(self, pose: Any, *more: Any) -> dict[str, float]:
        if True in more:
            raise MoveItCommanderException("there are no approximate solutions; widen the goal tolerances")
        link = self._link(next((each for each in more if isinstance(each, str)), ""))
        where, frame = framed_placement(pose, self._reference)
        settings, positions = self._settings, self._world.positions
        target = PoseTarget(TargetKind.POSE, where, self._named(frame))
        problem = Problem(
            scene=self._world.scene,
            group=self._group.name,
            start=positions,
            goal=frame_placement(
                link,
                self._placed(target, positions),
                position_tolerance=settings.position_tolerance,
                rotation_tolerance=settings.orientation_tolerance,
            ),
        )
        found = goal_configurations(problem)
        if not found:
            raise MoveItCommanderException(
                f"no configuration free of collisions brings {shown(link)} to {where}"
            )
        return self._by_place("joint values", found[0])


class GroupConstraints(GroupBase):
    """Path and trajectory constraints of a group."""

    def get_known_constraints(self) -> list[str]:
        """Return the names of the stored constraints."""
        return sorted(self._known_constraints)

    def get_path_constraints(self) -> Constraints:
        """Return the path constraints."""
        return self._path_constraints

    def set_path_constraints(self, value: Any) -> None:
        """Set the path constraints, which hold along every motion of `plan` and `go`.

        Args:
            value: A Constraints message with joint, position, orientation and visibility constraints, the
                name of stored constraints, or None to clear them.

        Raises:
            MoveItCommanderException: If the constraints are malformed, or contain an unknown name.
        """
        if value is None:
            return self.clear_path_constraints()
        if isinstance(value, str):
            if value not in self._known_constraints:
                raise NameNotFound("stored constraints", value, self._known_constraints)
            value = self._known_constraints[value]
        self._check("set_path_constraints", value)
        self._path_constraints = value
        return None

    def clear_path_constraints(self) -> None:
        """Clear the path constraints."""
        self._path_constraints = Constraints()

    def get_trajectory_constraints(self) -> TrajectoryConstraints:
        """Return the trajectory constraints."""
        return self._trajectory_constraints

    def set_trajectory_constraints(self, value: Any) -> None:
        """Set the trajectory constraints: waypoints, reached in order.

        Args:
            value: A TrajectoryConstraints message, or None to clear them.

        Raises:
            MoveItCommanderException: If the constraints are malformed, or contain an unknown name.
        """
        if value is None:
            return self.clear_trajectory_constraints()
        for each in value.constraints:
            self._check("set_trajectory_constraints", each)
        self._trajectory_constraints = value
        return None

    def clear_trajectory_constraints(self) -> None:
        """Pass no waypoints."""
        self._trajectory_constraints = TrajectoryConstraints()

    def set_constraints_database(self, host: str, port: int) -> None:
        """Select the folder of stored constraints.

        Args:
            host: A folder of `moveit_msgs/Constraints` in YAML, each named by its file.
            port: As in MoveIt; ignored.

        Raises:
            MoveItCommanderException: If the folder does not exist, or a file in it is malformed.
        """
        if not Path(host).is_dir():
            raise ProblemError(f"set_constraints_database: {shown(host)} is not a folder")
        stored: dict[str, Constraints] = {}
        for path in sorted(Path(host).glob("*.yaml")):
            document = read_document(path)
            self._read(document)
            stored[path.stem] = decode(Constraints, document)
        self._known_constraints = stored

    def _check(self, name: str, message: object) -> None:
        self._read(document_of(message, name))

    def _read(self, document: Node) -> None:
        scene = self._world.scene
        read_constraints(document, scene, reading_at(scene, self._world.positions))
