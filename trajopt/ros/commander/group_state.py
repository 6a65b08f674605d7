"""Structure, state, settings and targets of a group."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import Enum
from itertools import zip_longest
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from trajopt.files import messages as msg
from trajopt.files.messages import Constraints, TrajectoryConstraints, decode, document_of, is_message
from trajopt.files.moveit.constraints import read_constraints
from trajopt.files.moveit.frames import frame_named, pose_of, reading_at
from trajopt.files.moveit.scene_messages import checked_joint_positions, state_message
from trajopt.geometry import angular_jacobian, evaluator, point_jacobian
from trajopt.optimise.kinematics import goal_configurations
from trajopt.planning.result import Result
from trajopt.problem.problem import Problem
from trajopt.problem.requirements import frame_placement
from trajopt.problem.tool_speed import tool_speed
from trajopt.robot.joints import joint_unit
from trajopt.ros.commander.conversions import framed_placement, stamped
from trajopt.ros.commander.robot_states import (
    joint_names,
    random_positions,
    state_positions,
    variable_names,
    within_bounds,
)
from trajopt.ros.commander.world import World, world_or_current
from trajopt.scene.group_tools import end_link
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.reducing import reduce_model
from trajopt.server.move_group.functions import PIPELINE, PLANNERS, Settings, one_or_three, per_axis, scaling
from trajopt.server.move_group.outcome import MoveItCommanderException
from trajopt.tasks.cartesian import Followed
from trajopt.tasks.grasping import PickPlaceResult
from trajopt.values.arrays import Floats, floats, number, sequence
from trajopt.values.documents.document import Node, read_document
from trajopt.values.errors import (
    FrameNotFound,
    JointNotFound,
    NameNotFound,
    ProblemError,
    SolverNotFound,
    StateNotFound,
    shown,
)
from trajopt.values.likely_units import meant_in_joint
from trajopt.values.placement import WORLD, Placement, placement
from trajopt.values.printed import in_joint_position, in_range


class TargetKind(Enum):
    """Constrained part of a pose."""

    POSE = "position and orientation"
    POSITION = "position"
    ORIENTATION = "orientation"


@dataclass(frozen=True)
class PoseTarget:
    """Target pose of a link.

    Attributes:
        frame: The frame; a moving frame is taken at its start placement.
    """

    part: TargetKind
    placement: Placement
    frame: str


@dataclass(frozen=True, eq=False)
class Targets:
    """Targets of a group."""

    joints: Mapping[str, float]
    poses: Mapping[str, tuple[PoseTarget, ...]] = field(default_factory=dict[str, tuple[PoseTarget, ...]])


def goal_constraints(
    targets: Targets, settings: Settings, frame: str, placed: Callable[[PoseTarget], Placement]
) -> list[msg.Constraints]:
    """Return alternative goal constraints for targets.

    If several links have several poses each, the i-th alternative contains the i-th pose of every link.

    Args:
        placed: Returns the placement of a target in the planning frame.
    """
    if not targets.poses:
        return [_joint_goal(targets.joints, settings.joint_tolerance)]
    goals: list[msg.Constraints] = []
    for together in zip_longest(*targets.poses.values()):
        goal = msg.Constraints()
        for link, target in zip(targets.poses, together, strict=True):
            if target is not None:
                _demand(goal, link, target.part, placed(target), settings, frame)
        goals.append(goal)
    return goals


def _joint_goal(joints: Mapping[str, float], tolerance: float) -> msg.Constraints:
    constraints = [
        msg.JointConstraint(name, value, tolerance, tolerance, 1.0) for name, value in joints.items()
    ]
    return msg.Constraints(joint_constraints=constraints)


def _demand(
    goal: msg.Constraints, link: str, part: TargetKind, where: Placement, settings: Settings, frame: str
) -> None:
    pose, header = pose_of(where), msg.Header(frame_id=frame)
    if part is not TargetKind.ORIENTATION and np.isfinite(settings.position_tolerance).any():
        box = msg.SolidPrimitive(
            msg.SolidPrimitive.BOX, [2.0 * tolerance for tolerance in settings.position_tolerance]
        )
        region = msg.BoundingVolume([box], [msg.Pose(pose.position, pose.orientation)])
        goal.position_constraints.append(
            msg.PositionConstraint(header, link, constraint_region=region, weight=1.0)
        )
    if part is not TargetKind.POSITION:
        goal.orientation_constraints.append(
            msg.OrientationConstraint(
                header, pose.orientation, link, *settings.orientation_tolerance, weight=1.0
            )
        )


class GroupBase:
    """A joint group of a world's robot, and its settings."""

    def __init__(
        self,
        name: str,
        robot_description: str = "robot_description",
        ns: str = "",
        wait_for_servers: float = 5.0,
        *,
        world: World | None = None,
    ) -> None:
        """Select a group; the world is by default the one of the enclosing `with` block."""
        self._world = world_or_current(world)
        self._group = self._world.group(name)
        self._tip = end_link(self._world.robot, self._group.name)
        self._reference = self._planning_frame
        self._settings = Settings()
        self._targets = Targets(self._current())
        self._start = msg.RobotState(is_diff=True)
        self._path_constraints: msg.Constraints = msg.Constraints()
        self._trajectory_constraints: msg.TrajectoryConstraints = msg.TrajectoryConstraints()
        self._known_constraints: Mapping[str, msg.Constraints] = {}
        self._remembered: dict[str, list[float]] = {}
        self._result: Result | None = None
        self._followed: Followed | Result | None = None
        self._pick_place: PickPlaceResult | None = None

    @property
    def _planning_frame(self) -> str:
        return self._world.robot.links[0]

    def _current(self) -> dict[str, float]:
        here = self._world.positions[self._world.robot.index(self._group.joints)]
        return dict(zip(self._group.joints, here.tolist(), strict=True))

    @property
    def _names(self) -> list[str]:
        return variable_names(self._world.robot, self._group)

    def _variables(self, planned: Mapping[str, float]) -> list[float]:
        return state_positions(planned, self._world)[self._world.robot.index(self._names)].tolist()

    def _by_place(self, name: str, values: Any) -> dict[str, float]:
        joints, given = self._group.joints, floats(name, values, (None,))
        if len(given) == len(self._names) != len(joints):
            named = dict(zip(self._names, given.tolist(), strict=True))
            return {joint: named[joint] for joint in joints}
        return dict(zip(joints, floats(name, given, (len(joints),)).tolist(), strict=True))

    def _random(self) -> dict[str, float]:
        return random_positions(self._world.robot, self._group.joints, self._world.rng)

    def _link(self, name: str) -> str:
        """Return the named link; the end effector if the name is empty."""
        scene = self._world.scene
        link = name or self._tip
        if not link:
            raise MoveItCommanderException(
                f"group {shown(self._group.name)} is not a chain and has no end effector; "
                "set one by set_end_effector_link"
            )
        known = (*scene.frame_names, *(key for key in scene.objects if scene.holder(key).link != WORLD))
        if link not in known:
            raise FrameNotFound("link", link, known)
        return link

    def _frame(self, name: str) -> str:
        scene = self._world.scene
        frame = frame_named(name, scene.robot)
        scene.holder(frame)
        return frame

    def _placed(self, target: PoseTarget, positions: Floats) -> Placement:
        return self._world.scene.placement_of(self._frame(target.frame), positions) * target.placement


