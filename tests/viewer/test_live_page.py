"""The live page, without a browser and in a real one: the gizmo dragged, a motion planned, scrubbed."""

import time
from collections.abc import Iterator
from itertools import cycle
from typing import TYPE_CHECKING

import numpy as np
import pytest

import trajopt as to
from tests.viewer.test_page import CHROMIUM, FLAGS, PATIENCE, until
from trajopt.values.arrays import Floats
from trajopt.values.errors import ProblemError
from trajopt.viewer import LiveView, live_view
from trajopt.viewer.live.workbench import Reachability

from .conftest import Motion
from .test_viewer import free_port

if TYPE_CHECKING:
    from playwright.sync_api import Page

START = {"slide": 0.12, "turn": -0.8, "wrist": 0.0}


@pytest.fixture
def live(motion: Motion) -> Iterator[LiveView]:
    pytest.importorskip("viser", reason="the extra `view` is not installed")
    scene = to.Scene(motion.reduced.scene.robot).add(
        "post", to.Cylinder(0.04, 0.6), to.placement((0.3, 0.45, 0.3))
    )
    opened = live_view(scene, start=START, port=free_port())
    yield opened
    opened.close()


def lifted(live: LiveView, by: float = 0.1) -> to.Placement:
    """A place over where the hand is."""
    now = live._bench.placement_of(live._bench.hand)
    return to.placement(now.translation + np.array((0.0, 0.0, by)), quaternion=now.quaternion)


def drag(live: LiveView, where: to.Placement) -> None:
    live._drag(where)
    assert live.settle(PATIENCE)


def plan(live: LiveView) -> None:
    live._motion._press(None)
    until(lambda: live.planned is not None, "planning never ended")
    assert live.settle(PATIENCE)


def test_dragging_the_hand_requests_a_goal(live: LiveView) -> None:
    assert live._motion._plan.refusal, "the robot is there already"
    drag(live, lifted(live))
    assert live.goal.reachability is Reachability.REACHABLE and not live._motion._plan.refusal
    np.testing.assert_allclose(live.goal.positions[:2], (0.22, -0.8), atol=1e-3)
    assert "The goal is reachable" in live._goal_text.content
    drag(live, lifted(live, 2.0))
    assert "slide at 2.12 m" in live._goal_text.content and "limits" in live._motion._plan.refusal


def test_a_motion_is_planned_shown_and_dropped_when_the_goal_moves(live: LiveView) -> None:
    drag(live, lifted(live))
    plan(live)
    assert live.planned is not None and live.planned.result is not None and live.planned.result.verified
    playback = live._motion.playback
    playback.show(99.0)
    assert live.settle(PATIENCE)
    np.testing.assert_allclose(live.positions, live.goal.positions, atol=1e-12)
    playback.show(0.0)
    assert live.settle(PATIENCE)
    np.testing.assert_allclose(live.positions, live._bench.positions, atol=1e-9)
    assert live._motion._folder.visible
    drag(live, lifted(live, 0.15))
    assert live.planned is None and not live._motion._folder.visible and live.time == 0.0


def test_a_motion_to_an_earlier_goal_is_not_shown(live: LiveView) -> None:
    drag(live, lifted(live))
    live._motion._press(None)
    drag(live, lifted(live, 0.15))
    for planning in live._motion._ending:
        planning.close()
    assert live.settle(PATIENCE) and live.planned is None and live._motion.motion is None


def test_a_fault_of_a_callback_is_reported_on_the_page(live: LiveView) -> None:
    def refuse() -> None:
        raise ProblemError("it is <odd>")

    live._ask_goal("odd", refuse)
    assert live.settle(PATIENCE) and "it is &lt;odd&gt;" in live._motion._text.content


def test_things_that_move_by_themselves_are_refused(motion: Motion) -> None:
    track = to.Track.constant_velocity(to.placement((1.0, 0.0, 0.0)), velocity=(0.1, 0.0, 0.0))
    scene = to.Scene(motion.reduced.scene.robot).add("cart", to.Box(0.1, 0.1, 0.1), motion=track)
    with pytest.raises(ProblemError, match="move by themselves"):
        live_view(scene)


def opened_in(playwright: object, live: LiveView, size: tuple[int, int]) -> "Page":
    browser = playwright.chromium.launch(executable_path=CHROMIUM, args=list(FLAGS))  # pyright: ignore
    page: Page = browser.new_page(viewport={"width": size[0], "height": size[1]})
    page.set_default_timeout(1000.0 * PATIENCE)
    page.goto(live.url)
    page.get_by_text("The goal is the present configuration").wait_for()
    # A browser without a graphics card says so, over the scene.
    page.locator(".mantine-Notification-closeButton").click()
    return page


