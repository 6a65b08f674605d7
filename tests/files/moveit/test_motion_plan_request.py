"""Motion plan request files, apart from their constraints."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from trajopt import Robot, Scene, placement
from trajopt.files.moveit import RequestFile, SceneFile, read_request
from trajopt.problem.problem import Problem
from trajopt.values.errors import FileFormatError, GroupNotFound, NameNotFound, ObjectNotFound
from trajopt.values.shapes.shapes import Sphere

Read = Callable[..., RequestFile]

GOAL = "goal_constraints: [{joint_constraints: [{joint_name: elbow, position: 1.0}]}]"


def body(more: str = "") -> str:
    return f"{{group_name: arm, {GOAL}{', ' + more if more else ''}}}"


def position(request: RequestFile, joint: str) -> float:
    return float(request.start[request.scene.robot.index([joint])[0]])


def test_least_request(request_of: Read) -> None:
    request = request_of(body())
    assert request.group == "arm"
    assert (request.start == 0.0).all()
    assert request.velocity_scaling == request.acceleration_scaling == 1.0
    assert request.allowed_planning_time is None
    assert not request.notes
    problem = request.problem()
    assert isinstance(problem, Problem)
    assert problem.name == "request"
    assert problem.goals == request.goals
    assert problem.constraints == ()


def test_numbers(request_of: Read) -> None:
    request = request_of(
        body(
            "max_velocity_scaling_factor: 0.5, max_acceleration_scaling_factor: 0, "
            "allowed_planning_time: 5, workspace_parameters: {min_corner: [-1, -1, -1]}"
        )
    )
    problem = request.problem()
    assert (problem.velocity_scaling, problem.acceleration_scaling) == (0.5, 1.0)
    assert request.allowed_planning_time == 5.0
    assert not request.notes


def test_ignored_fields_are_noted(request_of: Read) -> None:
    request = request_of(
        body("planner_id: RRTConnect, pipeline_id: ompl, num_planning_attempts: 3, max_cartesian_speed: 1")
    )
    assert {note.split(":")[0] for note in request.notes} == {
        "planner_id",
        "pipeline_id",
        "num_planning_attempts",
        "max_cartesian_speed",
    }


@pytest.mark.parametrize("key", ["cartesian_speed_limited_link", "cartesian_speed_end_effector_link"])
def test_the_speed_of_a_link_is_limited(request_of: Read, key: str) -> None:
    request = request_of(body(f"max_cartesian_speed: 0.25, {key}: hand"))
    (limited,) = request.problem().tool_speeds
    assert (limited.frame, limited.linear, limited.angular) == ("hand", 0.25, float("inf"))
    assert not request.notes
    with pytest.raises(NameNotFound):
        request_of(body(f"max_cartesian_speed: 0.25, {key}: nothing"))
    assert request_of(body(f"max_cartesian_speed: 0, {key}: hand")).problem().tool_speeds == ()


def test_start_over_scene_over_default(scene_of: Callable[[str], SceneFile], request_of: Read) -> None:
    scene = scene_of(
        "robot_state: {joint_state: {name: [shoulder, elbow, left_slide, right_slide], "
        "position: [0.1, 0.2, 0.03, 0.01]}}"
    )
    request = request_of(body("start_state: {joint_state: {name: [elbow], position: [0.7]}}"), scene)
    assert [position(request, j) for j in ("shoulder", "elbow", "left_slide", "right_slide")] == [
        0.1,
        0.7,
        0.03,
        0.01,
    ]
    request = request_of(body("start_state: {joint_state: {name: [left_slide], position: [0.02]}}"), scene)
    assert position(request, "right_slide") == 0.02


def test_positions_outside_the_limits_are_taken_as_they_are(request_of: Read) -> None:
    request = request_of(body("start_state: {joint_state: {name: [left_slide], position: [0.065]}}"))
    assert position(request, "left_slide") == position(request, "right_slide") == 0.065


def test_fixed_and_unknown_joints_of_a_start_state_are_noted(request_of: Read) -> None:
    assert request_of(body("start_state: {joint_state: {name: [flange], position: [0]}}"))
    request = request_of(
        body("start_state: {joint_state: {name: [flange, wheel, elbow], position: [0.2, 7, 0.4]}}")
    )
    assert position(request, "elbow") == 0.4
    unknown, fixed = request.notes
    assert unknown.startswith("start_state.joint_state") and "wheel" in unknown
    assert "flange (at 0.2)" in fixed


def test_start_state_carries(request_of: Read, planar_arm: Robot) -> None:
    scene = Scene(planar_arm).add("part", Sphere(0.05), placement((1.1, 0.0, 0.1)))
    request = request_of(
        body(
            "start_state: {attached_collision_objects: [{link_name: hand, object: {id: part}, "
            "touch_links: [left_finger]}]}"
        ),
        scene,
    )
    item = request.scene.object("part")
    assert item.frame == "hand"
    assert np.allclose(item.placement.translation, (0.1, 0.0, 0.0))
    assert item.touch_links == {"hand", "left_finger"}
    assert scene.object("part").frame == "world"
    assert request.problem().scene is request.scene


SEVERAL = (
    "{{group_name: arm, goal_constraints: ["
    "{{{first}joint_constraints: [{{joint_name: elbow, position: 1}}]}}, "
    "{{{second}joint_constraints: [{{joint_name: elbow, position: 2}}]}}]}}"
)


def test_any_of_several_goals(request_of: Read) -> None:
    request = request_of(SEVERAL.format(first="", second="name: bent, "))
    assert request.goals[0].positions == {"elbow": 1.0}
    problem = request.problem()
    assert list(problem.alternatives) == ["goal 1", "bent"]
    assert problem.alternatives["bent"].goals[0].positions == {"elbow": 2.0}


def test_goals_of_one_name(request_of: Read) -> None:
    with pytest.raises(FileFormatError, match=r"goal_constraints\[1\].name: 'bent' is the name of two goals"):
        request_of(SEVERAL.format(first="name: bent, ", second="name: bent, "))


def test_trajectory_constraints_are_waypoints(request_of: Read) -> None:
    knots = ", ".join(f"{{joint_constraints: [{{joint_name: shoulder, position: {at}}}]}}" for at in (1, 2))
    problem = request_of(body(f"trajectory_constraints: {{constraints: [{knots}]}}")).problem()
    assert [wanted[0].positions["shoulder"] for wanted in problem.waypoint_requirements] == [1.0, 2.0]


def test_path_constraints(request_of: Read) -> None:
    request = request_of(
        body("path_constraints: {name: keep, joint_constraints: [{joint_name: shoulder, position: 0}]}")
    )
    (constraint,) = request.problem().constraints
    assert constraint.positions == {"shoulder": 0.0}


def test_robot_without_srdf(write: Callable[..., Path], planar_arm: Robot) -> None:
    bare = Scene(Robot.from_urdf(planar_arm.urdf_path))
    request = read_request(write(body()), bare)
    assert request.problem().group == "all"
    assert "'arm' needs the robot's SRDF" in request.notes[0]
    assert read_request(write(f"{{{GOAL}}}"), bare).notes == ()


@pytest.mark.parametrize(
    ("text", "error", "message"),
    [
        (f"{{group_name: amr, {GOAL}}}", GroupNotFound, "did you mean 'arm'"),
        (f"{{{GOAL}}}", GroupNotFound, "arm"),
        ("{group_name: arm}", FileFormatError, "goal_constraints: names no goal"),
        ("{group_name: arm, goal_constraints: [{}]}", FileFormatError, "requires nothing"),
        (body("max_velocity_scaling_factor: 1.5"), FileFormatError, r"must lie in \(0, 1\]"),
        (body("max_acceleration_scaling_factor: -1"), FileFormatError, "max_acceleration_scaling"),
        (body("planner: x"), FileFormatError, "did you mean 'planner_id'"),
        (body("trajectory_constraints: {constraints: [{}]}"), FileFormatError, "requires nothing"),
        (
            body("start_state: {attached_collision_objects: [{link_name: hand, object: {id: part}}]}"),
            ObjectNotFound,
            "'part'",
        ),
    ],
)
def test_bad_request(request_of: Read, text: str, error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message) as caught:
        request_of(text)
    assert "request.yaml" in str(caught.value)
