"""Gaps wider than what is required by less than the margins: passed with what there is, never less."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import trajopt as to
from tests.planning.test_required_clearance import RADIUS, slide
from trajopt.optimise.methods import METHODS
from trajopt.planning.goal_search import Candidate, attempt

START, GOAL = {"x": -0.5, "y": 0.0}, {"x": 0.5, "y": 0.0}


def gap(folder: Path, spare: float, required: float, *, aside: float = 0.0) -> to.Problem:
    """A ball on two slides has to pass between two long walls, with so much to spare in all [m]."""
    scene = to.Scene(slide(folder)).add("ball", to.Sphere(RADIUS), frame="hand", touch_links=["hand"])
    middle = RADIUS + required + 0.5 * spare + 2.0
    for name, side in (("left", 1.0), ("right", -1.0)):
        scene = scene.add(name, to.Box(0.3, 4.0, 0.2), to.placement((0.0, aside + side * middle, 0.0)))
    if required:
        scene = scene.with_clearance(required)
    return to.Problem(scene=scene, start=START, goal=to.joint_positions(GOAL))


@pytest.mark.parametrize("required", [0.0, 0.003, 0.02])
def test_a_gap_with_two_millimetres_to_spare_is_passed(tmp_path: Path, required: float) -> None:
    found = to.plan(gap(tmp_path, 2e-3, required), budget=to.Budget(attempts=3))
    assert found.verified, found.reason
    assert required < found.require().certificate.clearance <= required + 1e-3


@pytest.mark.parametrize("required", [0.0, 0.02])
def test_a_gap_aside_is_found_and_passed(tmp_path: Path, required: float) -> None:
    problem = gap(tmp_path, 4e-3, required, aside=0.02)
    found = to.plan(problem, budget=to.Budget(attempts=12))
    assert found.verified, found.reason
    assert required < found.require().certificate.clearance <= required + 2e-3


@pytest.mark.parametrize("required", [0.003, 0.02])
def test_a_gap_with_less_than_is_required_is_not_passed(tmp_path: Path, required: float) -> None:
    found = to.plan(gap(tmp_path, -2e-4, required), budget=to.Budget(attempts=3))
    assert not found.verified and "required" in found.reason


def slot(folder: Path) -> to.Scene:
    """Return a slot with one wall 0.3 mm beside the ball at y = 0, and two walls 3 mm on the other side."""
    scene = to.Scene(slide(folder)).add("ball", to.Sphere(RADIUS), frame="hand", touch_links=["hand"])
    scene = scene.add("near", to.Box(2.0, 4.0, 0.2), to.placement((0.0, RADIUS + 3e-4 + 2.0, 0.0)))
    for name, height in (("upper", 0.051), ("lower", -0.051)):
        wall = to.Box(2.0, 4.0, 0.1)
        scene = scene.add(name, wall, to.placement((0.0, -RADIUS - 3e-3 - 2.0, height)))
    return scene


@pytest.mark.parametrize("length", [0.0, 0.003, 0.4])
def test_a_line_along_nearer_walls_than_the_margin_is_kept(tmp_path: Path, length: float) -> None:
    goal = to.joint_positions({"x": length, "y": 0.0})
    problem = to.Problem(scene=slot(tmp_path), start={"x": 0.0, "y": 0.0}, goal=goal)
    found = to.plan(problem, budget=to.Budget(attempts=2))
    assert found.verified, found.reason


def test_where_there_is_room_the_margin_stays(tmp_path: Path) -> None:
    found = to.plan(gap(tmp_path, 0.03, 0.0, aside=0.004), budget=to.Budget(attempts=1)).require()
    assert found.certificate.clearance > 9e-3


def test_a_requested_margin_stays(tmp_path: Path) -> None:
    problem = gap(tmp_path, 0.02, 0.0)
    assert to.plan(problem, budget=to.Budget(attempts=3)).verified
    asked = replace(problem, scene=problem.scene.with_margin(0.03))
    found = to.plan(asked, budget=to.Budget(attempts=3))
    assert found.status is to.Status.STUCK and "clearance of ball" in found.message


def test_a_margin_that_no_motion_keeps_gives_way_after_two_rounds(tmp_path: Path) -> None:
    problem = gap(tmp_path, 0.02, 0.0)
    found = to.plan(replace(problem, scene=problem.scene.with_margin(0.03)))
    assert found.verified and len(found.attempts) < 10
    (remark,) = found.remarks
    assert "no motion keeps the margin of 30 mm between ball and" in remark
    assert "x has to pass" in remark and "give way to the default" in remark


def test_a_margin_gives_way_where_the_judge_refuses_motions(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Before, only motions that the optimiser gave up let margins give way."""

    def refused(candidate: Candidate) -> to.Result:
        found = attempt(candidate)
        return replace(found, status=to.Status.NOT_VERIFIED) if found.status is to.Status.STUCK else found

    monkeypatch.setattr("trajopt.planning.search.attempt", refused)
    problem = gap(tmp_path, 0.02, 0.0)
    found = to.plan(replace(problem, scene=problem.scene.with_margin(0.03)))
    assert found.verified and "give way to the default" in " ".join(found.remarks)