class GroupState(GroupBase):
    """Structure and state of a group: positions in rad or m, angles in rad."""

    def get_name(self) -> str:
        """Return the name of the group."""
        return self._group.name

    def get_active_joints(self) -> list[str]:
        """Return the planned joints."""
        return list(self._group.joints)

    def get_joints(self) -> list[str]:
        """Return all joints, including fixed and mimic joints."""
        return joint_names(self._world.robot, self._group)

    def get_variable_count(self) -> int:
        """Return the number of planned and mimic joints."""
        return len(self._names)

    def has_end_effector_link(self) -> bool:
        """Return whether the group has an end effector."""
        return bool(self._tip)

    def get_end_effector_link(self) -> str:
        """Return the link of pose targets."""
        return self._tip

    def set_end_effector_link(self, link_name: str) -> None:
        """Set the frame of pose targets."""
        self._tip = self._link(link_name)

    def get_interface_description(self) -> msg.PlannerInterfaceDescription:
        """Return the names of the pipeline and its planners."""
        return msg.PlannerInterfaceDescription(PIPELINE, PIPELINE, list(PLANNERS))

    def get_pose_reference_frame(self) -> str:
        """Return the frame of poses not stamped."""
        return self._reference

    def set_pose_reference_frame(self, reference_frame: str) -> None:
        """Set the frame of poses not stamped."""
        self._frame(reference_frame)
        self._reference = reference_frame

    def get_planning_frame(self) -> str:
        """Return the root link."""
        return self._planning_frame

    def get_current_joint_values(self) -> list[float]:
        """Return the current positions of planned and mimic joints [rad | m]."""
        return self._variables(self._current())

    def get_current_pose(self, end_effector_link: str = "") -> msg.PoseStamped:
        """Return the current pose of a link."""
        return self._pose(end_effector_link, self._world.positions)

    def get_current_rpy(self, end_effector_link: str = "") -> list[float]:
        """Return roll, pitch and yaw of a link [rad]."""
        where = self._world.scene.placement_of(self._link(end_effector_link), self._world.positions)
        return list(where.rpy)

    def get_random_joint_values(self) -> list[float]:
        """Return random positions, with a fixed seed [rad | m]."""
        return self._variables(self._random())

    def get_random_pose(self, end_effector_link: str = "") -> msg.PoseStamped:
        """Return the pose of a link at random positions."""
        return self._pose(end_effector_link, state_positions(self._random(), self._world))

    def get_current_state(self) -> msg.RobotState:
        """Return the positions of all joints, and attached objects."""
        return state_message(self._world.scene, self._world.positions)

    def get_current_state_bounded(self) -> msg.RobotState:
        """Return the current state within limits."""
        return self.enforce_bounds(self.get_current_state())

    def enforce_bounds(self, robot_state_msg: Any) -> msg.RobotState:
        """Clip each joint to its limits; wrap continuous joints to [-pi, pi]."""
        return within_bounds(robot_state_msg, self._world.robot)

    def get_jacobian_matrix(
        self, joint_values: Sequence[float], reference_point: Sequence[float] | None = None
    ) -> list[list[float]]:
        """Return the Jacobian of a point of the end effector.

        Args:
            joint_values: Positions as of `get_current_joint_values` [rad | m].
            reference_point: Point in the end effector's frame [m]; its origin when None.

        Returns:
            Six rows, linear velocity [m/s] above angular velocity [rad/s] in world axes, and one column per
            planned joint.
        """
        values = np.array(list(self._by_place("joint_values", joint_values).values()))
        reduced = reduce_model(self._world.scene, self._group.name, self._world.positions)
        point = (0.0, 0.0, 0.0) if reference_point is None else reference_point
        return jacobian(reduced, self._link(""), values, point).tolist()

    def _pose(self, link: str, positions: Floats) -> msg.PoseStamped:
        where = self._world.scene.placement_of(self._link(link), positions)
        return stamped(where, self._planning_frame)


