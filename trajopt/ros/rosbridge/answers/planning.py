"""Motions: `/plan_kinematic_path` and `/compute_cartesian_path`."""

from dataclasses import replace
from math import inf

from trajopt.files import messages as msg
from trajopt.files.messages import decode, document_of
from trajopt.files.moveit.constraints import read_constraints
from trajopt.files.moveit.frames import placement_in_world, read_frame, read_placement, reading_at
from trajopt.files.moveit.motion_plan_request import RequestFile, request_of
from trajopt.files.moveit.planning_scene import edit_scene, without_collisions
from trajopt.files.moveit.scene_messages import state_message
from trajopt.files.moveit.trajectories import trajectory_message
from trajopt.optimise.methods import METHODS, method_named
from trajopt.planning.budget import Budget
from trajopt.planning.result import Result
from trajopt.problem.tool_speed import tool_speed
from trajopt.ros.rosbridge.answers.service_call import (
    SOURCE,
    code_of_error,
    positions_in,
    read_call,
    service,
    stated_in,
    success,
    with_notes,
)
from trajopt.server.move_group.functions import (
    SHORTEST,
    Settings,
    attempted,
    cost_of,
    followed_through,
    fraction_of,
)
from trajopt.server.move_group.outcome import CODES
from trajopt.server.operation import Answer, SessionState, Watch
from trajopt.values.documents.document import Node
from trajopt.values.errors import FrameNotFound, GroupNotFound, TrajoptError, shown

ANSWERING = 0.5
"""Time reserved for the answer after planning [s], within the time limit of the request."""

HEEDED = ("planner_id", "pipeline_id", "num_planning_attempts")
"""Fields ignored in files, but not in requests."""


def plan_kinematic_path(state: SessionState, arguments: Node, watch: Watch) -> Answer:
    """Plan a motion to a goal and verify it; of several attempts, keep the least duration."""
    request = read_call(msg.GetMotionPlanRequest, arguments, watch)
    message = request.message.motion_plan_request
    response = msg.MotionPlanResponse(group_name=message.group_name)
    try:
        state = _different(state, arguments["difference"])
        read = request_of(document_of(message, "motion_plan_request"), state.scene, state.named_positions)
        result, spent = _planned(read, message, watch)
    except TrajoptError as error:
        response.error_code = code_of_error(error)
        return request.answer(msg.GetMotionPlanResponse(response))
    response.group_name, response.planning_time = read.group, spent
    response.trajectory_start = state_message(read.scene, read.start)
    code = msg.MoveItErrorCodes(CODES[result.status], result.reason, SOURCE)
    response.error_code = with_notes(code, _remarks(read, message))
    if result.verified:
        response.trajectory = trajectory_message(result.trajectory, state.scene.robot.links[0])
    return request.answer(msg.GetMotionPlanResponse(response))


def _remarks(read: RequestFile, message: msg.MotionPlanRequest) -> list[str]:
    remarks = [note for note in read.notes if not note.startswith(HEEDED)]
    if message.planner_id and message.planner_id not in METHODS:
        remarks.append(f"planner {shown(message.planner_id)} is not here: trajopt has chosen")
    return remarks


def _different(state: SessionState, document: Node) -> SessionState:
    if document.missing:
        return state
    message = decode(msg.PlanningScene, document, name="planning_scene_diff")
    if message == msg.PlanningScene():
        return state
    if not message.is_diff:
        raise document.error("planning_scene_diff: is not a difference (is_diff)")
    positions = positions_in(message.robot_state, state, "planning_scene_diff.robot_state")
    node = document_of(message, "planning_scene_diff")
    return replace(
        state, scene=edit_scene(node, state.scene, reading_at(state.scene, positions)), positions=positions
    )


def _planned(read: RequestFile, message: msg.MotionPlanRequest, watch: Watch) -> tuple[Result, float]:
    problem = replace(read.problem(), name=read.group)
    method = method_named(message.planner_id) if message.planner_id in METHODS else None
    seconds = min(read.allowed_planning_time or inf, watch.seconds_left - ANSWERING)
    results = attempted(
        problem,
        method,
        max(message.num_planning_attempts, 1),
        seconds,
        cancel=watch.cancel,
        progress=watch.progress if watch.heard else None,
        on_incumbent=watch.incumbent if watch.heard else None,
    )
    spent = sum(seconds for each in results for seconds in each.cpu_seconds.values())
    return min(results, key=cost_of), spent


def _followed(
    request: msg.GetCartesianPathRequest, state: SessionState, watch: Watch
) -> msg.GetCartesianPathResponse:
    """Follow straight lines with a link as far as possible; a partial path is also a success."""
    robot = state.scene.robot
    if request.group_name not in robot.groups:
        raise GroupNotFound("group", request.group_name, robot.groups)
    link = request.link_name or robot.group(request.group_name).tip or ""
    stated = stated_in(request.start_state, state, "start_state")
    document, start, reading = document_of(request, "args"), stated.positions, stated.reading
    constraints, scene = read_constraints(document["path_constraints"], stated.scene, reading)
    known = (*scene.frame_names, *scene.objects)
    if link not in known:
        raise FrameNotFound("link", link, known)
    response = msg.GetCartesianPathResponse(state_message(stated.scene, start))
    frame = placement_in_world(read_frame(document["header"], scene, reading), scene, reading)
    limited = request.cartesian_speed_limited_link or request.cartesian_speed_end_effector_link or link
    speed = request.max_cartesian_speed
    followed = followed_through(
        scene if request.avoid_collisions else without_collisions(scene),
        [frame * read_placement(each, reading.notes) for each in document["waypoints"].elements()],
        link=link,
        group=request.group_name,
        start=start,
        settings=Settings(
            velocity_scaling=request.max_velocity_scaling_factor or 1.0,
            acceleration_scaling=request.max_acceleration_scaling_factor or 1.0,
            tool_speed=tool_speed(limited, linear=speed) if speed > 0.0 else None,
        ),
        constraints=constraints,
        budget=Budget(max(watch.seconds_left - ANSWERING, SHORTEST)),
        cancel=watch.cancel,
    )
    response.error_code = with_notes(success(followed.reason), reading.notes)
    if followed.verified:
        response.solution = trajectory_message(followed.trajectory, robot.links[0])
        response.fraction = fraction_of(followed)
    return response


compute_cartesian_path = service(msg.GetCartesianPathRequest, msg.GetCartesianPathResponse, _followed)
