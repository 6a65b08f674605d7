"""What can be asked for: each operation on a planar arm or a Panda, without processes."""

import json
from base64 import b64decode
from contextlib import suppress
from dataclasses import replace
from inspect import signature
from threading import Timer
from typing import Any

import numpy as np
import pytest

import trajopt as to
from trajopt.files.proof import MotionProof
from trajopt.robot.configuration import initial_positions
from trajopt.server import RequestRefused, SessionState, Watch
from trajopt.server.limits import check_sizes
from trajopt.server.operation import operations_of
from trajopt.server.operations.scenes import SCENE_EDITS
from trajopt.values.documents.document import Node

OPERATIONS = operations_of(("trajopt.server.operations",))
REACH = {"goal": {"joint_positions": {"positions": {"joint1": 0.4, "joint2": 0.3}}}}


def state(robot: str = "planar2") -> SessionState:
    loaded = to.load(robot)
    return SessionState(robot, to.Scene(loaded), initial_positions(loaded))


def ask(
    operation: str, arguments: dict[str, Any], held: SessionState | None = None, watch: Watch | None = None
) -> tuple[Any, SessionState]:
    """Ask as over the wire: through JSON."""
    held = held or state()
    node = Node(json.loads(json.dumps(arguments)), "request")
    answer = OPERATIONS[operation].run(held, node, watch or Watch(60.0))
    return json.loads(json.dumps(answer.document, allow_nan=False)), answer.state or held


POST = {
    "add": {"name": "post", "shape": {"sphere": {"radius": 0.1}}, "placement": {"xyz": [0.75, -0.4, 0.14]}}
}


def test_a_plan_in_the_words_of_the_python_api() -> None:
    held = ask("edit", {"edits": [POST]})[1]
    answer, _ = ask("plan", {"problem": {"start": [0.0, 0.0], **REACH}, "certificate": True}, held)
    problem = to.Problem(
        scene=held.scene,
        start={"joint1": 0.0, "joint2": 0.0},
        goal=to.joint_positions({"joint1": 0.4, "joint2": 0.3}),
    )
    expected = to.plan(problem).as_dict()
    assert answer["verified"]
    assert answer["points"] == expected["points"]
    assert answer["certificate"] == json.loads(json.dumps(expected["certificate"]))


def test_a_plan_without_a_certificate_is_marked_as_verified() -> None:
    answer, _ = ask("plan", {"problem": REACH})
    assert answer["verified"] and answer["certificate"] is None


def test_a_proof_is_returned_if_requested() -> None:
    answer, _ = ask("plan", {"problem": REACH, "proof": True})
    assert MotionProof(b64decode(answer["proof"])).check().proven
    assert "proof" not in ask("plan", {"problem": REACH})[0]
    held = ask("edit", {"edits": [{"add": {**POST["add"], "placement": {"xyz": [0.7, 0.35, 0.14]}}}]})[1]
    failed, _ = ask("plan", {"problem": REACH, "proof": True}, held)
    assert not failed["verified"] and failed["proof"] is None
    assert "there is no proof" in failed["notes"][-1]


def test_placements_constraints_and_goals_among_several() -> None:
    down = {"axis_alignment": {"frame": "panda_hand_tcp", "direction": [0, 0, -1], "tolerance": 0.2}}
    here = {"xyz": [0.4, 0.3, 0.4], "rpy": [np.pi, 0, 0]}
    near = {"frame_placement": {"frame": "panda_hand_tcp", "placement": here}}
    problem = {
        "group": "panda_arm",
        "start": "ready",
        "goal": {"any_of": {"goals": {"near": near}}},
        "constraints": [down],
        "velocity_scaling": 0.5,
    }
    answer, _ = ask("plan", {"problem": problem}, state("panda"))
    assert answer["verified"], answer["message"]


def test_the_message_of_moveit_is_read_in_the_scene_of_the_session() -> None:
    joints = [{"joint_name": "joint1", "position": 0.4}, {"joint_name": "joint2", "position": 0.3}]
    answer, _ = ask("plan", {"request": {"goal_constraints": [{"joint_constraints": joints}]}})
    assert answer["verified"]
    ask("check", {"problem": REACH, "trajectory": {key: answer[key] for key in ("joint_names", "points")}})