def on_screen(live: LiveView, point: Floats, size: tuple[int, int]) -> tuple[float, float]:
    """Where a point of the world is in the page [pixels], by the browser's camera."""
    (client,) = live._server.get_clients().values()
    camera = client.camera
    w, x, y, z = camera.wxyz
    turned = to.placement(camera.position, quaternion=(x, y, z, w))
    right, down, ahead = turned.inverse() * point
    focal = size[1] / 2.0 / np.tan(camera.fov / 2.0)
    return size[0] / 2.0 + focal * right / ahead, size[1] / 2.0 + focal * down / ahead


def drag_upwards(page: "Page", live: LiveView, size: tuple[int, int], pixels: float) -> None:
    """Pull the arrow of the gizmo that is vertical up on the screen, until the goal has moved."""
    gizmo = live._picture._goal.gizmo
    until(lambda: len(live._server.get_clients()) == 1, "no browser")
    begin = live.goal.placement.translation[2]
    deadline = time.monotonic() + PATIENCE
    grips = cycle((0.85, 0.7, 0.95))  # a ring may be before the arrow, or the arrow before something else
    while live.goal.placement.translation[2] == begin:
        assert time.monotonic() < deadline, "the gizmo never moved"
        where = live.goal.placement
        vertical = max(range(3), key=lambda axis: abs(where.rotation[2, axis]))
        grip = next(grips) * gizmo.length * where.rotation[:, vertical]
        x, y = on_screen(live, where.translation + grip, size)
        page.mouse.move(x, y)
        page.wait_for_timeout(500)  # it is lit up when it is drawn next
        page.mouse.down()
        for step in range(1, 9):
            page.mouse.move(x, y - pixels * step / 8.0)
            page.wait_for_timeout(100)
        page.mouse.up()
        page.wait_for_timeout(300)
    await_rest(live)


def await_rest(live: LiveView) -> None:
    """Wait for the last move of a drag: a busy browser sends it long after the button is up."""
    deadline = time.monotonic() + PATIENCE
    before = None
    while before is None or not np.array_equal(before, live.goal.placement.translation):
        assert time.monotonic() < deadline, "the goal never came to rest"
        before = np.array(live.goal.placement.translation)
        time.sleep(2.0)
    assert live.settle(PATIENCE)


def drive_through(live: LiveView, size: tuple[int, int], pixels: float) -> None:
    """Drag the gizmo, plan, and scrub, all with mouse and keyboard."""
    api = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    if not CHROMIUM.is_file():
        pytest.skip(f"no browser at {CHROMIUM}")
    with api.sync_playwright() as playwright:
        page = opened_in(playwright, live, size)
        height = live.goal.placement.translation[2]
        drag_upwards(page, live, size, pixels)
        assert live.goal.placement.translation[2] > height + 0.01, "it was pulled up"
        assert live.goal.reachability is Reachability.REACHABLE, live.goal.words
        page.get_by_text("The goal is reachable").wait_for()
        page.get_by_role("button", name="Plan", exact=True).click()
        page.get_by_text("Free of collisions").wait_for()
        assert live.planned is not None and live.planned.result is not None
        # Before it is drawn the first slider is a joint's, which ends the plan.
        page.get_by_text("time [s]").wait_for()
        slider = page.get_by_role("slider").first
        slider.focus()
        page.keyboard.press("End")
        until(lambda: live.time == live.planned.result.cost, "the slider's time never arrived")  # pyright: ignore
        until(lambda: np.allclose(live.positions, live.goal.positions, atol=1e-2), "the robot stayed")
        page.context.browser.close()  # pyright: ignore


def test_in_a_browser_the_hand_is_dragged_planned_for_and_scrubbed(live: LiveView) -> None:
    drive_through(live, (1000, 600), 40.0)


@pytest.mark.slow
def test_in_a_browser_seven_joints_among_things() -> None:
    pytest.importorskip("viser", reason="the extra `view` is not installed")
    scene = to.Scene(to.load("panda")).add("table", to.Box(0.9, 1.4, 0.04), to.placement((0.65, 0.0, -0.02)))
    opened = live_view(scene, port=free_port())
    try:
        drive_through(opened, (1280, 800), 60.0)
    finally:
        opened.close()


def test_a_gizmo_is_where_the_goal_is(live: LiveView) -> None:
    live._ask_goal("goal", lambda: live._bench.move_joint("slide", 0.25))
    assert live.settle(PATIENCE)
    gizmo = live._picture._goal.gizmo
    np.testing.assert_allclose(gizmo.placement.homogeneous, live.goal.placement.homogeneous, atol=1e-9)
