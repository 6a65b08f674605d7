"""The live page with an arm that can be driven: objects put up beside it, the motion executed; no browser."""

from collections.abc import Iterator

import numpy as np
import pytest

import trajopt as to
from tests.viewer.test_live_page import PATIENCE, drag, lifted, plan
from tests.viewer.test_page import until
from trajopt.viewer import LiveView, live_view
from trajopt.viewer.live.workbench import Reachability

from .test_viewer import free_port

BELOW = np.array((0.0, 0.0, -0.06))


@pytest.fixture
def live() -> Iterator[LiveView]:
    pytest.importorskip("viser", reason="the extra `view` is not installed")
    scene = to.Scene(to.load("panda")).add("table", to.Box(0.9, 1.4, 0.04), to.placement((0.65, 0, -0.02)))
    opened = live_view(scene, port=free_port())
    yield opened
    opened.close()


def put_up(live: LiveView) -> str:
    live._objects._press_add(None)
    assert live.settle(PATIENCE)
    return live._objects.chosen


def test_an_object_is_put_up_chosen_dragged_and_removed(live: LiveView) -> None:
    name = put_up(live)
    panel = live._objects
    assert name == "box" and name in live._bench.scene.objects and panel._about.visible
    assert panel._names.options == ("none", "table", "box") and panel._names.value == "box"
    assert [size.label for size in panel._sizes] == ["x [mm]", "y [mm]", "z [mm]"]
    there = to.placement((0.4, 0.3, 0.2))
    live._displace(there)
    assert live.settle(PATIENCE)
    np.testing.assert_allclose(live._bench.placement_of(name).homogeneous, there.homogeneous, atol=1e-9)
    assert panel._where.value == (400.0, 300.0, 200.0)
    drawn = live._picture._scene._objects._drawn[name].frame
    np.testing.assert_allclose(drawn.position, (0.4, 0.3, 0.2), atol=1e-9)
    panel._press_remove(None)
    assert live.settle(PATIENCE)
    assert name not in live._bench.scene.objects and not panel._about.visible


def test_an_object_at_the_goal_makes_it_collide(live: LiveView) -> None:
    drag(live, lifted(live))
    plan(live)
    put_up(live)
    live._displace(to.placement(live.goal.placement.translation))
    assert live.settle(PATIENCE)
    assert live.goal.reachability is Reachability.COLLIDING and "box" in live._goal_text.content
    assert live.planned is None and "in collision" in live._motion._plan.refusal


def test_an_attached_object_moves_with_the_robot(live: LiveView) -> None:
    name = put_up(live)
    live._displace(to.placement(live._bench.placement_of(live._bench.hand).translation + BELOW))
    assert live.settle(PATIENCE)
    live._objects._press_grasp(None)
    assert live.settle(PATIENCE)
    assert live._objects._where.disabled and live._objects._put.refusal == ""
    drag(live, lifted(live))
    plan(live)
    live._motion.playback.show(99.0)
    assert live.settle(PATIENCE)
    drawn = live._picture._scene._objects._drawn[name].frame
    hand = live.goal.placement.translation
    np.testing.assert_allclose(drawn.position, hand + BELOW, atol=2e-3)


def test_the_motion_is_executed_and_the_robot_rests_at_its_end(live: LiveView) -> None:
    assert live._drive._execute.refusal == "there is no motion yet"
    drag(live, lifted(live))
    plan(live)
    goal = live.goal.positions
    assert live._drive._execute.refusal == ""
    live._drive._press(None)
    assert live.settle(PATIENCE)
    assert live._motion._plan.refusal == "the robot is being driven"
    until(lambda: not live._bench.held, "it never arrived")
    assert live.settle(PATIENCE)
    assert "The goal was reached" in live._drive._text.content
    np.testing.assert_allclose(live._bench.positions, live.positions)
    assert live._bench.at_goal or np.abs(live._bench.positions - goal).max() < 1e-2
    assert "the robot is at its goal" in live._motion._plan.refusal


def test_it_is_stopped_on_the_page(live: LiveView) -> None:
    live._ask_goal("goal", lambda: live._bench.move_joint("panda_joint1", 2.0))
    assert live.settle(PATIENCE)
    plan(live)
    live._drive._press(None)
    until(lambda: live.positions[0] > 0.05, "it never moved")
    live._drive._press_stop(None)
    until(lambda: not live._bench.held, "it never stood")
    assert live.settle(PATIENCE)
    assert "Stopped" in live._drive._text.content and live._bench.positions[0] < 1.9
    assert not live._motion._plan.refusal, "the goal is still to be reached"


def test_the_reach_of_the_hand_is_shown_and_hidden(live: LiveView) -> None:
    live._shown._ticks["reach"].value = True
    until(lambda: live._picture._reach.visible, "it was never found")
    assert live.settle(PATIENCE) and "m³ without a collision" in live._shown._text.content
    points = live._picture._reach.points
    assert len(points) > 500 and np.linalg.norm(points, axis=1).max() < 1.5
    hand = live._bench.placement_of(live._bench.hand).translation
    assert np.linalg.norm(points - hand, axis=1).min() < 0.1, "the hand gets to where it is"
    live._shown._ticks["reach"].value = False
    until(lambda: not live._picture._reach.visible, "it stayed")
