"""Goals of which any one will do: the nearest first, another where that is blocked, and the name of it."""

from pathlib import Path

import numpy as np
import pytest

import trajopt as to
from tests.robots_for_tests import odd_arm
from trajopt.values.errors import ProblemError

START = {"pan": 0.0, "reach": 0.1, "elbow": 0.3, "wrist": 0.0}
NEAR, FAR = {**START, "pan": 0.7}, {**START, "pan": -1.4}


@pytest.fixture
def arm(tmp_path: Path) -> to.Robot:
    return odd_arm(tmp_path)


def problem(scene: to.Scene) -> to.Problem:
    goals = {"far": to.joint_positions(FAR), "near": to.joint_positions(NEAR)}
    return to.Problem(scene=scene, start=START, goal=to.any_of(goals))


def tip(scene: to.Scene, positions: dict[str, float]) -> np.ndarray:
    return scene.placement_of("tip", scene.robot.positions(positions)).translation


def test_the_nearest_is_reached_and_named(arm: to.Robot) -> None:
    result = to.plan(problem(to.Scene(arm)))
    plan = result.require()
    assert result.goal_name == "near"
    assert "at the goal 'near'" in result.reason
    assert plan.trajectory(plan.trajectory.duration)[0] == pytest.approx(0.7, abs=1e-3)
    assert result.problem.goals == result.problem.goals != ()


def test_another_goal_is_reached_if_the_nearest_is_blocked(arm: to.Robot) -> None:
    scene = to.Scene(arm)
    scene = scene.add("block", to.Box(0.2, 0.2, 0.2), to.placement(tip(scene, NEAR)))
    result = to.plan(problem(scene))
    assert result.verified and result.goal_name == "far"


def test_unreachable_goals_are_each_reported_with_a_reason(arm: to.Robot) -> None:
    scene = to.Scene(arm)
    for name, where in (("one", NEAR), ("other", FAR)):
        scene = scene.add(name, to.Box(0.2, 0.2, 0.2), to.placement(tip(scene, where)))
    result = to.plan(problem(scene))
    assert result.status is to.Status.GOAL_IN_COLLISION
    assert "near: GOAL_IN_COLLISION" in result.message and "far: GOAL_IN_COLLISION" in result.message
    assert "one" in result.message and "other" in result.message


def test_counts_and_cpu_time_include_all_goals(arm: to.Robot) -> None:
    scene = to.Scene(arm)
    scene = scene.add("block", to.Box(0.2, 0.2, 0.2), to.placement(tip(scene, NEAR)))
    result = to.plan(problem(scene))
    assert result.counts["attempts"] >= 1
    assert set(result.cpu_seconds) >= {"examine", "optimise", "retime", "verify"}


def test_invalid_goal_sets_are_refused(arm: to.Robot) -> None:
    with pytest.raises(ProblemError, match="at least one goal"):
        to.any_of({})
    with pytest.raises(ProblemError, match="goal 'odd' requires nothing"):
        to.any_of({"odd": ()})
    with pytest.raises(ProblemError, match="any of far, near"):
        _ = problem(to.Scene(arm)).goals
    assert "any of far, near" in str(problem(to.Scene(arm)))
    unknown = to.any_of({"one": to.frame_placement("tipp", to.placement())})
    with pytest.raises(to.TrajoptError, match="tipp"):
        to.Problem(scene=to.Scene(arm), start=START, goal=unknown)