def test_a_planning_scene_of_moveit_is_taken_whole_or_as_a_difference() -> None:
    def ball(name: str, operation: int = 0) -> dict[str, Any]:
        pose = {"position": {"x": 0.75, "y": -0.4, "z": 0.14}, "orientation": {"w": 1.0}}
        shape = {"type": 2, "dimensions": [0.1]}
        solid = {"primitives": [shape], "primitive_poses": [pose]} if operation == 0 else {}
        return {"id": name, "operation": operation, **solid}

    def scene(*objects: dict[str, Any], diff: bool, **state: float) -> dict[str, Any]:
        joints = {"joint_state": {"name": list(state), "position": list(state.values())}, "is_diff": True}
        return {"world": {"collision_objects": list(objects)}, "is_diff": diff, "robot_state": joints}

    document, held = ask("planning_scene", scene(ball("a"), diff=False, joint1=0.3))
    assert list(document["objects"]) == ["a"] and document["positions"]["joint1"] == 0.3
    document, held = ask("planning_scene", scene(ball("b"), diff=True), held)
    assert sorted(document["objects"]) == ["a", "b"] and document["positions"]["joint1"] == 0.3
    document, held = ask("planning_scene", scene(ball("a", 1), diff=True, joint1=-0.49), held)
    assert list(document["objects"]) == ["b"]
    assert "b" in " ".join(ask("validity", {}, held)[0]["reasons"])
    assert list(ask("planning_scene", scene(ball("c"), diff=False), held)[0]["objects"]) == ["c"]
    with pytest.raises(to.TrajoptError, match="did you mean"):
        ask("planning_scene", {"wurld": {}})


def test_a_misspelt_shape_gets_a_near_match() -> None:
    """The reason asked for "pairs (shape, placement)", which JSON does not have."""
    edit = {"add": {"name": "post", "shape": {"boxx": {"x": 0.1, "y": 0.1, "z": 0.1}}}}
    with pytest.raises(to.TrajoptError, match=r"shape: unknown key 'boxx'; did you mean 'box'"):
        ask("edit", {"edits": [edit]})


def test_a_motion_is_checked() -> None:
    answer, _ = ask("plan", {"problem": REACH})
    motion = {key: answer[key] for key in ("joint_names", "points")}
    verdict, _ = ask("check", {"problem": REACH, "trajectory": motion})
    assert verdict["verified"]
    blocked, _ = ask("check", {"problem": REACH, "trajectory": motion, "edits": [POST | {}]})
    assert blocked["verified"] == verdict["verified"]
    motion["points"] = [{**point, "time_from_start": 0.01 * i} for i, point in enumerate(motion["points"])]
    assert not ask("check", {"problem": REACH, "trajectory": motion})[0]["verified"]


def test_kinematics_forward_and_inverse() -> None:
    placed, _ = ask("forward_kinematics", {"positions": [[0.0, 0.5], [np.pi / 2, 0.5]], "frames": ["tool"]})
    first, second = (each["xyz"] for each in placed["placements"]["tool"])
    assert first[0] == pytest.approx(second[1])
    goal = {"frame_placement": {"frame": "tool", "placement": {"xyz": second}, "rotation_tolerance": 4.0}}
    found, _ = ask("inverse_kinematics", {"goal": goal})
    assert any(np.allclose(each, [np.pi / 2, 0.5], atol=1e-2) for each in found["free"])


def test_a_configuration_is_judged() -> None:
    held = ask("edit", {"edits": [POST, {"stand": {"joint1": -0.49, "joint2": 0.0}}]})[1]
    assert held.positions[0] == -0.49
    assert not ask("validity", {}, held)[0]["valid"]
    assert ask("validity", {"positions": [1.0, 0.0]}, held)[0]["valid"]


def test_edits_are_made_all_or_none_and_named_where_wrong() -> None:
    held = state()
    with pytest.raises(to.TrajoptError, match=r"edits\[1\].*pots"):
        ask("edit", {"edits": [POST, {"remove": {"name": "pots"}}]}, held)
    with pytest.raises(to.TrajoptError, match="radios"):
        ask("edit", {"edits": [{"add": {"name": "a", "shape": {"sphere": {"radios": 1.0}}}}]}, held)
    with pytest.raises(to.TrajoptError, match="unknown key"):
        ask("edit", {"edits": [{"__init__": {}}]}, held)
    with pytest.raises(to.TrajoptError, match=r"unknown key 'first'; known: a, allowed, b$"):
        ask("edit", {"edits": [{"allow": {"first": "a"}}]}, held)
    document, _ = ask("read", {}, held)
    assert document["objects"] == {}


WRONG: tuple[Any, ...] = (
    None,
    -1,
    "x",
    "ball",
    [],
    {},
    [[1, 2]],
    {"xyz": [0, 0, 0]},
    {"sphere": {"radius": 1}},
)
"""What an argument may be that is not meant so."""
GIVEN: dict[str, dict[str, Any]] = {
    "add": {"name": "n", "shape": {"sphere": {"radius": 0.1}}},
    "move": {"name": "ball", "placement": {"xyz": [0, 0, 0]}},
    "attach": {"name": "ball", "link": "tool"},
}