class GroupSettings(GroupBase):
    """Planning settings of a group: tolerances [rad | m], times [s], and scaling factors in (0, 1]."""

    def get_goal_tolerance(self) -> tuple[float, float | list[float], float | list[float]]:
        """Return all tolerances [rad | m]."""
        position, orientation = self.get_goal_position_tolerance(), self.get_goal_orientation_tolerance()
        return self.get_goal_joint_tolerance(), position, orientation

    def get_goal_joint_tolerance(self) -> float:
        """Return the goal tolerance of each joint [rad | m]."""
        return self._settings.joint_tolerance

    def get_goal_position_tolerance(self) -> float | list[float]:
        """Return the tolerance along each axis [m]."""
        return one_or_three(self._settings.position_tolerance)

    def get_goal_orientation_tolerance(self) -> float | list[float]:
        """Return the tolerance about each axis [rad]."""
        return one_or_three(self._settings.orientation_tolerance)

    def set_goal_tolerance(self, value: float) -> None:
        """Set all tolerances [rad | m]."""
        self.set_goal_joint_tolerance(value)
        self.set_goal_position_tolerance(value)
        self.set_goal_orientation_tolerance(value)

    def set_goal_joint_tolerance(self, value: float) -> None:
        """Set the goal tolerance of each joint [rad | m]."""
        tolerance = per_axis("goal joint tolerance", [value] * 3)[0]
        self._settings = replace(self._settings, joint_tolerance=tolerance)

    def set_goal_position_tolerance(self, value: float | Sequence[float]) -> None:
        """Set one tolerance, or one for each axis; inf leaves it free [m]."""
        tolerance = per_axis("goal position tolerance", value)
        self._settings = replace(self._settings, position_tolerance=tolerance)

    def set_goal_orientation_tolerance(self, value: float | Sequence[float]) -> None:
        """Set one tolerance, or one for each axis; pi leaves it free [rad]."""
        tolerance = per_axis("goal orientation tolerance", value)
        self._settings = replace(self._settings, orientation_tolerance=tolerance)

    def allow_looking(self, value: bool) -> None:
        """Accept and ignore: the script defines the scene."""

    def allow_replanning(self, value: bool) -> None:
        """Set whether `go` replans if the scene changed during planning."""
        self._settings = replace(self._settings, replanning=bool(value))

    def set_planning_time(self, seconds: float) -> None:
        """Set the time limit of planning [s]."""
        if not number("planning time", seconds) > 0.0:
            raise MoveItCommanderException(f"planning time must be positive, is {seconds:g} s")
        self._settings = replace(self._settings, planning_time=float(seconds))

    def get_planning_time(self) -> float:
        """Return the time limit of planning [s]."""
        return self._settings.planning_time

    def set_planning_pipeline_id(self, planning_pipeline: str) -> None:
        """Select the pipeline; the only one is "trajopt"."""
        if planning_pipeline not in ("", PIPELINE):
            raise SolverNotFound("planning pipeline", planning_pipeline, (PIPELINE,))

    def get_planning_pipeline_id(self) -> str:
        """Return the name of the pipeline."""
        return PIPELINE

    def set_planner_id(self, planner_id: str) -> None:
        """Select a planner by a name from `get_interface_description`; the default if empty."""
        if planner_id not in ("", *PLANNERS):
            raise SolverNotFound("planner", planner_id, PLANNERS)
        self._settings = replace(self._settings, planner=planner_id or PLANNERS[0])

    def get_planner_id(self) -> str:
        """Return the name of the planner."""
        return self._settings.planner

    def set_num_planning_attempts(self, num_planning_attempts: int) -> None:
        """Set the number of planning attempts; the motion of least duration is kept."""
        if num_planning_attempts < 1:
            raise MoveItCommanderException(f"there must be one attempt at least, not {num_planning_attempts}")
        self._settings = replace(self._settings, attempts=int(num_planning_attempts))

    def set_workspace(self, ws: Sequence[float]) -> None:
        """Set the bounds of a mobile base; arms are not limited, as in MoveIt.

        Args:
            ws: Empty, [min x, min y, max x, max y] or [min x, min y, min z, max x, max y, max z] [m].

        Raises:
            MoveItCommanderException: If its length is not 0, 4 or 6.
        """
        if len(ws) not in (0, 4, 6):
            raise MoveItCommanderException(f"a workspace has 0, 4 or 6 numbers, not {len(ws)}")
        values = floats("workspace", ws, (len(ws),)).tolist() or [0.0] * 6
        if len(values) == 4:
            values = [*values[:2], 0.0, *values[2:], 0.0]
        self._settings = replace(self._settings, workspace=tuple(values))

    def set_max_velocity_scaling_factor(self, value: float) -> None:
        """Set the factor on all velocity limits, in (0, 1]; 0.1 by default."""
        self._settings = replace(self._settings, velocity_scaling=scaling("velocity scaling", value))

    def set_max_acceleration_scaling_factor(self, value: float) -> None:
        """Set the factor on all acceleration limits, in (0, 1]; 0.1 by default."""
        factor = scaling("acceleration scaling", value)
        self._settings = replace(self._settings, acceleration_scaling=factor)

    def limit_max_cartesian_link_speed(self, speed: float, link_name: str = "") -> None:
        """Limit the speed of a link, by default the end effector [m/s]."""
        limited = tool_speed(self._link(link_name), linear=speed)
        self._settings = replace(self._settings, tool_speed=limited)

    def clear_max_cartesian_link_speed(self) -> None:
        """Remove the limit on the speed of a link."""
        self._settings = replace(self._settings, tool_speed=None)

    def set_support_surface_name(self, value: str) -> None:
        """Check that an object exists; all supports may be touched."""
        if value:
            self._world.scene.object(value)


