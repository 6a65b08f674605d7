"""Planning among things that move, appear and expire: later, around, or why not."""

from dataclasses import replace

import numpy as np
import pytest

import trajopt as to
from tests.verify.test_moving_things import sampled
from trajopt.planning.budget import Budget, BudgetTracker, Stop
from trajopt.planning.moving.dynamic_search import SOURCES
from trajopt.planning.schedule import DYNAMIC, MotionSource
from trajopt.planning.status import Certainty
from trajopt.planning.workspace import MotionCandidate, PlanningWorkspace
from trajopt.timing.time_scaling import begun_later

START = {
    "panda_joint1": -0.8, "panda_joint2": 0.3, "panda_joint3": 0.0, "panda_joint4": -2.0,
    "panda_joint5": 0.0, "panda_joint6": 2.3, "panda_joint7": 0.8,
}  # fmt: skip
GOAL = {**START, "panda_joint1": 0.8, "panda_joint2": 0.5, "panda_joint4": -1.8}
WALL = to.Box(1.2, 0.04, 3.0), to.placement((0.75, 0.0, 0.5))
"""Between start and goal, from in front of the base to beyond the arm's reach."""


@pytest.fixture(scope="module")
def table() -> to.Scene:
    try:
        panda = to.load("panda")
    except to.MissingExtra as error:
        pytest.skip(str(error))
    return to.Scene(panda).add("table", to.Box(1.2, 1.6, 0.04), to.placement((0.5, 0.0, -0.06)))


def without_jerk_limits(robot: to.Robot) -> to.Robot:
    free = replace(robot.limits, jerk=np.full(len(robot.joint_names), np.inf))
    return replace(robot, limits=free)


def problem(scene: to.Scene) -> to.Problem:
    return to.Problem(scene=scene, group="panda_arm", start=START, goal=to.joint_positions(GOAL))


def across(height: float, *, begin: float, end: float) -> to.Track:
    """Return a track along x through the middle of the arm's way."""
    places = [to.placement((x, 0.0, height)) for x in (1.4, 0.5, 1.4)]
    return to.Track.through([begin, (begin + end) / 2.0, end], places)


def test_distant_obstacles_change_nothing(table: to.Scene) -> None:
    still = to.plan(problem(table)).require().trajectory
    late = table.add("box", to.Box(0.1, 0.1, 0.4), motion=across(0.4, begin=5.0, end=7.0))
    among = to.plan(problem(late))
    assert among.verified and np.array_equal(among.require().trajectory.positions, still.positions)


def test_a_goal_may_be_relative_to_an_object_that_appears(table: to.Scene) -> None:
    scene = table.add("tray", to.Box(0.05, 0.05, 0.02), to.placement((0.4, 0.1, 0.1)), appears=0.05)
    above = to.placement((0.0, 0.0, 0.3), rpy=(np.pi, 0.0, 0.0))
    goal = to.frame_placement("panda_hand_tcp", above, reference="tray")
    plan = to.plan(replace(problem(scene), goal=goal)).require()
    end = problem(scene).reduced.all_positions(plan.trajectory(plan.trajectory.duration))
    place = scene.placement_of("panda_hand_tcp", end)
    assert np.allclose(place.translation, (0.4, 0.1, 0.4), atol=1e-4)


def test_the_arm_passes_a_crossing_obstacle_sooner_than_by_waiting(table: to.Scene) -> None:
    still = to.plan(problem(table)).require()
    # From before the floor to above the arm's reach, so that there is no way over it.
    scene = table.add("gate", to.Box(0.5, 0.05, 3.0), motion=across(0.6, begin=-0.6, end=1.0))
    work = PlanningWorkspace(problem(scene), BudgetTracker(Budget()))
    waits = next(work.avoiding(MotionCandidate(still.path, still.trajectory, None))).trajectory
    assert still.trajectory.duration + 0.1 < waits.duration < 1.0 + still.trajectory.duration
    assert to.judge(problem(scene), waits).verified
    sooner = begun_later(still.trajectory, waits.duration - still.trajectory.duration - 0.05)
    assert not to.judge(problem(scene), sooner).verified, "nothing shorter begun sooner is clear"
    result = to.plan(problem(scene))
    motion = result.require().trajectory
    assert motion.duration <= waits.duration
    assert sampled(scene, result.problem.reduced, motion) > 0.0
    certificate = result.require().certificate
    assert "proven given that gate is on its track" in certificate.notes


def test_the_arm_goes_around_an_obstacle_that_stops_on_its_path(table: to.Scene) -> None:
    lands = to.Track.through([0.0, 0.5], [to.placement((0.55, 0.0, z)) for z in (1.4, 0.2)])
    scene = table.add("box", to.Box(0.08, 0.08, 0.5), motion=lands)
    result = to.plan(problem(scene))
    assert result.verified
    assert sampled(scene, result.problem.reduced, result.require().trajectory) > 0.0