@pytest.mark.parametrize("edit", SCENE_EDITS)
def test_no_argument_of_an_edit_is_a_fault_of_the_server(edit: str) -> None:
    """What raises anything but a typed error would be told as one."""
    held = state()
    held = replace(held, scene=held.scene.add("ball", to.Sphere(0.1), to.placement((0.65, 0.65, 0.1))))
    for name in signature(SCENE_EDITS[edit]).parameters:
        for value in WRONG:
            given = GIVEN.get(
                edit, {"name": "ball"} if "name" in signature(SCENE_EDITS[edit]).parameters else {}
            )
            with suppress(to.TrajoptError):
                ask("edit", {"edits": [{edit: {**given, name: value}}]}, held)


@pytest.mark.parametrize("member", signature(to.Problem).parameters)
def test_no_member_of_a_problem_is_a_fault_of_the_server(member: str) -> None:
    still = [{"time_from_start": t, "positions": [0.0, 0.5]} for t in (0.0, 1.0)]
    trajectory = {"joint_names": ["joint1", "joint2"], "points": still}
    for value in WRONG:
        with suppress(to.TrajoptError):
            ask("check", {"problem": {**REACH, member: value}, "trajectory": trajectory})


def test_an_object_can_be_recreated_from_its_document() -> None:
    pole, ball = {"cylinder": {"radius": 0.1, "length": 1.0}}, {"sphere": {"radius": 0.2}}
    parts = [[pole, {"xyz": [1, 2, 3]}], [ball, {"xyz": [0, 0, 1]}]]
    document, held = ask("edit", {"edits": [{"add": {"name": "lamp", "shape": parts}}]})
    lamp = document["objects"]["lamp"]
    again = [[each["shape"], each["placement"]] for each in lamp["parts"]]
    other, _ = ask("edit", {"edits": [{"add": {"name": "copy", "shape": again}}]}, held)
    assert other["objects"]["copy"]["parts"] == lamp["parts"]
    assert [next(iter(each["shape"])) for each in lamp["parts"]] == ["cylinder", "sphere"]


def test_an_object_is_carried_and_put_down() -> None:
    box = {
        "add": {
            "name": "box",
            "shape": {"box": {"x": 0.1, "y": 0.1, "z": 0.1}},
            "placement": {"xyz": [2, 0, 0]},
        }
    }
    held = ask("edit", {"edits": [box, {"attach": {"name": "box", "link": "tool"}}]})[1]
    document, held = ask("edit", {"edits": [{"stand": [1.0, 0.0]}, {"detach": {"name": "box"}}]}, held)
    assert document["objects"]["box"]["placement"]["xyz"][1] > 1.0


def test_objects_move() -> None:
    held = ask("edit", {"edits": [POST]})[1]
    motion = {"object": "post", "times": [0, 1], "positions": [[0.75, -0.4, 0.14], [0.75, -3.0, 0.14]]}
    document, held = ask("motions", {"motions": [motion]}, held)
    assert document["objects"]["post"]["changes"] and held.scene.changing
    assert ask("plan", {"problem": {"start": [0.0, 0.0], **REACH}}, held)[0]["verified"]


def test_a_curve_is_followed() -> None:
    panda = state("panda")
    here = panda.scene.placement_of("panda_hand_tcp", panda.positions)
    poses = [{"xyz": here.translation.tolist(), "quaternion": here.quaternion.tolist()}]
    poses.append({**poses[0], "xyz": (here.translation + np.array((0.0, 0.1, 0.0))).tolist()})
    curve = {"frame": "panda_hand_tcp", "curve": {"polyline": {"poses": poses}}}
    answer, _ = ask("follow", {"follows_curve": curve, "group": "panda_arm"}, panda)
    assert answer["fraction"] == 1.0 and answer["verified"]


def test_a_failure_is_explained() -> None:
    goal = {"joint_positions": {"positions": {"joint1": -0.49, "joint2": 0.0}}}
    answer, _ = ask("explain", {"edits": [POST], "problem": {"start": [1.0, 0.0], "goal": goal}})
    assert answer["status"] == "GOAL_IN_COLLISION" and "post" in answer["words"]


def test_the_simulated_robot_drives_and_reports_its_position() -> None:
    told: list[Any] = []
    watch = Watch(60.0, lambda document, places: told.append((document, places)))
    answer, held = ask("execute", {"problem": REACH, "speed": 0}, watch=watch)
    assert answer["reached"] and answer["contacts"] == []
    np.testing.assert_allclose(held.positions, [0.4, 0.3], atol=5e-3)
    assert [places[0] for _, places in told] == sorted(places[0] for _, places in told)


