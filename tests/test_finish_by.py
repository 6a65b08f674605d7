"""Deadlines: planning meets them where it can, the judge checks them, what no motion meets is proven."""

from dataclasses import replace

import numpy as np
import pytest

import trajopt as to
from tests.planning.moving.test_dynamic_search import GOAL, across, problem, table
from trajopt.planning import Certainty, on_the_way
from trajopt.planning.infeasibility import too_late
from trajopt.planning.infeasibility.joint_bounds import least_time
from trajopt.timing import Retimed, retime
from trajopt.timing.time_scaling import begun_later
from trajopt.values.errors import ProblemError
from trajopt.values.trajectory import Path

__all__ = ["table"]


@pytest.mark.parametrize("jerk", [np.inf, 50.0])
@pytest.mark.parametrize("distance", [0.01, 0.3, 2.0])
def test_no_motion_of_one_joint_is_sooner_than_the_least_time(distance: float, jerk: float) -> None:
    robot = to.load("planar2")
    names = ("joint1",)
    limits = replace(robot.limits.take(np.array([0])), jerk=np.array([jerk]))
    timed = retime(Path(names, np.array(((0.0,), (distance,)))), limits)
    assert isinstance(timed, Retimed)
    least = least_time(distance, float(limits.velocity[0]), float(limits.acceleration[0]), jerk)
    assert 0.6 * timed.trajectory.duration < least <= timed.trajectory.duration
    if jerk == np.inf:
        assert least > 0.97 * timed.trajectory.duration, "without limits of jerk the bound is exact"


def test_a_motion_that_is_over_in_time_stays_as_it_is(table: to.Scene) -> None:
    still = to.plan(problem(table)).require()
    asked = replace(problem(table), finish_by=still.trajectory.duration + 0.01)
    found = to.plan(asked).require()
    assert np.array_equal(found.trajectory.positions, still.trajectory.positions)
    (check,) = (check for check in found.certificate.checks if check.name == "finish by")
    assert check.holds and check.slack == pytest.approx(0.01)
    assert "finish" not in str(still.certificate) and "finished by" in str(asked)


def test_the_judge_refuses_a_motion_that_is_late(table: to.Scene) -> None:
    still = to.plan(problem(table)).require()
    asked = replace(problem(table), finish_by=still.trajectory.duration + 0.3)
    assert to.judge(asked, begun_later(still.trajectory, 0.29)).verified
    late = to.judge(asked, begun_later(still.trajectory, 0.31))
    assert [check.name for check in late.failed] == ["finish by"]
    assert "0.010 s late" in late.failed[0].detail


def test_a_deadline_that_the_limits_forbid_is_refused_with_proof(table: to.Scene) -> None:
    result = to.plan(replace(problem(table), finish_by=0.5))
    assert result.status is to.Status.TOO_LATE and result.certainty is Certainty.PROVEN
    assert (
        "panda_joint1 alone, 91.67 deg away, takes 0.881 s at least" in result.message
        and "the deadline is 0.5 s" in result.message
    )
    assert not result.attempts, "nothing is attempted"
    assert "limits of the joints" in str(result.explain())


def test_the_bound_of_a_frame_is_below_the_motion_and_refuses_far_goals(table: to.Scene) -> None:
    there = table.placement_of("panda_hand", table.robot.positions(GOAL))
    asked = replace(problem(table), goal=to.frame_placement("panda_hand", there))
    duration = to.plan(asked).require().trajectory.duration
    assert not too_late(replace(asked, finish_by=duration))
    assert "panda_hand, 0.902 m away, takes 0.108 s" in too_late(replace(asked, finish_by=0.04))


def test_a_deadline_gets_a_shorter_shape_or_the_soonest_end_is_reported(table: to.Scene) -> None:
    asked = problem(table.add("pillar", to.Box(0.08, 0.08, 0.9), to.placement((0.55, 0.0, 0.3))))
    best, along = (to.plan(asked, improve=improve).require().trajectory.duration for improve in (True, False))
    assert best < 0.95 * along
    met = to.plan(replace(asked, finish_by=0.97 * along), budget=to.Budget(attempts=2))
    assert met.verified and met.require().trajectory.duration <= 0.97 * along
    # Just above the proven least of the joint that has farthest to go.
    missed = to.plan(replace(asked, finish_by=0.8822), budget=to.Budget(attempts=2))
    assert missed.status is to.Status.TOO_LATE and missed.certainty is Certainty.EVIDENCE
    assert "the soonest motion that was found takes" in missed.reason


def test_a_late_motion_ends_the_search_after_the_opening_and_the_soonest_is_reported(table: to.Scene) -> None:
    goal = to.placement((0.4, 0.3, 0.3), rpy=(np.pi, 0.0, 0.0))
    start = [-0.6, 0.3, -0.2, -2.1, 0.1, 2.4, 0.0]
    asked = to.Problem(scene=table, group="panda_arm", start=start, goal=goal)
    along, best = (to.plan(asked, improve=improve).require().trajectory.duration for improve in (False, True))
    missed = to.plan(replace(asked, finish_by=0.8 * best))
    assert missed.status is to.Status.TOO_LATE and missed.certainty is Certainty.EVIDENCE, missed.reason
    assert len(missed.attempts) < 40
    passing = table.add("ball", to.Sphere(0.05), motion=across(1.0, begin=0.0, end=1.0))
    among = to.plan(replace(asked, scene=passing, finish_by=0.8 * best), budget=to.Budget(attempts=2))
    assert "without what changes with time the soonest motion that was found takes" in among.reason
    motion = missed.trajectory
    assert best < 0.99 * along and motion is not None and motion.duration <= 1.01 * best


@pytest.mark.parametrize("speed", [0.0, 0.1])
def test_a_tool_that_is_slow_is_late(table: to.Scene, speed: float) -> None:
    slow = to.tool_speed("panda_hand_tcp", linear=0.3)
    moving = {"panda_joint1": speed}
    asked = replace(problem(table), tool_speed=slow, start_velocity=moving, finish_by=2.0)
    missed = to.plan(asked, budget=to.Budget(attempts=2))
    assert missed.status is to.Status.TOO_LATE and "takes" in missed.reason, missed.reason


def test_a_deadline_among_dynamic_obstacles_allows_waiting_or_is_refused(table: to.Scene) -> None:
    scene = table.add("gate", to.Box(1.2, 0.04, 3.0), to.placement((0.75, 0.2, 0.5)), expires=1.0)
    free = to.plan(problem(scene)).require().trajectory.duration
    assert free > 1.1
    met = to.plan(replace(problem(scene), finish_by=free + 0.01))
    assert met.verified and met.require().trajectory.duration <= free + 0.01
    missed = to.plan(replace(problem(scene), finish_by=free - 0.2), budget=to.Budget(attempts=2))
    assert missed.status is to.Status.TOO_LATE and missed.certainty is Certainty.EVIDENCE, missed.reason


def test_a_deadline_is_a_time_after_the_start(table: to.Scene) -> None:
    for wrong in (0.0, -1.0):
        with pytest.raises(ProblemError, match="finish_by"):
            replace(problem(table), finish_by=wrong)
    with pytest.raises(to.TrajoptError, match="finish_by"):
        replace(problem(table), finish_by=np.nan)


def test_a_deadline_comes_sooner_on_the_way(table: to.Scene) -> None:
    asked = replace(problem(table), finish_by=2.0)
    running = to.plan(asked).require().trajectory
    assert on_the_way(asked, running, 0.3).finish_by == pytest.approx(1.7)
