"""MoveGroupCommander: plans and executes motions of one group, with MoveIt's API."""

import logging
from collections.abc import Sequence
from typing import Any

from trajopt.files.messages import (
    MotionPlanRequest,
    MoveItErrorCodes,
    RobotState,
    RobotTrajectory,
    Vector3,
    WorkspaceParameters,
)
from trajopt.files.moveit.trajectories import trajectory_message, trajectory_of
from trajopt.planning.result import Result
from trajopt.ros.commander.group_motions import ALGORITHMS, GroupMotions, retimed
from trajopt.ros.commander.group_state import GroupSettings, GroupState, goal_constraints
from trajopt.ros.commander.group_targets import GroupConstraints, GroupTargets
from trajopt.ros.commander.robot_states import link_names, problem_of, state_positions
from trajopt.scene.reducing import reduce_model
from trajopt.scene.scene import Scene
from trajopt.server.move_group.functions import PIPELINE, solved
from trajopt.server.move_group.outcome import (
    Execution,
    ExecutionOutcome,
    MoveItCommanderException,
    code_of,
    speaks_moveit,
)
from trajopt.values.errors import ObjectNotFound, SolverNotFound
from trajopt.values.trajectory import Trajectory

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

        Raises:
            MoveItCommanderException: If the message is malformed, or contains an unknown joint.
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
        """Plan a motion as `plan` does, with path constraints, and execute it.

        Args:
            joints: Target that replaces the stored one: joint values, a pose, or a name.
            wait: Whether to return after the motion, or after its start.

        Returns:
            Whether the robot arrived (or started); see `get_last_outcome`.
        """
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
            trajectory: A RobotTrajectory or JointTrajectory.
            wait: Whether to return after the motion, or after its start.

        Returns:
            Whether the robot arrived (or started); see `get_last_outcome`.

        Raises:
            MoveItCommanderException: If the trajectory is malformed, or its joints are not the group's.
        """
        motion = trajectory_of(trajectory, "execute", self._group, self._world.named_positions)
        if motion is None:
            reason = "the trajectory has no points; plan() says why in its error code"
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
            touch_links: Further links that may touch the object.
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
            traj_in: The RobotTrajectory.
            velocity_scaling_factor: Factor in (0, 1] on the velocity limits.
            acceleration_scaling_factor: Factor in (0, 1] on the acceleration limits.
            algorithm: One of MoveIt's names; all select the same algorithm, which also limits jerk and
                torque.

        Raises:
            MoveItCommanderException: If no timing satisfies the limits, or the trajectory is malformed.
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
