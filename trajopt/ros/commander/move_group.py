"""MoveGroupCommander: plans and executes motions of one group, with MoveIt's API."""

import logging
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import wraps
from typing import Any, TypeVar

from trajopt.files.messages import (
    Constraints,
    MotionPlanRequest,
    MoveItErrorCodes,
    RobotState,
    RobotTrajectory,
    Vector3,
    WorkspaceParameters,
    document_of,
    field_names,
    is_message,
)
from trajopt.files.moveit.constraints import read_constraints
from trajopt.files.moveit.frames import frame_named, read_vector, reading_at
from trajopt.files.moveit.planning_scene import without_collisions
from trajopt.files.moveit.scene_messages import layered_positions
from trajopt.files.moveit.trajectories import trajectory_message, trajectory_of
from trajopt.geometry.geometry import distance_from
from trajopt.optimise.methods.timing import retime_path
from trajopt.planning.result import Result
from trajopt.problem.problem import Problem
from trajopt.problem.requirements import Requirement, joint_positions
from trajopt.ros.commander.conversions import framed_placement
from trajopt.ros.commander.group_state import (
    GroupBase,
    GroupConstraints,
    GroupSettings,
    GroupState,
    GroupTargets,
    PoseTarget,
    TargetKind,
    goal_constraints,
)
from trajopt.ros.commander.robot_states import link_names, problem_of, state_positions
from trajopt.ros.commander.world import World
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.reducing import reduce_model
from trajopt.scene.scene import Scene
from trajopt.server.move_group.functions import (
    PIPELINE,
    followed_through,
    fraction_of,
    picked,
    put_down,
    solved,
)
from trajopt.server.move_group.outcome import (
    Execution,
    ExecutionOutcome,
    MoveItCommanderException,
    code_of,
    speaks_moveit,
)
from trajopt.tasks.cartesian import Followed
from trajopt.tasks.grasping import Grasp, Gripper, PickPlaceResult, Place, Straight, grasps_of, gripper_of
from trajopt.tasks.sequence import PlannedSegment
from trajopt.timing import RetimeFailure
from trajopt.values.arrays import Floats, positive, sequence
from trajopt.values.errors import ObjectNotFound, SolverNotFound, shown
from trajopt.values.placement import WORLD, Placement
from trajopt.values.trajectory import Path, Trajectory

R = TypeVar("R")

THIRD = 3
STOPPED = 1e-5
"""Accuracy of the opening at which an object stops fingers [m]."""
ALGORITHMS = (
    "iterative_time_parameterization",
    "iterative_spline_parameterization",
    "time_optimal_trajectory_generation",
)
PATH_TOLERANCE = 1e-3
"""Largest deviation of the timed motion from the path [m]; MoveIt's default is 0.1 rad in every joint."""


def without_jump_threshold(function: Callable[..., R]) -> Callable[..., R]:
    """Accept calls with or without MoveIt's former `jump_threshold`; paths are continuous in the joints."""

    @wraps(function)
    def call(*args: Any, **kwargs: Any) -> R:
        kwargs.pop("jump_threshold", None)
        number = len(args) > THIRD and isinstance(args[THIRD], int | float)
        if number and not isinstance(args[THIRD], bool):
            args = (*args[:THIRD], *args[THIRD + 1 :])
        return function(*args, **kwargs)

    return call


