"""Execution: `/execute_trajectory` and `/joint_trajectory_action`, by the session's simulated robot."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from trajopt.driving import SimulatedExecutor
from trajopt.files import messages as msg
from trajopt.files.messages import encode
from trajopt.files.moveit.trajectories import trajectory_of
from trajopt.robot.bases import PLANAR
from trajopt.robot.loading.groups import Group
from trajopt.robot.robot import Robot
from trajopt.ros.rosbridge.answers.service_call import code_of_error, failed, read_call
from trajopt.scene.reducing import reduce_model
from trajopt.server.move_group.driving import MotionDriver
from trajopt.server.move_group.outcome import Execution
from trajopt.server.operation import Answer, SessionState, Watch
from trajopt.server.operations.driving import drive_along
from trajopt.values.arrays import Floats
from trajopt.values.documents.document import Node
from trajopt.values.errors import JointNotFound, ProblemError, TrajoptError
from trajopt.values.trajectory import Trajectory

STATES = ("MONITOR", "IDLE")


def check_tolerances(goal: msg.FollowJointTrajectoryGoal) -> None:
    if goal.component_path_tolerance or goal.component_goal_tolerance:
        raise ProblemError("tolerances of joints of several degrees of freedom are not supported")
    for each in (*goal.path_tolerance, *goal.goal_tolerance):
        if each.name not in goal.trajectory.joint_names:
            raise JointNotFound("joint", each.name, goal.trajectory.joint_names)
        if each.acceleration > 0.0:
            raise ProblemError(f"{each.name}: the acceleration is not measured, so has no tolerance")


def out_of_tolerance(
    stated: Sequence[msg.JointTolerance],
    joints: Sequence[str],
    desired: msg.JointTrajectoryPoint,
    actual: msg.JointTrajectoryPoint,
) -> str:
    """Describe the first joint out of tolerance, empty if none; 0 (the default) and -1 mean no bound."""
    for each in stated:
        place = joints.index(each.name)
        for what, most, wanted, found in (
            ("position", each.position, desired.positions, actual.positions),
            ("velocity", each.velocity, desired.velocities, actual.velocities),
        ):
            off = abs(wanted[place] - found[place]) if wanted else 0.0
            if 0.0 < most < off:
                return f"{each.name}: its {what} is off by {off:.3g}, more than {most:.3g}"
    return ""


@dataclass(frozen=True)
class ExecutionReading:
    """State of a robot during an execution."""

    joints: tuple[str, ...]
    desired: msg.JointTrajectoryPoint
    actual: msg.JointTrajectoryPoint


def execute_trajectory(state: SessionState, arguments: Node, watch: Watch) -> Answer:
    """Drive the session's robot along a trajectory in real time; a cancellation stops it."""
    request = read_call(msg.ExecuteTrajectoryGoal, arguments, watch)

    def tell(_: ExecutionReading) -> object:
        return encode(msg.ExecuteTrajectoryFeedback(STATES[0]), request.generation)

    try:
        code, state = driven(request.message.trajectory, state, watch, tell)
    except TrajoptError as error:
        code = replace(code_of_error(error), val=msg.MoveItErrorCodes.INVALID_MOTION_PLAN)
    return request.answer(msg.ExecuteTrajectoryResult(code), state)


