"""`trajopt servo`: a stream leads the simulated robot, and what was said can be said again."""

import json
from pathlib import Path

from tests.cli.test_commands import SCENE, common, folder, trajopt

__all__ = ["folder"]

STREAM = """
format: trajopt servo stream
version: 1
orders:
  - {at: 0.0, until: 0.5, joints: {pan: 0.3}}
  - {at: 0.51, released: that will do}
"""


STATE = """
robot_state: {joint_state: {name: [pan, reach, elbow, wrist], position: [-1.0, 0.1, 0.3, 0]}}
"""


def about_to_be_led(folder: Path, tmp_path: Path) -> list[object]:
    scene = tmp_path / "scene.yaml"
    scene.write_text(SCENE + STATE)
    return ["--robot", folder / "odd.urdf", "--scene", scene]


def test_a_stream_leads_the_robot_and_is_recorded(folder: Path, tmp_path: Path) -> None:
    said, record = tmp_path / "said.yaml", tmp_path / "again.json"
    said.write_text(STREAM)
    about = about_to_be_led(folder, tmp_path)
    done = trajopt("servo", *about, "--input", said, "--record", record, "--json")
    assert done.returncode == 0, done.stderr
    told = json.loads(done.stdout)
    assert told["contacts"] == [] and told["duration"] > 0.5
    assert [(event["kind"], event["words"]) for event in told["events"]] == [("stopping", "that will do")]
    again = trajopt("servo", *about, "--input", record, "--json")
    assert json.loads(again.stdout) == told


def test_an_invalid_input_is_refused(folder: Path) -> None:
    done = trajopt("servo", *common(folder)[:4], "--input", "gamepat")
    assert done.returncode == 2 and "--input is gamepad, browser or a file" in done.stderr


def test_axes_of_an_unknown_frame_are_refused_at_the_start(folder: Path, tmp_path: Path) -> None:
    about = about_to_be_led(folder, tmp_path)
    done = trajopt("servo", *about, "--axes", "tpi", "--port", 0, "--seconds", 0.1)
    assert done.returncode == 2 and "no frame named 'tpi'" in done.stderr