class GroupMotions(GroupBase):
    """Cartesian paths, picking and placing."""

    @without_jump_threshold
    def compute_cartesian_path(
        self,
        waypoints: Sequence[Any],
        eef_step: float,
        avoid_collisions: Any = True,
        path_constraints: Any = None,
    ) -> tuple[RobotTrajectory, float]:
        """Follow straight lines with the end effector, from its current pose through waypoints.

        Args:
            eef_step: As in MoveIt, > 0 [m]; ignored, because the lines are checked continuously.
            avoid_collisions: Whether to stop before a collision; a preceding `jump_threshold` is ignored.
            path_constraints: Further constraints (Constraints); a violation ends the motion.

        Returns:
            The motion, and the followed fraction of the path: 1.0 and a rest if all waypoints are the current
            pose. `get_last_followed` contains the reason if the path is incomplete.
        """
        if not isinstance(avoid_collisions, bool):
            raise MoveItCommanderException(
                f"compute_cartesian_path: avoid_collisions is True or False, not {shown(avoid_collisions)}"
            )
        positive("eef_step", eef_step)
        start = state_positions(self._start, self._world)
        given = sequence("waypoints", waypoints)
        targets = [framed_placement(each, self._reference) for each in given]
        message = Constraints() if path_constraints is None else path_constraints
        reading = reading_at(self._world.scene, start)
        constraints, scene = read_constraints(
            document_of(message, "path_constraints"), self._world.scene, reading
        )
        followed = self._world.ask(
            followed_through,
            scene if avoid_collisions else without_collisions(scene),
            [self._placed(PoseTarget(TargetKind.POSE, where, frame), start) for where, frame in targets],
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
        return trajectory_message(followed.trajectory, self._planning_frame), fraction_of(followed)

    def get_last_followed(self) -> Followed | Result | None:
        """Return the last Cartesian path; a plan of a rest if all waypoints were the present pose."""
        return self._followed

    def pick(self, object_name: str, grasp: Any = (), plan_only: bool = False) -> int:
        """Grasp an object and lift it; path constraints hold while the object is held.

        Args:
            grasp: A Grasp or several, best first; if empty, grasps are generated from the object's shape.

        Returns:
            MoveIt's error code; `get_last_pick_place` has the details.
        """
        at = self._world.positions
        constraints, scene = self._while_held(self._world.scene)
        gripper = gripper_of(scene.robot, group=self._group.name)
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
        """Put down a held object; path constraints hold until it is released.

        Args:
            location: Target of the object: a Pose, PoseStamped or PlaceLocation, or several, best first.

        Returns:
            MoveIt's error code; `get_last_pick_place` has the details.
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
            opening=_released(places, scene, self._group.name),
            group=self._group.name,
            constraints=constraints,
            settings=self._settings,
        )
        return self._finish(result, plan_only)

    def get_last_pick_place(self) -> PickPlaceResult | None:
        return self._pick_place

    def _finish(self, result: PickPlaceResult, plan_only: bool) -> int:
        self._pick_place = result
        if not result.verified:
            code = MoveItErrorCodes(MoveItErrorCodes.PLANNING_FAILED, str(result.explain()), "grasping")
            self._world.report(ExecutionOutcome(code))
            return code.val
        if plan_only:
            return MoveItErrorCodes.SUCCESS
        if executed(result.require(), self._world, self._tip):
            item = result.final_scene.object(result.name)
            self._world.edit(lambda scene: replace(scene, objects={**scene.objects, item.name: item}))
            return MoveItErrorCodes.SUCCESS
        outcome = self._world.outcome
        assert outcome is not None
        return outcome.error_code.val

    def _while_held(self, scene: Scene) -> tuple[tuple[Requirement, ...], Scene]:
        reading = reading_at(scene, self._world.positions)
        return read_constraints(document_of(self._path_constraints, "path constraints"), scene, reading)


def grasp_of(message: Any, name: str, scene: Scene, gripper: Gripper, *, link: str, at: Floats) -> Grasp:
    """Convert a Grasp message to a grasp.

    Args:
        message: Its pose is of the end effector, its postures are of the fingers.
        at: Current positions of all joints [rad | m].
    """
    where, frame = framed_placement(message.grasp_pose, WORLD)
    placed = scene.placement_of(frame_named(frame, scene.robot), at) * where
    tool = scene.placement_of(link, at).inverse() * scene.placement_of(gripper.tool, at)
    placement = scene.placement_of(name, at).inverse() * placed * tool
    opening = _opening(message.pre_grasp_posture, "pre_grasp_posture", scene, gripper)
    closed = _opening(message.grasp_posture, "grasp_posture", scene, gripper)
    return Grasp(
        placement=placement,
        width=_stopped(name, scene, gripper, placement, opening, closed),
        opening=opening,
        approach=_straight(message.pre_grasp_approach, link),
        lift=_straight(message.post_grasp_retreat, link),
        name=message.id or "grasp",
    )


def place_of(location: Any, scene: Scene, *, link: str, at: Floats) -> Place:
    """Convert a target of an object to a place; `at` are the positions of all joints [rad | m]."""
    whole = is_message(location, "place_pose")
    where, frame = framed_placement(location.place_pose if whole else location, WORLD)
    placed = scene.placement_of(frame_named(frame, scene.robot), at) * where
    if not whole:
        return Place(placement=placed)
    return Place(
        placement=placed,
        lower=_straight(location.pre_place_approach, link),
        retreat=_straight(location.post_place_retreat, link),
        name=location.id or "place",
    )


def _stopped(
    name: str, scene: Scene, gripper: Gripper, placement: Placement, opening: float, closed: float
) -> float:
    """Return the opening at which an object stops closing fingers [m]."""

    def clear(width: float) -> bool:
        at = gripper.opened(scene.robot, scene.robot.positions(), width)
        stands = scene.placement_of(gripper.tool, at) * placement.inverse()
        return distance_from(scene, name, gripper.fingers, at, stands) >= 0.0

    if clear(closed) or not clear(opening):
        return closed
    while opening - closed > STOPPED:
        middle = (opening + closed) / 2.0
        opening, closed = (middle, closed) if clear(middle) else (opening, middle)
    return opening


def executed(segments: Sequence[PlannedSegment], world: World, tip: str) -> bool:
    """Execute planned motions in order; return whether all arrived."""
    executions = (Execution(each.result.problem.reduced, each.trajectory, tip) for each in segments)
    return all(world.execute(each, wait=True).reached for each in executions)


def _released(places: Sequence[Any], scene: Scene, group: str) -> float | None:
    """Return the opening of the first posture stated for the release [m]; None without one."""
    postures = [each.post_place_posture for each in places if is_message(each, "post_place_posture")]
    stated = [posture for posture in postures if posture.points]
    gripper = gripper_of(scene.robot, group=group) if stated else None
    return None if gripper is None else _opening(stated[0], "post_place_posture", scene, gripper)


def _straight(message: Any, link: str) -> Straight:
    direction = read_vector(document_of(message.direction.vector, "direction")) or (0.0, 0.0, 0.0)
    distance = float(message.desired_distance)
    if not any(direction):
        return Straight(distance) if distance > 0.0 else Straight()
    frame = str(message.direction.header.frame_id).removeprefix("/") or link
    return Straight(distance, direction, frame)


def _opening(posture: Any, name: str, scene: Scene, gripper: Gripper) -> float:
    robot, points = scene.robot, posture.points
    if not points or len(points[-1].positions) != len(posture.joint_names):
        raise MoveItCommanderException(
            f"{name}: give a position for each of {', '.join(gripper.joint_names)}"
        )
    named = dict(zip(posture.joint_names, points[-1].positions, strict=True))
    missing = [joint for joint in gripper.joint_names if joint not in named]
    if missing:
        raise MoveItCommanderException(f"{name}: leaves out {', '.join(missing)}")
    return gripper.opening_at(robot, layered_positions(robot, named))


def retimed(
    reduced: ReducedModel, trajectory: Trajectory, *, velocity: float, acceleration: float
) -> Trajectory:
    """Return the fastest motion along the points of a trajectory within all limits.

    Args:
        trajectory: Joints in the group's order; its times are ignored.
        acceleration: Factor in (0, 1] on the acceleration limits.
    """
    last = dict(zip(reduced.joint_names, trajectory.positions[-1].tolist(), strict=True))
    problem = Problem(
        scene=reduced.scene,
        group=reduced.group,
        start=reduced.start,
        goal=joint_positions(last),
        velocity_scaling=velocity,
        acceleration_scaling=acceleration,
    )
    path = Path(reduced.joint_names, trajectory.positions)
    motion = retime_path(problem, path, tolerance=PATH_TOLERANCE)
    if isinstance(motion, RetimeFailure):
        raise MoveItCommanderException(f"retime_trajectory: {motion.reason}")
    return motion.trajectory


_LOG = logging.getLogger("trajopt.ros.commander")


@speaks_moveit
class MoveGroupCommander(GroupTargets, GroupSettings, GroupConstraints, GroupState, GroupMotions):
    """Plans and executes motions of one group; stand-in for MoveIt's class of this name."""

    def set_start_state_to_current_state(self) -> None:
        """Plan from the robot's current state."""
        self._start = RobotState(is_diff=True)

    def set_start_state(self, msg: Any) -> None:
        """Plan from a state.

        Args:
            msg: A RobotState; missing joints keep their current positions, and its attached objects are
                carried from the start.
        """
        state_positions(msg, self._world)
        self._start = msg

    def plan(self, joints: Any = None) -> tuple[bool, RobotTrajectory, float, MoveItErrorCodes]:
        """Plan a motion and verify it.

        Args:
            joints: Target that replaces the stored one: joint values, a pose, or a name.

        Returns:
            Whether a motion was found, the motion, the process time [s], and the reason of a failure.
        """
        self._take(joints)
        result = self._solved(self._world.scene)
        _LOG.info("plan: %s", result.reason)
        message = trajectory_message(result.trajectory if result.verified else None, self._planning_frame)
        return result.verified, message, sum(result.cpu_seconds.values()), code_of(result)

    def go(self, joints: Any = None, wait: bool = True) -> bool:
        """Plan a motion as `plan` does, with path constraints, and execute it; return as `execute` does."""
        if isinstance(joints, bool):
            joints, wait = None, joints
        self._take(joints)
        for _ in range(2 if self._settings.replanning else 1):
            scene = self._world.scene
            result = self._solved(scene)
            if self._world.scene is scene:
                break
        else:
            reason = "the scene was changed while the motion was planned"
            changed = MoveItErrorCodes.MOTION_PLAN_INVALIDATED_BY_ENVIRONMENT_CHANGE
            self._world.report(ExecutionOutcome(MoveItErrorCodes(changed, reason, "planning")))
            return False
        if not result.verified or result.trajectory is None:
            self._world.report(ExecutionOutcome(code_of(result)))
            return False
        return self._executed(result.trajectory, wait)

    def execute(self, trajectory: Any, wait: bool = True) -> bool:
        """Execute a planned motion.

        Args:
            wait: Whether to return after the motion, or after its start.

        Returns:
            Whether the robot arrived (or started); see `get_last_outcome`.
        """
        motion = trajectory_of(trajectory, "execute", self._group, self._world.named_positions)
        if motion is None:
            reason = "the trajectory has no points; the error code of plan() has the reason"
            code = MoveItErrorCodes(MoveItErrorCodes.INVALID_MOTION_PLAN, reason, "execution")
            self._world.report(ExecutionOutcome(code))
            return False
        return self._executed(motion, wait)

    def stop(self) -> None:
        """Stop the robot along the next proven stop; return once it is at rest.

        `get_last_outcome` contains the stopping time.
        """
        self._world.stop()

    def get_last_outcome(self) -> ExecutionOutcome | None:
        """Return the result and final error of the last `go` or `execute`; None before the first."""
        return self._world.outcome

    def get_last_result(self) -> Result | None:
        """Return trajopt's result of the last planning, with its certificate; None before."""
        return self._result

    def construct_motion_plan_request(self) -> MotionPlanRequest:
        """Return the request that `plan` would solve, as a message."""
        settings, frame = self._settings, self._planning_frame
        start = state_positions(self._start, self._world)
        goals = goal_constraints(self._targets, settings, frame, lambda target: self._placed(target, start))
        low, high = settings.workspace[:3], settings.workspace[3:]
        limited = settings.tool_speed
        return MotionPlanRequest(
            workspace_parameters=WorkspaceParameters(min_corner=Vector3(*low), max_corner=Vector3(*high)),
            start_state=self._start,
            goal_constraints=goals,
            path_constraints=self._path_constraints,
            trajectory_constraints=self._trajectory_constraints,
            pipeline_id=PIPELINE,
            planner_id=settings.planner,
            group_name=self._group.name,
            num_planning_attempts=settings.attempts,
            allowed_planning_time=settings.planning_time,
            max_velocity_scaling_factor=settings.velocity_scaling,
            max_acceleration_scaling_factor=settings.acceleration_scaling,
            cartesian_speed_limited_link="" if limited is None else limited.frame,
            max_cartesian_speed=0.0 if limited is None else limited.linear,
        )

    def attach_object(self, object_name: str, link_name: str = "", touch_links: Sequence[str] = ()) -> bool:
        """Attach an object to a link at its current pose.

        Args:
            link_name: The link; if empty, the end effector, or else the group's first link.
        """
        link = link_name or self._tip or link_names(self._world.robot, self._group)[0]
        at = self._world.positions
        self._world.edit(lambda scene: scene.attach(object_name, link, at=at, touch_links=touch_links))
        return True

    def detach_object(self, name: str = "") -> bool:
        """Detach an object and leave it in the world at its current pose.

        Args:
            name: The object, or the link that carries it; if empty, all objects attached to the group's
                links.

        Returns:
            Whether an object was detached.
        """
        at = self._world.positions
        chosen: list[str] = []

        def detached(scene: Scene) -> Scene:
            if name and name not in scene.objects and name not in scene.frame_names:
                known = (*_carried(scene), *scene.frame_names)
                raise ObjectNotFound("attached object or link", name, known)
            links = [name] if name else link_names(self._world.robot, self._group)
            chosen.extend(
                key
                for key, link in _carried(scene).items()
                if key == name or link in links or scene.object(key).frame in links
            )
            for key in chosen:
                scene = scene.detach(key, at=at)
            return scene

        self._world.edit(detached)
        return bool(chosen)

    def retime_trajectory(
        self,
        ref_state_in: Any,
        traj_in: Any,
        velocity_scaling_factor: float = 1.0,
        acceleration_scaling_factor: float = 1.0,
        algorithm: str = "iterative_time_parameterization",
    ) -> RobotTrajectory:
        """Retime the path of a trajectory to the least duration within all limits.

        Args:
            ref_state_in: A RobotState, for the joints outside the group.
            velocity_scaling_factor: Factor in (0, 1] on the velocity limits.
            algorithm: One of MoveIt's names; all select the same algorithm, which also limits jerk and
                torque.
        """
        if algorithm not in ALGORITHMS:
            raise SolverNotFound("time parameterisation", algorithm, ALGORITHMS)
        positions = state_positions(ref_state_in, self._world)
        start = dict(zip(self._world.robot.joint_names, positions.tolist(), strict=True))
        motion = trajectory_of(traj_in, "retime_trajectory", self._group, start)
        if motion is None:
            raise MoveItCommanderException("retime_trajectory: the trajectory has no points")
        reduced = reduce_model(self._world.scene, self._group.name, positions)
        return trajectory_message(
            retimed(
                reduced,
                motion,
                velocity=velocity_scaling_factor,
                acceleration=acceleration_scaling_factor,
            ),
            self._planning_frame,
        )

    def _solved(self, scene: Scene) -> Result:
        request = self.construct_motion_plan_request()
        problem = problem_of(request, scene, self._world.positions)
        self._result = self._world.ask(solved, problem, self._settings)
        return self._result

    def _executed(self, trajectory: Trajectory, wait: bool) -> bool:
        reduced = reduce_model(self._world.scene, self._group.name, self._world.positions)
        execution = Execution(reduced, trajectory, self._tip)
        outcome = self._world.execute(execution, wait=wait)
        return outcome.error_code.val == MoveItErrorCodes.SUCCESS


def _carried(scene: Scene) -> dict[str, str]:
    holders = {name: scene.holder(name).link for name in scene.objects}
    return {name: link for name, link in holders.items() if link in scene.robot.links}
