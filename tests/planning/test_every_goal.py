"""All goals of a set, planned to and compared on request."""

import json
from pathlib import Path

import pytest

import trajopt as to
from tests.robots_for_tests import odd_arm
from tests.test_goal_sets import FAR, NEAR, START, problem, tip
from trajopt.planning import Stop
from trajopt.values.errors import ProblemError


@pytest.fixture
def arm(tmp_path: Path) -> to.Robot:
    return odd_arm(tmp_path)


def test_every_result_is_kept_and_the_shortest_is_the_plan(arm: to.Robot) -> None:
    asked = problem(to.Scene(arm))
    result = to.plan(asked, every_goal=True)
    assert list(result.of_each_goal) == ["near", "far"] and result.goal_name == "near"
    alone = {name: to.plan(each) for name, each in asked.alternatives.items()}
    for name, each in result.of_each_goal.items():
        assert each.goal_name == name and each.verified
        assert each.require().trajectory.duration == alone[name].require().trajectory.duration
    assert result.require().trajectory is result.of_each_goal["near"].require().trajectory
    for row in result.compared:
        plan = alone[row.name].require()
        assert row.status is to.Status.SOLVED and row.duration == plan.trajectory.duration
        assert row.path_length == plan.path.length and row.clearance == plan.certificate.clearance
    assert result.counts["attempts"] == 2


def test_it_is_printed_as_a_table(arm: to.Robot) -> None:
    scene = to.Scene(arm)
    scene = scene.add("block", to.Box(0.2, 0.2, 0.2), to.placement(tip(scene, NEAR)))
    result = to.plan(problem(scene), every_goal=True)
    head, first, second = (line.split() for line in str(result).splitlines()[-3:])
    assert head == ["goal", "duration", "[s]", "path", "length", "clearance", "[mm]", "status"]
    motion = result.require()
    assert first[:3] == ["far", f"{motion.trajectory.duration:.3f}", f"{motion.path.length:.3f}"]
    assert first[-1] == "SOLVED" and float(first[3]) > 0.0
    assert second == ["near", "-", "-", "-", "GOAL_IN_COLLISION"]
    told = json.loads(json.dumps(result.as_dict()))["goals"]
    assert [row["name"] for row in told] == ["far", "near"]
    assert told[0]["duration"] == motion.trajectory.duration and told[1]["duration"] is None


def test_it_is_off_by_default(arm: to.Robot) -> None:
    result = to.plan(problem(to.Scene(arm)))
    assert result.of_each_goal == {} and result.compared == () and "path length" not in str(result)
    assert result.as_dict()["goals"] == []


def test_without_a_reached_goal_the_reason_of_each_is_reported(arm: to.Robot) -> None:
    scene = to.Scene(arm)
    for name, where in (("one", NEAR), ("other", FAR)):
        scene = scene.add(name, to.Box(0.2, 0.2, 0.2), to.placement(tip(scene, where)))
    result = to.plan(problem(scene), every_goal=True)
    assert result.status is to.Status.GOAL_IN_COLLISION
    assert "near: GOAL_IN_COLLISION" in result.message and "far: GOAL_IN_COLLISION" in result.message
    assert set(result.of_each_goal) == set(result.alternatives) == {"near", "far"}
    assert result.explain().reason == result.reason


def test_a_budget_is_shared_out(arm: to.Robot) -> None:
    scene = to.Scene(arm)
    free = to.plan(problem(scene), every_goal=True)
    work = free.counts["forward_kinematics"]
    bounded = to.plan(problem(scene), every_goal=True, budget=to.Budget(work=2 * work, improve=True))
    assert bounded.counts["forward_kinematics"] <= 2 * work + 1000
    assert all(each.attempts for each in bounded.of_each_goal.values())
    tiny = to.plan(problem(scene), every_goal=True, budget=to.Budget(work=1))
    assert {each.status for each in tiny.of_each_goal.values()} == {to.Status.OUT_OF_WORK}


def test_each_better_motion_is_reported_once(arm: to.Robot) -> None:
    told: list[to.Result] = []
    result = to.plan(problem(to.Scene(arm)), every_goal=True, on_incumbent=told.append)
    assert [each.goal_name for each in told] == ["far", "near"]
    assert [each.cost for each in told] == sorted((each.cost for each in told), reverse=True)
    assert told[-1].cost == result.cost


def test_an_interruption_keeps_finished_plans(arm: to.Robot) -> None:
    def interrupt(stage: str, step: object) -> None:
        seen.append(stage)
        if seen.count("verify") == 1 and stage == "examine":
            raise KeyboardInterrupt

    seen: list[str] = []
    result = to.plan(problem(to.Scene(arm)), every_goal=True, progress=interrupt)
    assert result.verified and result.goal_name == "far"
    assert result.of_each_goal["near"].status is to.Status.CANCELLED
    assert result.of_each_goal["near"].stopped is Stop.CANCEL


def test_a_single_goal_is_refused(arm: to.Robot) -> None:
    alone = to.Problem(scene=to.Scene(arm), start=START, goal=to.joint_positions(NEAR))
    with pytest.raises(ProblemError, match="any_of"):
        to.plan(alone, every_goal=True)
    with pytest.raises(ProblemError, match="every_goal"):
        to.plan(problem(to.Scene(arm)), every_goal="yes")  # pyright: ignore[reportArgumentType]