def jacobian(reduced: ReducedModel, link: str, values: Floats, reference_point: ArrayLike) -> Floats:
    """Return the Jacobian of a point of a link, shape (6, n): linear above angular velocity, in world axes.

    Args:
        values: Positions of the group's joints, shape (n,) [rad | m].
        reference_point: The point in the link's frame, shape (3,) [m].
    """
    point = floats("reference_point", reference_point, (3,))
    query, (joint, where) = evaluator(reduced), reduced.attachment(link)
    kinematics = query.kinematics(values[None])
    carrier = kinematics.rotation[:, joint] @ (where * point) + kinematics.translation[:, joint]
    linear = point_jacobian(reduced, kinematics.jacobian, np.array([joint], dtype=np.int64), carrier)
    angular = angular_jacobian(reduced, kinematics.jacobian, joint)
    return np.concatenate((linear[0], angular[0]))


SMALLER = {
    "rad": "degrees meant? Angles are in radians",
    "m": "millimetres meant? Lengths are in metres",
}
"""Likely mistake if a position is far outside a joint's limits, by the joint's unit."""


class GroupTargets(GroupBase):
    """Targets of a group."""

    def get_joint_value_target(self) -> list[float]:
        """Return the last joint-space target [rad | m]."""
        return self._variables(self._targets.joints)

    def set_joint_value_target(self, arg1: Any, arg2: Any = None, arg3: Any = None) -> None:
        """Set a joint-space target.

        Args:
            arg1: Positions in order, joint -> position, a JointState or a RobotState; or the name of a joint;
                or a Pose or PoseStamped, replaced by its nearest collision-free configuration. Positions of
                mimic joints may be omitted, and are ignored [rad | m].
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
        """Set a target orientation [rad]."""
        self._aim(end_effector_link, TargetKind.ORIENTATION, [placement(rpy=rpy)])

    def set_orientation_target(self, q: Sequence[float], end_effector_link: str = "") -> None:
        """Set a target orientation of the end effector, [qx, qy, qz, qw], at any position."""
        self._aim(end_effector_link, TargetKind.ORIENTATION, [placement(quaternion=q)])

    def set_position_target(self, xyz: Sequence[float], end_effector_link: str = "") -> None:
        """Set a target position [m]."""
        self._aim(end_effector_link, TargetKind.POSITION, [placement(xyz)])

    def set_pose_target(self, pose: Any, end_effector_link: str = "") -> None:
        """Set a target pose of the end effector.

        Args:
            pose: A PoseStamped, or in the pose reference frame a Pose, [x, y, z, roll, pitch, yaw] or
                [x, y, z, qx, qy, qz, qw] [m, rad].
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
        """Set a random target within limits."""
        self._set_joints(self._random())

    def get_named_targets(self) -> list[str]:
        """Return described and remembered states."""
        described = [state for owner, state in self._world.robot.states if owner == self._group.name]
        return list(dict.fromkeys((*described, *self._remembered)))

    def set_named_target(self, name: str) -> None:
        """Set a described or remembered state."""
        self._set_joints(self.get_named_target_values(name))

    def get_named_target_values(self, target: str) -> dict[str, float]:
        """Return a state, joint -> position [rad | m]."""
        if target in self._remembered:
            return self._by_place(target, self._remembered[target])
        if target not in self.get_named_targets():
            raise StateNotFound(f"state of group {shown(self._group.name)}", target, self.get_named_targets())
        values = self._world.robot.state(target, group=self._group.name)
        return {joint: value for joint, value in values.items() if joint in self._group.joints}

    def remember_joint_values(self, name: str, values: Sequence[float] | None = None) -> None:
        """Store positions, by default the current ones [rad | m]."""
        stored = self._current() if values is None else self._by_place(name, values)
        self._remembered[name] = self._variables(stored)

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
        given = sequence("poses", poses)
        placed = [framed_placement(pose, frame or self._reference) for pose in given]
        if not placed:
            raise MoveItCommanderException("set_pose_targets: give at least one pose")
        targets = tuple(PoseTarget(part, where, self._named(name)) for where, name in placed)
        # These poses replace an earlier joint target, and are combined with the poses of other links.
        self._targets = replace(self._targets, poses={**self._targets.poses, known: targets})

    def _named(self, frame: str) -> str:
        self._frame(frame)
        return frame

    def _set_joints(self, values: Mapping[str, float]) -> None:
        limits = self._world.robot.limits
        followers = [joint for joint in self._names if joint not in self._group.joints]
        values = {joint: value for joint, value in values.items() if joint not in followers}
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
        """Set waypoints, reached in order."""
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
        """Select the folder of stored `moveit_msgs/Constraints` in YAML, each named by its file."""
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