def test_the_simulated_robot_stops() -> None:
    watch = Watch(60.0)
    far = {"goal": {"joint_positions": {"positions": {"joint1": 2.5, "joint2": 0.3}}}}
    timer = Timer(0.3, watch.cancel.set)
    timer.start()
    answer, held = ask("execute", {"problem": far, "speed": 1}, watch=watch)
    timer.join()
    assert answer["stopped"] and not answer["reached"]
    assert held.positions[0] < 2.4


def test_the_simulated_robot_is_at_rest_when_its_time_is_over() -> None:
    far = {"goal": {"joint_positions": {"positions": {"joint1": 2.5, "joint2": 0.3}}}}
    answer, held = ask("execute", {"problem": far, "speed": 0, "longest": 0.4})
    assert answer["stopped"] and not answer["reached"]
    assert answer["events"][-1]["kind"] == "stopping"
    assert answer["duration"] > 0.6, "it brakes for longer than that"
    assert 0.0 < held.positions[0] < 2.4


def test_the_simulated_robot_touches_what_is_put_in_its_place_on_the_way() -> None:
    held = state()
    there = held.scene.placement_of(held.scene.robot.links[-1], held.positions)
    blocked = held.scene.add("post", to.Sphere(0.2), there)
    watch = Watch(60.0, lambda *_: watch.change(lambda: blocked))
    answer, _ = ask("execute", {"problem": REACH, "speed": 0, "longest": 2.0}, held, watch)
    assert any("post" in contact for contact in answer["contacts"])


def test_sizes_are_bounded() -> None:
    watch = Watch(1.0, triangles=10, points=10)
    check_sizes({"a": [{"faces": [[0, 1, 2]] * 10}], "points": [1] * 10}, watch)
    for document in ({"a": {"faces": [[0, 1, 2]] * 11}}, [{"points": [1] * 11}]):
        with pytest.raises(RequestRefused, match="at most"):
            check_sizes(document, watch)


def test_a_problem_is_stated_once() -> None:
    twice: dict[str, Any] = {"problem": REACH, "request": {"goal_constraints": []}}
    for arguments in ({}, twice):
        with pytest.raises(to.TrajoptError, match="once"):
            ask("plan", arguments)
    with pytest.raises(to.TrajoptError, match="scene"):
        ask("plan", {"problem": {**REACH, "scene": {"objects": {}}}})


def test_the_state_of_a_session_is_not_changed_by_a_request() -> None:
    held = state()
    ask("plan", {"edits": [POST], "problem": REACH}, held)
    assert not held.scene.objects
    assert replace(held).scene is held.scene


@pytest.mark.parametrize("degrees", [False, True])
def test_a_start_keeps_joints_that_it_does_not_name(degrees: bool) -> None:
    held = replace(state(), positions=np.array((0.3, 0.6)))
    start = {"joint1": np.rad2deg(0.1) if degrees else 0.1}
    problem = {"group": "arm", "start": start, "degrees": degrees, **REACH}
    answer, _ = ask("plan", {"problem": problem}, held)
    assert answer["points"][0]["positions"] == pytest.approx([0.1, 0.6])
    places = [
        ask("forward_kinematics", {"group": "arm", "start": given, "frames": ["tool"]}, held)[0]["placements"]
        for given in ({"joint1": 0.3}, {"joint1": 0.3, "joint2": 0.6})
    ]
    assert places[0] == places[1]


def test_a_named_start_of_the_arm_keeps_the_fingers() -> None:
    held = replace(state("panda"), positions=to.load("panda").positions({"panda_finger_joint1": 0.03}))
    problem = {"group": "panda_arm", "start": "ready", "goal": {"panda_joint1": 0.1}}
    edited = ask("edit", {"edits": [{"with_tool": {"name": "tip", "on": "panda_leftfinger"}}]}, held)[1]
    asked = {"group": "panda_arm", "frames": ["tip"], "reference": "panda_hand", "start": "ready"}
    here, there = (
        ask("forward_kinematics", {**asked, **given}, edited)[0] for given in ({}, {"start": None})
    )
    assert here["placements"]["tip"][0]["xyz"] == pytest.approx(there["placements"]["tip"][0]["xyz"])
    assert ask("plan", {"problem": problem}, held)[0]["verified"]


def test_a_session_stands_in_radians_if_the_goal_is_in_degrees() -> None:
    held = replace(state(), positions=np.array((0.3, 0.6)))
    answer, _ = ask("plan", {"problem": {"goal": {"joint1": 20.0}, "degrees": True}}, held)
    assert answer["points"][0]["positions"] == pytest.approx([0.3, 0.6])