def test_an_expired_obstacle_no_longer_blocks(table: to.Scene) -> None:
    stays, goes = (table.add("wall", *WALL, expires=expires) for expires in (9.0, 0.3))
    long, short = (to.plan(problem(scene)).require().trajectory for scene in (stays, goes))
    assert short.duration < 0.3 + 1.0 < long.duration
    assert sampled(goes, problem(goes).reduced, short) > 0.0


def test_an_obstacle_that_appears_at_the_goal_is_the_reason_of_failure(table: to.Scene) -> None:
    there = table.placement_of("panda_hand", table.robot.positions(GOAL))
    block = table.add("block", to.Box(0.3, 0.3, 0.3), to.placement(there.translation), appears=0.1)
    result = to.plan(problem(block), budget=to.Budget(attempts=1))
    assert result.status is to.Status.GOAL_OCCUPIED and result.certainty is Certainty.PROVEN
    assert "block (at panda_" in result.reason and "s on, and nothing gets there before" in result.reason


@pytest.mark.parametrize("jerk", [False, True])
@pytest.mark.parametrize("leaves", [False, True])
def test_the_arm_waits_for_its_goal_with_any_limits(table: to.Scene, *, jerk: bool, leaves: bool) -> None:
    robot = table.robot if jerk else without_jerk_limits(table.robot)
    there = to.placement(table.placement_of("panda_hand", robot.positions(GOAL)).translation)
    away = to.Track.through([1.0, 1.4], [there, to.placement((3.0, 3.0, 0.5))])
    ball, scene = to.Sphere(0.1), to.Scene(robot)
    scene = scene.add("ball", ball, motion=away) if leaves else scene.add("ball", ball, there, expires=1.0)
    result = to.plan(problem(scene))
    motion = result.require().trajectory
    assert 1.0 < motion.duration < 2.5
    assert sampled(scene, result.problem.reduced, motion) > 0.0
    assert any("for what changes with time" in remark for remark in result.remarks)


def test_a_short_prediction_still_gives_a_result(table: to.Scene) -> None:
    known = to.Prediction(across(0.6, begin=-0.6, end=1.0), (0.01, 0.02, 0.0), until=0.5)
    result = to.plan(problem(table.add("gate", to.Box(0.5, 0.05, 3.0), motion=known)))
    assert result.status is to.Status.BLOCKED_IN_TIME and "gate" in result.reason


def test_the_room_for_an_error_costs_time(table: to.Scene) -> None:
    there = to.placement(table.placement_of("panda_hand", table.robot.positions(GOAL)).translation)
    leaves = to.Track.through([0.8, 1.6], [there, there * to.placement((0.0, 0.0, 1.2))])
    durations = [
        to.plan(problem(table.add("ball", to.Sphere(0.1), motion=to.Prediction(leaves, (radius, 0.0, 0.0)))))
        .require()
        .trajectory.duration
        for radius in (0.0, 0.1)
    ]
    assert durations[0] + 0.01 < durations[1]


def test_each_goal_of_a_set_is_planned_to_as_if_alone(table: to.Scene) -> None:
    lands = to.Track.through([0.0, 0.5], [to.placement((0.55, 0.0, z)) for z in (1.4, 0.2)])
    scene = table.add("box", to.Box(0.08, 0.08, 0.5), motion=lands)
    alone = to.plan(problem(scene)).require().trajectory
    goals = to.any_of({"there": to.joint_positions(GOAL), "here": to.joint_positions(START)})
    result = to.plan(replace(problem(scene), goal=goals), every_goal=True)
    among = result.of_each_goal["there"].require().trajectory
    assert np.array_equal(among.positions, alone.positions)


def test_a_motion_that_seems_too_near_to_something_and_is_not_is_returned(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    bare, begin, end = to.Scene(to.load("planar2")), {"joint1": -0.5, "joint2": 0.0}, {"joint1": 0.5}
    still = to.plan(to.Problem(scene=bare, start=begin, goal=end)).require().trajectory
    ball = bare.add("ball", to.Sphere(0.05), to.placement((1.1, 0.0, 0.14)), expires=100.0)
    in_time = to.Problem(scene=ball, start=begin, goal=end, finish_by=still.duration)
    assert to.judge(in_time, still).verified
    # Checks that keep so much clearance find no time at which the motion seems clear.
    monkeypatch.setattr("trajopt.planning.moving.sampled_checks.MARGIN", 1.0)
    result = to.plan(in_time)
    assert result.verified and result.require().trajectory.duration <= still.duration


def test_a_motion_found_before_the_budget_ends_is_kept_with_the_end() -> None:
    crossing = to.named_problem("crossing_panda")
    whole = to.plan(crossing)
    result = to.plan(crossing, budget=to.Budget(work=whole.counts["forward_kinematics"] * 3 // 4))
    assert result.verified and result.stopped is Stop.WORK


def test_each_source_is_in_the_table() -> None:
    assert [row.source for row in DYNAMIC] == list(SOURCES) == list(MotionSource)