def follow_joint_trajectory(state: SessionState, arguments: Node, watch: Watch) -> Answer:
    """Drive the session's robot along a trajectory as a controller does, with feedback."""
    request = read_call(msg.FollowJointTrajectoryGoal, arguments, watch)
    goal, result, off = request.message, msg.FollowJointTrajectoryResult, list[str]()
    whole = msg.RobotTrajectory(goal.trajectory, goal.multi_dof_trajectory)
    try:
        check_tolerances(goal)

        def tell(seen: ExecutionReading) -> object:
            broken = out_of_tolerance(goal.path_tolerance, seen.joints, seen.desired, seen.actual)
            if broken and not off:
                off.append(broken)
                watch.cancel.set()
            return encode(_feedback(seen), request.generation)

        code, state = driven(whole, state, watch, tell)
    except JointNotFound as error:
        return request.answer(result(result.INVALID_JOINTS, str(error)))
    except TrajoptError as error:
        return request.answer(result(result.INVALID_GOAL, str(error)))
    if off:
        return request.answer(result(result.PATH_TOLERANCE_VIOLATED, f"{off[0]}; {code.message}"), state)
    if code.val == msg.MoveItErrorCodes.SUCCESS:
        names = goal.trajectory.joint_names
        here = msg.JointTrajectoryPoint([state.named_positions[name] for name in names], [0.0] * len(names))
        missed = out_of_tolerance(goal.goal_tolerance, names, goal.trajectory.points[-1], here)
        if missed:
            return request.answer(result(result.GOAL_TOLERANCE_VIOLATED, missed), state)
    if code.val in (msg.MoveItErrorCodes.SUCCESS, msg.MoveItErrorCodes.PREEMPTED):
        return request.answer(result(result.SUCCESSFUL, code.message), state)
    return request.answer(result(result.PATH_TOLERANCE_VIOLATED, code.message), state)


def _feedback(seen: ExecutionReading) -> msg.FollowJointTrajectoryFeedback:
    pairs = zip(seen.desired.positions, seen.actual.positions, strict=True)
    off = msg.JointTrajectoryPoint([wanted - is_at for wanted, is_at in pairs])
    return msg.FollowJointTrajectoryFeedback(
        joint_names=list(seen.joints), desired=seen.desired, actual=seen.actual, error=off
    )


def driven(
    message: msg.RobotTrajectory,
    state: SessionState,
    watch: Watch,
    tell: Callable[[ExecutionReading], object],
) -> tuple[msg.MoveItErrorCodes, SessionState]:
    """Drive the robot of a session along a trajectory, or after a cancellation along the next proven stop."""
    robot = state.scene.robot
    group = _group_of(message.joint_trajectory, message.multi_dof_joint_trajectory.joint_names, robot)
    trajectory = trajectory_of(message, "trajectory", group, state.named_positions)
    if trajectory is None:
        return failed(msg.MoveItErrorCodes.INVALID_MOTION_PLAN, "the trajectory has no points"), state
    reduced = reduce_model(state.scene, group.name, state.positions)
    execution = Execution(reduced, trajectory, group.tip or "")
    refusal = execution.refusal(state.positions)
    if refusal is not None:
        return refusal.error_code, state

    def look(arm: SimulatedExecutor, drive: MotionDriver, now: float) -> None:
        watch.tell({"feedback": tell(_seen(arm, trajectory, now))}, drive.positions.tolist())

    ended = drive_along(execution, state.positions, watch, look)
    if ended.reason:
        return failed(msg.MoveItErrorCodes.CONTROL_FAILED, ended.reason), state
    outcome = execution.measured(ended.positions, ended.remark, stop=ended.stop, met=bool(ended.met))
    watch.tell({}, ended.positions.tolist())
    return outcome.error_code, replace(state, positions=ended.positions)


def _seen(arm: SimulatedExecutor, trajectory: Trajectory, now: float) -> ExecutionReading:
    columns, is_at = [arm.joint_names.index(name) for name in trajectory.joint_names], arm.state()
    moment = min(now, trajectory.duration)
    desired = _point(trajectory(moment), trajectory(moment, 1), now)
    actual = _point(is_at.positions[columns], is_at.velocities[columns], now)
    return ExecutionReading(trajectory.joint_names, desired, actual)


def _point(positions: Floats, velocities: Floats, moment: float) -> msg.JointTrajectoryPoint:
    return msg.JointTrajectoryPoint(
        positions.tolist(), velocities.tolist(), time_from_start=msg.Duration.from_sec(moment)
    )


def _group_of(trajectory: msg.JointTrajectory, planar: list[str], robot: Robot) -> Group:
    moved = {*trajectory.joint_names, *(f"{name}{suffix}" for name in planar for suffix in PLANAR)}
    for group in robot.groups.values():
        if moved == set(group.joints):
            return group
    there = "; ".join(f"{group.name}: {', '.join(group.joints)}" for group in robot.groups.values())
    raise ProblemError(f"no group has just the joints {', '.join(sorted(moved))}; there are {there}")
