"""`trajopt view` without a file: planning by hand, and a robot elsewhere."""

import json
from pathlib import Path

import pytest

import trajopt as to
from tests.cli.process import trajopt
from tests.viewer.test_viewer import free_port
from trajopt.files.moveit import write_scene

pytest.importorskip("viser", reason="the extra `view` is not installed")
SHORT = ("--seconds", 0.1, "--port", 0, "--json")


def test_a_page_to_plan_by_hand_is_served() -> None:
    done = trajopt("view", "--robot", "planar2", *SHORT)
    assert done.returncode == 0 and json.loads(done.stdout)["url"].startswith("http://127.0.0.1:")


def test_view_takes_the_robot_state_from_the_scene(tmp_path: Path) -> None:
    robot = to.load("planar2")
    scene = to.Scene(robot).add("box", to.Box(0.1, 0.1, 0.1), to.placement((0.0, -1.5, 0.0)))
    write_scene(tmp_path / "scene.yaml", scene, robot.positions({"joint1": 0.3, "joint2": 0.2}))
    words = ("view", "--robot", "planar2", "--scene", tmp_path / "scene.yaml", *SHORT)
    assert trajopt(*words).returncode == 0
    done = trajopt(*words, "--state", "nowhere")
    assert done.returncode == 2 and "nowhere" in done.stderr


@pytest.mark.parametrize(
    ("words", "why"),
    [
        ((), "name a file to show"),
        (("--robot", "planar2", "--group", "arms"), "arms"),
        (("--robot", "planar2", "--request", "request.yaml"), "--request"),
        (("plan.json", "--group", "arm"), "--group"),
        (("--mirror", "http://127.0.0.1:1", "--robot", "planar2"), "--mirror"),
    ],
)
def test_conflicting_options_are_reported_in_one_line(words: tuple[str, ...], why: str) -> None:
    done = trajopt("view", *words, *SHORT)
    assert done.returncode == 2 and why in done.stderr


def test_an_unreachable_mirror_is_reported_in_one_line() -> None:
    address = f"http://127.0.0.1:{free_port()}"
    done = trajopt("view", "--mirror", address, *SHORT)
    assert done.returncode == 2 and f"unreachable: {address}: " in done.stderr
