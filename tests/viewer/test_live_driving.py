"""The simulated robot driven from the page: to the goal, stopped, and what is put up on the way is seen."""

import threading

import numpy as np
import pytest

import trajopt as to
from tests.viewer.conftest import Motion
from trajopt.viewer.live.panels import Driving

PATIENCE = 120.0


@pytest.fixture(scope="module")
def problem() -> to.Problem:
    scene = to.Scene(to.load("panda"))
    goal = {**scene.robot.state("ready"), "panda_joint1": 1.0}
    return to.Problem(scene=scene, group="panda_arm", start="ready", goal=goal)


def ended(driving: Driving, over: threading.Event) -> str:
    assert over.wait(PATIENCE), driving.events
    driving.close()
    return driving.outcome


def test_the_goal_is_reached(problem: to.Problem) -> None:
    over, places = threading.Event(), list[float]()

    def hear(driving: Driving) -> None:
        places.append(float(driving.positions[0]))
        if not driving.busy:
            over.set()

    driving = Driving(problem, hear)
    assert "The goal was reached" in ended(driving, over) and "nothing was touched" in driving.outcome
    assert driving.positions[0] == pytest.approx(1.0, abs=1e-6)
    assert len(places) > 20 and np.ptp(places) > 0.9, "it was seen on its way"


def test_it_is_stopped_on_its_way(problem: to.Problem) -> None:
    over = threading.Event()

    def hear(driving: Driving) -> None:
        if driving.busy and driving.positions[0] > 0.1:
            driving.stop()
        if not driving.busy:
            over.set()

    driving = Driving(problem, hear)
    assert "Stopped" in ended(driving, over)
    assert 0.1 < driving.positions[0] < 0.9


def test_an_object_added_on_the_way_is_not_touched(problem: to.Problem) -> None:
    over, put = threading.Event(), threading.Event()
    wall = problem.scene.add("wall", to.Box(0.6, 0.02, 1.6), to.placement((0.4, 0.38, 0.5)))

    def hear(driving: Driving) -> None:
        if driving.busy and not put.is_set():
            put.set()
            driving.see(wall)
        if not driving.busy:
            over.set()

    driving = Driving(problem, hear)
    outcome = ended(driving, over)
    assert "touched:" not in outcome and ("blocked" in outcome or "reached" in outcome)


def test_drives_a_robot_without_masses(motion: Motion) -> None:
    over, start = threading.Event(), {"slide": 0.12, "turn": -0.8, "wrist": 0.0}
    scene = to.Scene(motion.reduced.scene.robot)
    problem = to.Problem(scene=scene, start=start, goal={**start, "slide": 0.2})
    driving = Driving(problem, lambda each: None if each.busy else over.set())
    assert "The goal was reached" in ended(driving, over)
