"""Remedies: each was planned and solves it, half of it was planned and does not."""

from dataclasses import replace

import numpy as np
import pytest

import trajopt as to
from tests.why.conftest import GOAL, START, tip_at
from trajopt.planning.judgement import judge
from trajopt.planning.result import Status
from trajopt.why import ProblemChange, Remedy
from trajopt.why.change import moved_object, smaller_clearance, smallest_changes
from trajopt.why.explain import candidates, longer


def remedied(problem: to.Problem) -> dict[str, Remedy]:
    """Explain with planning again; check every remedy by a judge of its own."""
    result = to.plan(problem)
    assert not result.verified
    found = result.explain(plan_again=True).remedies
    assert found is not None
    for remedy in found:
        plan = to.plan(remedy.problem).require()
        assert judge(remedy.problem, plan.trajectory).verified
        assert not remedy.half.verified
    return {remedy.what: remedy for remedy in found}


def test_a_start_is_moved_or_its_obstacle(pillar: to.Scene) -> None:
    found = remedied(to.Problem(scene=pillar, start={**START, "pan": 0.05}, goal=to.joint_positions(GOAL)))
    assert "start" in found and "place of pillar" in found
    start = found["start"].problem.start_positions
    assert start[0] > 0.05 and found["start"].amount < 0.3


def test_an_obstacle_of_two_links_is_moved_each_way_once() -> None:
    """A wall met by two links was moved the same way twice."""
    wall = to.Scene(to.load("ur5")).add("wall", to.Box(0.1, 1.0, 0.8), to.placement((0.55, 0.0, 0.4)))
    bent = {"shoulder_lift_joint": -1.57, "elbow_joint": 1.57, "wrist_1_joint": -1.57, "wrist_2_joint": -1.57}
    explained = to.plan(to.Problem(scene=wall, group="manipulator", start=bent, goal="home")).explain()
    assert len(explained.blocks) == 2
    assert [change.what for change in candidates(explained)].count("place of wall") == 1


def test_a_goal_beyond_a_limit_is_moved_to_it(arm: to.Robot) -> None:
    problem = to.Problem(scene=to.Scene(arm), start=START, goal=to.joint_positions({**GOAL, "elbow": 2.6}))
    moved = remedied(problem)["goal"]
    assert moved.amount == pytest.approx(0.1, rel=0.1) and "elbow by -5.7" in moved.words


def test_a_region_is_widened_or_the_goal_moved_into_it(arm: to.Robot) -> None:
    scene = to.Scene(arm)
    here = to.placement(scene.placement_of("tip", arm.positions(START)).translation)
    inside = to.position_in_region("tip", to.Sphere(0.1), here)
    goal = tip_at(scene, {**START, "pan": -0.8})
    found = remedied(to.Problem(scene=scene, start=START, goal=goal, constraints=[inside]))
    assert {"place of tip", "region of tip grown on every side"} & found.keys()
    for remedy in found.values():
        assert 0.01 < remedy.amount < 0.2


def test_the_words_of_a_move_lead_to_the_place_planned_for(pillar: to.Scene) -> None:
    """The direction was printed rounded, but the object moved as it was: 1 mm aside over 0.2 m."""
    problem = to.Problem(scene=pillar, start=START, goal=to.joint_positions(GOAL))
    change = moved_object(problem, "pillar", np.array((0.2, 0.456, -0.4)), 0.2)
    printed = np.array([float(item) for item in change.words(0.2).split("(")[1].rstrip(")").split(",")])
    before, after = (p.scene.object("pillar").placement.translation for p in (problem, change.apply(0.2)))
    np.testing.assert_allclose(after - before, 0.2 * printed / np.linalg.norm(printed), atol=1e-12)


def test_the_words_of_a_change_have_all_its_digits(pillar: to.Scene) -> None:
    """2.752 s and 331.2 Nm were printed as 2.75 s and 331 Nm, which are too little."""
    problem = to.Problem(scene=pillar, start=START, goal=to.joint_positions(GOAL), finish_by=2.7012)
    assert longer(problem, 2.7012).words(0.051) == "allow 0.051 s more, until 2.7522 s"
    tilt = to.axis_alignment("tip", tolerance=1.2).relaxations[0]
    assert float(tilt.words(0.011).split(" to ")[1].split()[0]) == pytest.approx(np.rad2deg(1.211), abs=1e-4)
    near = pillar.with_clearance(0.0331, "pillar", "tip")
    change = smaller_clearance(replace(problem, scene=near), "pillar", "tip", 0.001)
    assert change is not None and change.words(0.0012).endswith("from 33.1 to 31.9 mm")


def test_a_waypoint_that_gives_way_is_named(arm: to.Robot) -> None:
    """Its remedies were said to move the goal, and the reason numbered it."""
    scene = to.Scene(arm)
    tip = scene.placement_of("tip", arm.positions(GOAL)).translation
    via = to.frame_placement("tip", to.placement(1.5 * tip), rotation_tolerance=np.inf)
    problem = to.Problem(scene=scene, start=START, goal=to.joint_positions(GOAL), waypoints={"via": via})
    assert "for waypoint via" in to.plan(problem).reason
    words = [remedy.words for remedy in remedied(problem).values()]
    assert any(item.startswith("at waypoint via, move the place of tip ") for item in words)


def test_nothing_alone_helps_where_several_joints_are_too_weak(arm: to.Robot) -> None:
    weak = replace(arm, limits=replace(arm.limits, effort=0.02 * arm.limits.effort))
    problem = to.Problem(scene=to.Scene(weak), start={"elbow": -1.6}, goal=to.joint_positions(GOAL))
    assert to.plan(problem).status is Status.START_CANNOT_BE_HELD
    found = to.plan(problem).explain(plan_again=True)
    assert found.remedies == () and "No single change" in str(found), "more than one joint is too weak"


@pytest.mark.parametrize("needed", [0.3, 1.0, 7.0])
def test_the_amount_is_the_smallest(pillar: to.Scene, needed: float) -> None:
    """The search with a planner that solves from a known amount on."""
    problem = to.Problem(scene=pillar, start=START, goal=to.joint_positions(GOAL))
    solved = to.plan(problem)
    failed = replace(solved, status=Status.STUCK)
    change = ProblemChange(
        what="x",
        unit="",
        first=1.0,
        largest=100.0,
        words=lambda amount: f"x by {amount:g}",
        apply=lambda amount: replace(problem, name=repr(amount)),
    )

    def plan(asked: to.Problem) -> to.Result:
        return replace(solved if float(asked.name) >= needed else failed, problem=asked)

    (remedy,) = smallest_changes([change], plan)
    assert needed <= remedy.amount <= 1.15 * needed
    assert float(remedy.problem.name) == remedy.amount
    assert float(remedy.half.problem.name) == remedy.amount / 2.0


def test_a_change_that_never_helps_is_none(pillar: to.Scene) -> None:
    problem = to.Problem(scene=pillar, start=START, goal=to.joint_positions(GOAL))
    failed = replace(to.plan(problem), status=Status.STUCK)
    change = ProblemChange(
        what="x",
        unit="",
        first=1.0,
        largest=3.0,
        words=str,
        apply=lambda amount: replace(problem, name=str(amount)),
    )
    asked: list[str] = []

    def plan(changed: to.Problem) -> to.Result:
        asked.append(changed.name)
        return failed

    assert smallest_changes([change], plan) == ()
    assert asked == ["1.0", "2.0", "3.0"]
