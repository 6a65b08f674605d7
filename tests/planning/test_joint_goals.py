"""Goals of joints with tolerances: all that they allow is looked at before anything is refused."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import trajopt as to
from trajopt.optimise.kinematics.inverse import MANY_STARTS, STARTS, GoalCandidates, goal_candidates
from trajopt.why import Certainty

ROBOT = to.load("planar2")
SHOULDER, ELBOW = ROBOT.joint_names
QUARTER = np.pi / 2


def asked(
    *goals: to.Requirement,
    scene: to.Scene | None = None,
    start: tuple[float, float] = (0.0, 0.0),
    **more: object,
) -> to.Problem:
    begin = dict(zip((SHOULDER, ELBOW), start, strict=True))
    return to.Problem(scene=scene or to.Scene(ROBOT), start=begin, goal=goals, **more)  # pyright: ignore


def post(radius: float = 0.05) -> to.Scene:
    """Something in the way of the straight arm that points up."""
    return to.Scene(ROBOT).add("post", to.Cylinder(radius, 1.0), to.placement((0.0, 0.8, 0.0)))


def joints(shoulder: float, elbow: float, tolerance: float) -> to.Requirement:
    return to.joint_positions({SHOULDER: shoulder, ELBOW: elbow}, tolerance=tolerance)


def test_a_motion_may_end_next_to_an_obstacle_in_the_middle_of_its_goal() -> None:
    result = to.plan(asked(joints(QUARTER, 0.0, 0.6), scene=post()))
    assert result.status is to.Status.SOLVED, result.reason


@pytest.mark.parametrize("tolerance", [0.0, 1e-4, 0.02])
def test_a_goal_that_collides_everywhere_is_refused_with_a_proof(tolerance: float) -> None:
    result = to.plan(asked(joints(QUARTER, 0.0, tolerance), scene=post(0.1)))
    assert result.status is to.Status.GOAL_IN_COLLISION and result.certainty is Certainty.PROVEN
    told = result.explain()
    assert told.certainty is Certainty.PROVEN and told.nearest_free is not None


def test_a_wide_goal_within_a_wall_is_refused_with_a_proof() -> None:
    wall = to.Scene(ROBOT).add("wall", to.Box(1.0, 0.3, 1.0), to.placement((0.0, 0.8, 0.0)))
    result = to.plan(asked(joints(QUARTER, 0.0, 0.2), scene=wall))
    assert result.status is to.Status.GOAL_IN_COLLISION and result.certainty is Certainty.PROVEN


def test_a_narrow_goal_whose_edge_is_free_is_reached_there() -> None:
    """The post is touched in the middle of the goal by less than the tolerance moves the arm away."""
    scene, tolerance = post(), 0.004
    reduced = asked(joints(QUARTER, 0.0, tolerance), scene=scene).reduced
    away = np.arange(QUARTER, 0.0, -1e-3)
    free = next(angle for angle in away if to.examine(reduced, np.array((angle, 0.0))).clear)
    middle = float(free) + 2e-3
    problem = asked(joints(middle, 0.0, tolerance), scene=scene)
    assert not to.examine(problem.reduced, np.array((middle, 0.0))).clear
    result = to.plan(problem)
    assert result.status is to.Status.SOLVED, result.reason


def test_a_goal_beyond_a_limit_by_less_than_its_tolerance_is_reached_at_the_limit() -> None:
    upper = float(asked(joints(0.0, 0.0, 1e-4)).reduced.limits.upper[0])
    result = to.plan(asked(joints(upper + 5e-5, 0.3, 1e-4)))
    assert result.status is to.Status.SOLVED, result.reason


def test_a_goal_beyond_a_limit_and_its_tolerance_is_refused_with_a_proof() -> None:
    upper = float(asked(joints(0.0, 0.0, 1e-4)).reduced.limits.upper[0])
    result = to.plan(asked(joints(upper + 0.1, 0.3, 0.05)))
    assert result.status is to.Status.GOAL_OUT_OF_LIMITS and result.certainty is Certainty.PROVEN


def test_goals_of_the_same_joint_share_their_common_range() -> None:
    goals = joints(0.5, 0.0, 0.2), joints(0.9, 0.0, 0.3)
    result = to.plan(asked(*goals))
    assert result.status is to.Status.SOLVED, result.reason


def test_goals_that_share_only_a_sliver_are_reached_there() -> None:
    result = to.plan(asked(joints(0.5, 0.0, 0.2), joints(1.0, 0.0, 0.301)))
    assert result.status is to.Status.SOLVED, result.reason


def test_goals_of_the_same_joint_that_share_nothing_are_refused_with_a_proof() -> None:
    result = to.plan(asked(joints(0.5, 0.0, 0.1), joints(0.9, 0.0, 0.1)))
    assert result.status is to.Status.CONFLICTING_CONSTRAINTS and result.certainty is Certainty.PROVEN
    assert SHOULDER in result.message and result.explain().certainty is Certainty.PROVEN


def test_a_path_constraint_that_part_of_the_goal_fulfils_is_accepted() -> None:
    always = to.joint_positions({SHOULDER: 0.0}, tolerance=1.4)
    result = to.plan(asked(joints(QUARTER, 0.0, 0.4), constraints=[always]))
    assert result.status is to.Status.SOLVED, result.reason


@pytest.mark.parametrize(
    ("goal", "tolerance", "constraint"),
    [
        (1.0, 0.3, to.joint_positions({SHOULDER: 0.0}, tolerance=0.5)),
        (1.0, 0.3, to.coupled_joints({SHOULDER: 1.0, ELBOW: 1.0}, 0.0, tolerance=0.2)),
    ],
)
def test_a_path_constraint_that_all_of_the_goal_breaks_is_a_proof(
    goal: float, tolerance: float, constraint: to.Requirement
) -> None:
    result = to.plan(asked(joints(goal, 0.0, tolerance), constraints=[constraint]))
    assert result.status is to.Status.GOAL_BREAKS_CONSTRAINT and result.certainty is Certainty.PROVEN


@pytest.mark.parametrize("beyond", [5e-7, 2e-6])
def test_the_start_is_refused_where_the_judge_refuses_it(beyond: float) -> None:
    """One tolerance for both: what the judge accepts of a motion is no reason to refuse its start."""
    tolerance = 0.4
    always = to.coupled_joints({SHOULDER: 1.0, ELBOW: 1.0}, 0.0, tolerance=tolerance)
    problem = asked(joints(0.0, 0.0, 1e-4), start=(tolerance + beyond, 0.0), constraints=[always])
    line = np.array(((tolerance + beyond, 0.0), (0.0, 0.0)))
    motion = to.Trajectory(problem.reduced.joint_names, np.array((0.0, 9.0)), line)
    certificate = to.judge(problem, motion)
    accepted = all(check.holds for check in certificate.checks if "coupled" in check.name)
    result = to.plan(problem)
    assert (result.status is not to.Status.START_BREAKS_CONSTRAINT) == accepted == (beyond < 1e-6)
    assert result.certainty is Certainty.PROVEN
    assert result.verified == accepted, result.reason


def test_a_waypoint_may_be_passed_next_to_an_obstacle_in_its_middle() -> None:
    result = to.plan(asked(joints(0.3, 0.0, 1e-4), scene=post(), waypoints={"up": joints(QUARTER, 0.0, 0.6)}))
    assert result.status is to.Status.SOLVED, result.reason


def test_the_remedies_of_a_refused_goal_start_from_its_tolerance() -> None:
    """Moved with its tolerance: by less than the way from its middle to what is free."""
    wall = to.Scene(ROBOT).add("wall", to.Box(1.0, 0.3, 1.0), to.placement((0.0, 0.8, 0.0)))
    narrow, wide = (
        to.plan(asked(joints(QUARTER, 0.0, tolerance), scene=wall)).explain(plan_again=True)
        for tolerance in (1e-4, 0.2)
    )
    moved = [
        min(remedy.amount for remedy in told.remedies or () if remedy.what == "goal")
        for told in (narrow, wide)
    ]
    assert moved[1] < moved[0] - 0.1


def test_a_goal_set_is_refused_with_a_proof_only_if_every_goal_is() -> None:
    beyond, wrongly_turned = (
        joints(10.0, 0.0, 1e-4),
        to.frame_placement("tool", to.placement((0.3, 0.3, 0.0))),
    )
    goals = {"beyond": beyond, "wrongly turned": wrongly_turned}
    mixed = to.plan(replace(asked(beyond), goal=to.any_of(goals)))
    assert not mixed.verified and mixed.certainty is Certainty.EVIDENCE
    assert mixed.explain().certainty is Certainty.EVIDENCE
    proven = to.plan(replace(asked(beyond), goal=to.any_of({"beyond": beyond, "farther": joints(20, 0, 1)})))
    assert proven.certainty is Certainty.PROVEN and proven.explain().certainty is Certainty.PROVEN


@pytest.mark.parametrize(("tolerance", "waves"), [(1e-4, [STARTS]), (0.05, [STARTS, MANY_STARTS])])
def test_a_goal_of_one_configuration_is_not_searched_from_many_starts(
    monkeypatch: pytest.MonkeyPatch, tolerance: float, waves: list[int]
) -> None:
    """Before, a joint goal that breaks a constraint was refused after 3,264 starts at the same place."""
    tried: list[int] = []

    def recorded(*args: Any, starts: int, **kwargs: Any) -> GoalCandidates:
        tried.append(starts)
        return goal_candidates(*args, starts=starts, **kwargs)

    monkeypatch.setattr("trajopt.planning.endpoints.goal_candidates", recorded)
    panda = to.Scene(to.load("panda"))
    there = dict(
        zip(panda.robot.group("panda_arm").joints, (0.3, 0.7, 0.2, -1.0, 0.3, 1.6, 0.5), strict=True)
    )
    goal = to.joint_positions(there, tolerance=tolerance)
    found = to.plan(
        to.Problem(
            scene=panda, group="panda_arm", start="ready", goal=goal, constraints=[to.gravity_torque(0.3)]
        )
    )
    assert found.status is to.Status.GOAL_BREAKS_CONSTRAINT and tried == waves
