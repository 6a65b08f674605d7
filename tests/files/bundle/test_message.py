"""Values sent to another process: they come back as they were, verdicts excepted, and lies are found."""

import json
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import trajopt as to
from trajopt.files.bundle.containers import message_of, value_of_message
from trajopt.planning.result import Result
from trajopt.values.documents.document import Node
from trajopt.values.errors import FileFormatError

Change = Callable[[dict[str, Any]], object]


def sent(value: object, known: dict[str, object] | None = None) -> Any:
    """Return what a message holds once it went over a wire."""
    document = json.loads(json.dumps(message_of(value, known or {}), allow_nan=False))
    return value_of_message(Node(document, "message"), known or {}, object)


def test_a_result_is_restored_whole_and_judged_again(solved: Result) -> None:
    robot = solved.problem.scene.robot
    back = sent(solved, {"robot": robot})
    assert isinstance(back, Result)
    assert str(back) == str(solved)
    assert back.as_dict()["tries"] == solved.as_dict()["tries"]
    assert back.judged is not None and back.judged.verified
    assert back.problem.scene.robot is robot
    assert back.trajectory is not None and solved.trajectory is not None
    assert np.array_equal(back.trajectory.positions, solved.trajectory.positions)


def test_repeated_values_are_sent_once(solved: Result) -> None:
    scene = solved.problem.scene
    document = message_of((scene, scene, solved.problem), {"robot": scene.robot})
    assert json.dumps(document).count('"kind": "Scene"') == 1
    one, other, problem = value_of_message(Node(document, "m"), {"robot": scene.robot}, tuple)
    assert one is other
    assert problem.scene is one


def test_a_robot_comes_back_without_the_places_of_its_files(solved: Result) -> None:
    robot = solved.problem.scene.robot
    text = json.dumps(message_of(robot, {}))
    assert str(robot.urdf_path.parent) not in text
    back = sent(robot)
    assert back.joint_names == robot.joint_names
    assert np.array_equal(back.limits.jerk, robot.limits.jerk)


def test_a_motion_that_is_not_proven_is_refused(solved: Result) -> None:
    trajectory = solved.trajectory
    assert trajectory is not None
    known: dict[str, object] = {"robot": solved.problem.scene.robot}
    lie = to.Trajectory(trajectory.joint_names, 0.2 * trajectory.times, trajectory.positions)
    with pytest.raises(FileFormatError, match="a motion that is not proven"):
        sent(replace(solved, trajectory=lie), known)


HOSTILE: dict[str, tuple[Change, str]] = {
    "a cycle": (lambda d: d["shared"].insert(0, {"shared": 0}), "not before it"),
    "a negative place": (lambda d: d.update(value={"shared": -1}), "not before it"),
    "a truth value as a place": (lambda d: d.update(value={"shared": True}), "not before it"),
    "what nobody knows": (lambda d: d.update(value={"known": "os"}), "known are robot"),
    "another kind": (lambda d: d.update(value={"kind": "Popen", "args": ["sh"]}), "known kinds"),
    "no array": (lambda d: d.update(value={"array": "x"}, arrays={"x": "####"}), "is not an array"),
    "an array of objects": (
        lambda d: d.update(value={"array": "x"}, arrays={"x": "gASVAAAA"}),
        "is not an array",
    ),
    "an array that is not there": (lambda d: d.update(value={"array": "x"}), "must be text"),
    "another member": (lambda d: d.update(more=1), "unknown key"),
    "nothing": (lambda d: d.clear(), "must be a Scene"),
}


@pytest.mark.parametrize(("change", "reason"), HOSTILE.values(), ids=HOSTILE)
def test_hostile_messages_are_refused_with_the_place(solved: Result, change: Change, reason: str) -> None:
    scene = solved.problem.scene
    known: dict[str, object] = {"robot": scene.robot}
    document = json.loads(json.dumps(message_of(scene, known)))
    change(document)
    with pytest.raises(FileFormatError, match=reason):
        value_of_message(Node(document, "message"), known, to.Scene)


def test_messages_above_the_request_limits_are_refused() -> None:
    faces, rows = np.zeros((80, 3), np.int64), np.zeros((80, 7))
    for value, most in ((faces, {"triangles": 50}), (rows, {"rows": 50})):
        document = message_of(value, {})
        with pytest.raises(FileFormatError, match="more than a request may"):
            value_of_message(Node(document, "message"), {}, np.ndarray, **most)
        assert len(value_of_message(Node(document, "message"), {}, np.ndarray)) == 80
