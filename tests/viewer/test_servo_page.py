"""The browser leads a robot: a button held by a mouse, sliders, a gizmo; and what was said is said again."""

import sys
import threading
import time
from collections.abc import Iterator
from dataclasses import replace
from types import SimpleNamespace
from typing import TYPE_CHECKING

import numpy as np
import pytest

import trajopt as to
from tests.viewer.test_page import CHROMIUM, FLAGS, PATIENCE, until
from trajopt.driving import (
    IdealExecutor,
    JointVelocities,
    Order,
    Player,
    Pose,
    Recorder,
    Servo,
    ServoOptions,
    Twist,
    guide,
)
from trajopt.viewer import ServoPage, servo_page

from .conftest import Motion
from .test_viewer import free_port

if TYPE_CHECKING:
    from playwright.sync_api import Page

OPTIONS = ServoOptions(period=0.01, scaling=0.2)


@pytest.fixture
def problem(motion: Motion) -> to.Problem:
    scene = to.Scene(motion.reduced.scene.robot)
    start = {"slide": 0.12, "turn": -0.8, "wrist": 0.0}
    return to.Problem(scene=scene, start=start, goal=start)


@pytest.fixture
def opened(problem: to.Problem) -> Iterator[ServoPage]:
    pytest.importorskip("viser", reason="the extra `view` is not installed")
    page = servo_page(problem, port=free_port())
    yield page
    page.close()


def said(page: ServoPage) -> Order:
    order = page.read(0.0)
    assert order is not None
    return order


def test_nothing_is_commanded_unless_the_button_is_held(
    opened: ServoPage, monkeypatch: pytest.MonkeyPatch
) -> None:
    times = [10.0]
    clock = SimpleNamespace(monotonic=lambda: times[-1])
    monkeypatch.setattr(sys.modules[ServoPage.__module__], "time", clock)
    opened._twist[1].value = 0.5
    assert said(opened).command is None and said(opened).released == "the button was let go"
    opened._hold(None)
    twist = said(opened).command
    assert isinstance(twist, Twist) and twist.linear.tolist() == [0.0, 0.5, 0.0]
    times.append(10.25)
    assert said(opened).released, "the line to the page is gone"


def test_each_control_gives_its_command(opened: ServoPage) -> None:
    opened._hold(None)
    assert said(opened).speed is None
    opened._speeds.value = 0.4
    assert [said(opened).speed for _ in range(2)] == [0.4, None]
    opened._lead.value = "joints"
    assert [each.visible for each in opened._twist] == [False] * 6
    opened._joints["turn"].value = -0.3
    opened._hold(None)
    joints = said(opened).command
    assert isinstance(joints, JointVelocities)
    assert joints.velocities == {"slide": 0.0, "turn": -0.3, "wrist": 0.0}
    opened._lead.value = "gizmo"
    where = to.placement((0.1, 0.4, 0.3), rpy=(0.1, 0.2, 0.3))
    opened.move_gizmo(where)
    opened._hold(None)
    pose = said(opened).command
    assert isinstance(pose, Pose) and opened._gizmo.visible
    np.testing.assert_allclose(pose.target.homogeneous, where.homogeneous, atol=1e-12)


def test_the_gizmo_begins_at_the_tool(opened: ServoPage, problem: to.Problem) -> None:
    arm = IdealExecutor(problem.reduced.joint_names, problem.reduced.start_positions)
    servo = Servo(arm, problem, OPTIONS)
    there = problem.scene.placement_of(servo.frame, problem.start_positions)
    np.testing.assert_allclose(opened._gizmo.position, there.translation)
    servo.tick()
    opened.look(servo)
    opened.move_gizmo(to.placement((0.0, 0.0, 0.0)))
    opened._lead.value = "gizmo"
    until(lambda: bool(np.allclose(opened._gizmo.position, there.translation)), "it stayed away")


def held(page: "Page", name: str) -> None:
    """Press the mouse on a button, and keep it down."""
    box = page.get_by_role("button", name=name).bounding_box()
    assert box is not None
    page.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    page.mouse.down()


def test_a_mouse_leads_the_robot_and_its_recording_repeats_the_motion(
    opened: ServoPage, problem: to.Problem
) -> None:
    api = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    if not CHROMIUM.is_file():
        pytest.skip(f"no browser at {CHROMIUM}")
    rows: list[np.ndarray] = []
    # Where a page draws without a graphics card its signals come late, and count for longer.
    options = replace(OPTIONS, timeout=0.5)
    arm = IdealExecutor(problem.reduced.joint_names, problem.reduced.start_positions)
    servo, recorder = Servo(arm, problem, options), Recorder(opened)

    def wait(seconds: float) -> None:
        arm.advance(seconds)
        time.sleep(seconds)

    def each(watched: Servo) -> None:
        rows.append(arm.committed(arm.now()))
        opened.look(watched)

    opened._lead.value = "joints"
    opened._joints["turn"].value = 1.0
    loop = threading.Thread(
        target=guide, args=(servo, recorder, wait), kwargs={"each": each, "longest": 300.0}
    )
    loop.start()
    try:
        with api.sync_playwright() as playwright:
            browser = playwright.chromium.launch(executable_path=CHROMIUM, args=list(FLAGS))
            page = browser.new_page(viewport={"width": 640, "height": 640})
            page.set_default_timeout(1000.0 * PATIENCE)
            page.goto(opened.url)
            page.get_by_text("Events").wait_for()
            start = problem.reduced.start_positions
            held(page, "Drive")
            until(lambda: rows[-1][0, 1] > start[1] + 0.1, "the button moved nothing")
            page.mouse.up()
            # A row is written before the servo's state changes: wait until the last one is at rest, too.
            until(lambda: not servo.moving and not rows[-1][1:].any(), "letting go stopped nothing")
            rest = rows[-1][0].copy()
            time.sleep(0.5)
            assert np.array_equal(rows[-1][0], rest)
            page.get_by_text("the button was let go").first.wait_for()
            browser.close()
    finally:
        opened.close()
        loop.join()
    assert recorder.done
    fresh = IdealExecutor(problem.reduced.joint_names, problem.reduced.start_positions)
    again: list[np.ndarray] = []
    guide(
        Servo(fresh, problem, options),
        Player(recorder.stream),
        fresh.advance,
        each=lambda _: again.append(fresh.committed(fresh.now())),
    )
    count = min(len(rows), len(again))
    assert count > 50 and np.array_equal(np.array(again[:count]), np.array(rows[:count]))
