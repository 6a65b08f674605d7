"""Motions of a scene's objects in a file."""

import json
from pathlib import Path

import numpy as np
import pytest

import trajopt as to
from tests.robots_for_tests import odd_arm
from trajopt.files.moveit import read_motions, read_request
from trajopt.problem.requirements import FramePlacement
from trajopt.values.errors import FileFormatError

MOTIONS = """
- object: box
  times: [0.5, 1.5]
  positions: [[2.0, 1.0, 0.2], [2.0, -1.0, 0.2]]
  orientations: [[0, 0, 0, 1], [0, 0, 1, 1]]
  error: {radius: 0.01, velocity: 0.02}
  until: 4.0
- object: post
  appears: 0.5
  expires: 3.0
"""


@pytest.fixture
def scene(tmp_path: Path) -> to.Scene:
    here = to.placement((2.0, 0.0, 0.0), rpy=(0.0, 0.0, 0.3))
    return (
        to.Scene(odd_arm(tmp_path))
        .add("box", to.Box(0.1, 0.1, 0.1), here)
        .add("post", to.Box(0.1, 0.1, 1.0), to.placement((0.0, 2.0, 0.0)))
        .add("held", to.Sphere(0.02), frame="tip")
    )


def written(folder: Path, text: str, name: str = "motions.yaml") -> Path:
    (folder / name).write_text(text)
    return folder / name


def test_reads_motion_appearance_and_expiry_of_objects(scene: to.Scene, tmp_path: Path) -> None:
    moved = read_motions(written(tmp_path, MOTIONS), scene)
    assert moved.changing == ("box", "post")
    box, post = moved.objects["box"].timing, moved.objects["post"].timing
    assert box.motion is not None and box.motion.until == 4.0 and box.motion.error == (0.01, 0.02, 0.0)
    assert box.motion.track.at(1.0).translation == pytest.approx((2.0, 0.0, 0.2))
    assert box.motion.track.at(1.0).rpy == pytest.approx((0.0, 0.0, np.pi / 4))
    assert (post.motion, post.appears, post.expires) == (None, 0.5, 3.0)
    assert moved.objects["post"].placement == scene.objects["post"].placement


def test_json_will_do_and_orientations_may_stay(scene: to.Scene, tmp_path: Path) -> None:
    entry = {"object": "box", "times": [0.0, 1.0], "positions": [[2.0, 0.0, 0.0], [3.0, 0.0, 0.0]]}
    moved = read_motions(written(tmp_path, json.dumps([entry]), "motions.json"), scene)
    motion = moved.objects["box"].timing.motion
    assert motion is not None and motion.track.at(0.5).rpy == pytest.approx((0.0, 0.0, 0.3))


def test_an_object_on_a_moving_frame_moves_along(scene: to.Scene, tmp_path: Path) -> None:
    entry = "- {object: post, carried_by: box, expires: 2.0}\n- {object: box, times: [0, 1], positions: "
    moved = read_motions(written(tmp_path, entry + "[[2, 0, 0], [3, 0, 0]]}"), scene)
    assert moved.carrier("post") == "box" and moved.objects["post"].timing.expires == 2.0
    start = np.array(moved.robot.positions({}))
    for time, x in ((0.0, 0.0), (0.5, 0.5), (3.0, 1.0)):
        assert moved.at(time).placement_of("post", start).translation == pytest.approx((x, 2.0, 0.0))


REQUEST = """
group_name: all
start_state: {joint_state: {name: [pan, reach, elbow, wrist], position: [0, 0, 0, 0]}}
goal_constraints:
- position_constraints:
  - header: {frame_id: box}
    link_name: tip
    constraint_region:
      primitives: [{type: 2, dimensions: [0.01]}]
      primitive_poses: [{position: {x: 0.1, y: 0.0, z: 0.0}, orientation: {w: 1.0}}]
"""


def test_a_goal_may_be_relative_to_a_moving_frame(scene: to.Scene, tmp_path: Path) -> None:
    entry = "- {object: box, times: [0, 1], positions: [[2, 0, 0], [3, 0, 0]]}"
    moved = read_motions(written(tmp_path, entry), scene)
    asked = read_request(written(tmp_path, REQUEST, "request.yaml"), moved)
    (goal,) = asked.problem().goals
    assert isinstance(goal, FramePlacement)
    assert goal.reference == "box" and goal.placement.translation == pytest.approx((0.1, 0.0, 0.0))


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("object: box", "must hold one list"),
        ("- objekt: box", "unknown key 'objekt'; did you mean 'object'"),
        ("- {object: bx, appears: 1.0}", "no object named 'bx'; did you mean 'box'"),
        ("- {object: box, appears: 1.0}\n- {object: box, expires: 2.0}", "'box' has two entries"),
        ("- {object: box, times: [1.0, 0.0], positions: [[0, 0, 0], [1, 0, 0]]}", "must be two at least"),
        ("- {object: box, times: [0.0], positions: [[0, 0, 0], [1, 0, 0]]}", "has 1 times and 2 placements"),
        ("- {object: box, times: [0.0, .nan], positions: [[0, 0, 0], [1, 0, 0]]}", "must be finite"),
        ("- {object: box, until: 2.0}", "requires times and positions"),
        ("- {object: box, appears: 2.0, expires: 1.0}", "is not after it appears at 2 s"),
        ("- {object: box, carried_by: pst}", "no object named 'pst'; did you mean 'post'"),
        ("- {object: held, carried_by: box}", "'held' is carried by 'tip' already"),
        ("- {object: box, carried_by: box}", "cannot be placed in its own frame"),
        (
            "- {object: box, times: [0, 1], positions: [[0, 0, 0], [1, 0, 0]], carried_by: post}",
            "'box' has times of its own",
        ),
        ("- {object: held, times: [0, 1], positions: [[0, 0, 0], [1, 0, 0]]}", "is placed in 'tip'"),
        (
            "- {object: box, times: [0, 1], positions: [[0, 0, 0], [1, 0, 0]], orientations: [[0, 0, 0, 1]]}",
            "are 1, the positions are 2",
        ),
    ],
)
def test_error_for_an_invalid_motion_file_names_the_file(
    scene: to.Scene, tmp_path: Path, text: str, words: str
) -> None:
    with pytest.raises(FileFormatError, match=words.replace("[", r"\[")) as refused:
        read_motions(written(tmp_path, text), scene)
    assert "motions.yaml" in str(refused.value)
