"""docs/your-robot.md, block by block, against stand-ins for the arms."""

import json
import os
import shutil
import socket
import sys
import types
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
import yaml

import trajopt as to
from tests.files.export.stand_ins import Clock, Franka, MujocoArm, pylibfranka
from tests.files.export.urscript import Controller
from tests.pages import Page
from trajopt.planning import Plan
from trajopt.values.arrays import Floats

READY = [0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785]
ROS2 = """#!{python}
import sys, yaml, pathlib
assert sys.argv[1:3] == ["action", "send_goal"] and sys.argv[4].endswith("FollowJointTrajectory"), sys.argv
pathlib.Path("sent.yaml").write_text(yaml.safe_dump(yaml.safe_load(sys.argv[5])))
"""


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Page]:
    """The page after its plan; the arm whose URDF it reads is a UR5."""
    try:
        to.load("ur5")
    except to.MissingExtra as error:
        pytest.skip(str(error))
    from trajopt_robots._example_robot_data import share_folder

    folder = tmp_path_factory.mktemp("your_robot")
    urdf = "example-robot-data/robots/ur_description/urdf/ur5_robot.urdf"
    shutil.copy(share_folder() / urdf, folder / "my_arm.urdf")
    (folder / "bin").mkdir()
    for name, text in (
        ("ros2", ROS2.format(python=sys.executable)),
        ("trajopt", f'#!/bin/sh\nexec {sys.executable} -m trajopt "$@"\n'),
    ):
        (folder / "bin" / name).write_text(text)
        (folder / "bin" / name).chmod(0o755)
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("ROS_PACKAGE_PATH", str(share_folder()))
        patch.setenv("PATH", f"{folder / 'bin'}{os.pathsep}{os.environ['PATH']}")
        patch.chdir(folder)
        page = Page("your-robot.md", folder)
        page.run("From the URDF", "A plan from the measured state")
        yield page


def plan_of(page: Page) -> Plan:
    plan = page.names["plan"]
    assert isinstance(plan, Plan)
    return plan


def test_its_files_contain_the_plan_and_its_samples_keep_the_request(
    page: Page, capsys: pytest.CaptureFixture[str]
) -> None:
    page.run("To a controller")
    assert capsys.readouterr().out.splitlines()[-1] == "True"
    end = plan_of(page).trajectory.positions[-1].tolist()
    topic = json.loads((page.folder / "topic.json").read_text())
    assert topic["points"][-1]["positions"] == end
    last = (page.folder / "motion.csv").read_text().splitlines()[-1]
    assert [float(value) for value in last.split(",")[1:7]] == end


def test_ros_2_is_sent_the_goal(page: Page) -> None:
    page.run("To a controller", "A ROS 2 controller")
    sent = yaml.safe_load((page.folder / "sent.yaml").read_text())["trajectory"]
    trajectory = plan_of(page).trajectory
    assert sent["joint_names"] == list(trajectory.joint_names)
    stamps = [point["time_from_start"] for point in sent["points"]]
    times = np.array([stamp["sec"] + 1e-9 * stamp["nanosec"] for stamp in stamps])
    assert np.allclose(times, trajectory.times, rtol=0.0, atol=1e-9)
    rows = np.array([point["positions"] for point in sent["points"]])
    assert np.allclose(rows, trajectory(times), rtol=0.0, atol=1e-12)


def test_a_ur_executes_the_program(page: Page, monkeypatch: pytest.MonkeyPatch) -> None:
    here, there = socket.socketpair()
    here.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, 1 << 20)
    monkeypatch.setattr(socket, "create_connection", lambda address: here if address[1] == 30002 else None)
    page.run("A UR")
    with there, there.makefile() as received:
        program = received.read()
    trajectory = plan_of(page).trajectory
    arm = Controller(trajectory.positions[0])
    arm.run(program)
    assert arm.stopped and np.allclose(arm.joints, trajectory.positions[-1], atol=1e-8)
    for time, joints in arm.visited:
        assert np.allclose(joints, trajectory(time), atol=1e-8)


def test_a_franka_follows_though_packets_are_lost(page: Page, monkeypatch: pytest.MonkeyPatch) -> None:
    arm = Franka(READY)
    monkeypatch.setitem(sys.modules, "pylibfranka", pylibfranka(arm))
    page.run("A Franka")
    motion = page.names["motion"]
    assert isinstance(motion, to.Trajectory) and arm.finished
    assert arm.joints == pytest.approx(motion.positions[-1].tolist(), abs=1e-12)
    assert arm.joints[0] == pytest.approx(0.4, abs=1e-3)
    for time, joints in arm.visited:
        assert np.allclose(joints, motion(time), atol=1e-12)


def test_a_loop_at_100_hz_keeps_the_tool_within_a_millimetre_of_the_plan(
    page: Page, monkeypatch: pytest.MonkeyPatch
) -> None:
    plan = plan_of(page)
    arm = MujocoArm(plan.problem, plan.trajectory.positions[0])
    clock = types.ModuleType("time")
    clock.__dict__.update(monotonic=Clock(arm).monotonic, sleep=Clock(arm).sleep)
    monkeypatch.setitem(sys.modules, "time", clock)
    page.names["my_arm"] = arm
    page.run("Your own loop at 100 Hz")
    monkeypatch.undo()
    assert arm.data.time == pytest.approx(plan.trajectory.duration, abs=0.002)
    reduced = plan.problem.reduced

    def place(joints: Floats) -> Floats:
        return reduced.scene.placement_of("tool0", reduced.all_positions(joints)).translation

    strayed = [np.linalg.norm(place(q) - place(plan.trajectory(t))) for t, q in arm.visited]
    assert len(strayed) > 500 and max(strayed) < 0.001
    moved = [np.linalg.norm(place(q) - place(plan.trajectory.positions[0])) for _, q in arm.visited]
    assert max(moved) > 0.3

    away = MujocoArm(plan.problem, plan.trajectory.positions[0] + 0.02)
    follow = page.names["follow"]
    assert callable(follow)
    with pytest.raises(RuntimeError, match="not at the start"):
        follow(away, plan.trajectory.sampled(100))
    assert not away.visited


def test_every_section_is_run(page: Page) -> None:
    """Those of the tests above: a new one needs a stand-in and a test of its own."""
    text = Path(__file__).read_text()
    assert len(page.with_blocks) == 7 and all(f'"{name}"' in text for name in page.with_blocks)