def test_a_margin_gives_way_under_a_time_limit_too(tmp_path: Path) -> None:
    problem = gap(tmp_path, 0.02, 0.0)
    asked = replace(problem, scene=problem.scene.with_margin(0.03, "ball", "left"))
    assert to.plan(asked, seconds=20.0).verified


def test_a_margin_gives_way_among_dynamic_obstacles(tmp_path: Path) -> None:
    problem = gap(tmp_path, 0.02, 0.0)
    falling = to.Track.constant_velocity(to.placement((0.0, 0.0, 0.48)), (0.0, 0.0, -3.0))
    scene = problem.scene.with_margin(0.03).add("stone", to.Box(0.02, 0.02, 0.02), motion=falling)
    found = to.plan(replace(problem, scene=scene))
    assert found.verified and found.method == "space-time"
    assert "give way to the default" in " ".join(found.remarks)


def test_margins_do_not_give_way_for_a_goal_in_collision(tmp_path: Path) -> None:
    problem = gap(tmp_path, 0.02, 0.0)
    inside = replace(
        problem, scene=problem.scene.with_margin(0.03), goal=to.joint_positions({"x": 0.0, "y": 0.5})
    )
    found = to.plan(inside)
    assert found.status is to.Status.GOAL_IN_COLLISION and not found.remarks


def test_a_failure_does_not_depend_on_margins_that_gave_way(tmp_path: Path) -> None:
    problem = gap(tmp_path, -2e-4, 0.0)
    found = to.plan(replace(problem, scene=problem.scene.with_margin(0.03)), budget=to.Budget(attempts=40))
    assert not found.verified and "margin" not in found.message


@pytest.mark.parametrize("method", ["sqp", "chomp", "free-duration"])
def test_methods_over_knots_pass_narrow_gaps(tmp_path: Path, method: str) -> None:
    assert method in METHODS
    found = to.plan(gap(tmp_path, 4e-3, 0.02), method=method, budget=to.Budget(attempts=3))
    assert found.verified, found.reason


def test_samples_are_denser_where_the_margin_is_smaller(tmp_path: Path) -> None:
    from trajopt.optimise.transcription import transcribe

    problem = gap(tmp_path, 4e-3, 0.02)
    line = np.linspace((-0.5, 0.0), (0.5, 0.0), problem.knots)
    nlp = transcribe(problem, line)
    wide, narrow = (each.sampling(line, fine=True).sum() for each in (nlp, nlp.keeping(0.064)))
    assert narrow > 1.5 * wide
    at = nlp.linearise(line, nlp.sampling(line, fine=True))
    assert not at.feasible and nlp.lacks_margin_only(at)
    low = np.copy(line)
    low[8:16, 1] += 0.01
    assert not nlp.lacks_margin_only(nlp.linearise(low, nlp.sampling(low, fine=True)))


def test_links_that_are_next_to_each_other_do_not_have_to_keep_a_requested_margin() -> None:
    scene = (
        to.Scene(to.load("ur5"))
        .with_margin(0.03)
        .add("post", to.Box(0.1, 0.1, 0.4), to.placement((0.5, 0.3, 0.2)))
    )
    start = (0.0, -1.6, 1.4, -1.4, -1.57, 0.0)
    goal = (1.2, -1.4, 1.2, -1.4, -1.57, 0.0)
    found = to.plan(to.Problem(scene=scene, group="manipulator", start=start, goal=goal))
    assert found.verified and len(found.attempts) == 1
    assert any(
        "forearm_link and wrist_2_link, which are nearer at the start" in each for each in found.remarks
    )
    assert found.problem.scene.margin_of("wrist_3_link", "post") == 0.03


def test_margins_between_links_give_way_before_those_from_the_world() -> None:
    scene = (
        to.Scene(to.load("panda"))
        .with_margin(0.05)
        .add("ball", to.Sphere(0.05), to.placement((0.6, 0.0, 0.8)))
    )
    bent = (0.2, -0.5, -0.2, -1.2, -1.4, 2.4, -1.7)
    found = to.plan(to.Problem(scene=scene, group="panda_arm", start="ready", goal=bent))
    assert found.verified
    (remark,) = found.remarks
    assert "links have the default margin from each other" in remark
    assert found.problem.scene.margin_of("panda_link5", "panda_hand") == 0.01
    assert found.problem.scene.margin_of("panda_hand", "ball") == 0.05
