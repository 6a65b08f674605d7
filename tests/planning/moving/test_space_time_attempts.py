"""Planning in space and time: around what parks, through a revolving door, aside and back, and in motion."""

from dataclasses import replace

import numpy as np
import pytest

import trajopt as to
from tests.planning.moving.test_dynamic_search import GOAL, START, problem, table
from tests.verify.test_moving_things import sampled
from trajopt.optimise.methods.space_time import PRECISION, SpaceTime
from trajopt.optimise.solvers.descent import Descent
from trajopt.optimise.terms import rest_posture
from trajopt.optimise.transcription.space_time import SpaceTimeFamily, SpaceTimeNlp
from trajopt.planning.budget import WORK
from trajopt.planning.moving.dynamic_timing import LONGEST
from trajopt.verify import Certificate, Judge, Specification

__all__ = ["table"]  # a fixture


def proven(result: to.Result) -> to.Trajectory:
    motion = result.require().trajectory
    assert result.require().certificate.verified
    assert sampled(result.problem.scene, result.problem.reduced, motion) > 0.0
    return motion


def test_the_path_changes_for_an_obstacle_parked_on_it(table: to.Scene) -> None:
    still = to.plan(problem(table)).require().trajectory
    parks = to.Track.through([0.0, 0.4], [to.placement((0.5, y, 0.45)) for y in (1.2, 0.0)])
    result = to.plan(problem(table.add("box", to.Box(0.2, 0.2, 0.2), motion=parks)))
    motion = proven(result)
    assert motion.duration < 2.0 * still.duration
    between = np.linspace(0.2, 0.8, 200)
    passed = still(still.duration * between)
    off = [np.abs(passed - q).max(axis=1).min() for q in motion(motion.duration * between)]
    assert max(off) > 0.05, "no timing of the straight line passes"


def test_a_motion_is_found_without_measuring_how_nearly_others_do_not_hold(
    table: to.Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    measured: list[to.Trajectory] = []
    certify = Judge.certify

    def counted(judge: Judge, trajectory: to.Trajectory, specification: Specification) -> Certificate:
        measured.append(trajectory)
        return certify(judge, trajectory, specification)

    monkeypatch.setattr(Judge, "certify", counted)
    still = to.plan(problem(table)).require().trajectory
    parks = to.Track.through([0.0, 0.3], [to.placement((0.55, y, 0.5)) for y in (1.2, 0.0)])
    result = to.plan(problem(table.add("box", to.Box(0.3, 0.1, 1.0), motion=parks)))
    assert result.require().trajectory.duration > 1.05 * still.duration
    assert result.method == "space-time" and not measured
    assert result.require().certificate.verified and len(measured) == 1, "when it is asked for"


def test_nothing_else_is_tried_where_it_takes_hardly_longer(table: to.Scene) -> None:
    still = to.plan(problem(table)).require().trajectory
    middle = dict(zip(still.joint_names, still(still.duration / 2.0), strict=True))
    hand = table.placement_of("panda_hand", table.robot.positions(middle)).translation
    places = [to.placement(hand + np.array((0.0, 0.0, away))) for away in (0.8, -0.8)]
    falls = to.Track.through([0.0, still.duration], places)
    result = to.plan(problem(table.add("box", to.Box(0.1, 0.1, 0.1), motion=falls)))
    assert result.method == "space-time"
    assert proven(result).duration <= 1.05 * still.duration + 1e-9
    assert "proof" not in result.cpu_seconds, "no reason to look for a proof that there is none"
    assert result.counts["attempts"] == 2


def test_endless_tracks_are_checked_only_as_long_as_a_motion_waits(table: to.Scene) -> None:
    """It drifts through the goal so slowly that no wait ends before it is gone."""
    still = to.plan(problem(table)).require().trajectory
    ends = dict(zip(still.joint_names, still(still.duration), strict=True))
    hand = table.placement_of("panda_hand", table.robot.positions(ends)).translation
    begin = to.placement(hand + np.array((0.0, 0.0, 0.3)))
    drifts = to.Track.constant_velocity(begin, (0.0, 0.0, -0.3 / still.duration))
    result = to.plan(problem(table.add("box", to.Box(0.1, 0.1, 0.1), motion=drifts)))
    assert result.verified
    assert proven(result).duration < LONGEST


def test_no_duration_is_tried_before_the_goal_is_left(
    table: to.Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    tried: list[float] = []
    lasting = SpaceTimeFamily.lasting

    def noted(family: SpaceTimeFamily, duration: float) -> SpaceTimeNlp:
        tried.append(duration)
        return lasting(family, duration)

    monkeypatch.setattr(SpaceTimeFamily, "lasting", noted)
    goal = table.placement_of("panda_hand", table.robot.positions(GOAL)).translation
    places = [to.placement(goal + np.array((0.0, away, 0.0))) for away in (0.0, 0.0, 1.0)]
    leaves = to.Track.through([0.0, 1.3, 2.3], places)
    result = to.plan(problem(table.add("guest", to.Sphere(0.05), motion=leaves)))
    assert len(tried) == 1, "the first is hardly longer than until the goal is left"
    assert 1.3 < proven(result).duration < 1.6


def test_proven_motions_are_not_sampled_again(table: to.Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    crosses = to.Track.through([0.0, 2.0], [to.placement((0.5, y, 0.45)) for y in (0.9, -0.9)])
    asked = problem(table.add("box", to.Box(0.2, 0.2, 0.2), motion=crosses))
    motion = to.plan(problem(table)).require().trajectory
    program = SpaceTime().program(asked, np.linspace(motion(0.0), motion(motion.duration), asked.knots))
    refined: list[Descent] = []

    def refine(run: Descent) -> bool:
        refined.append(run)
        return False

    monkeypatch.setattr(Descent, "refine", refine)
    longest = 1.05 * motion.duration

    def solved(*, proves: bool) -> to.Trajectory | None:
        found = program.solve_from(motion, longest=longest, enough=longest, proves=lambda _: proves)
        return found.decoded.trajectory

    assert solved(proves=True) is not None and not refined
    assert solved(proves=False) is None and refined, "what is refused is, and is asked about again"


def test_the_shortest_that_is_proven_is_the_answer_not_the_shortest_that_seems_to_hold(
    table: to.Scene,
) -> None:
    crosses = to.Track.through([0.0, 2.0], [to.placement((0.5, y, 0.45)) for y in (0.9, -0.9)])
    asked = problem(table.add("box", to.Box(0.2, 0.2, 0.2), motion=crosses))
    motion = to.plan(problem(table)).require().trajectory
    program = SpaceTime().program(asked, np.linspace(motion(0.0), motion(motion.duration), asked.knots))
    longest, refused = 1.6 * motion.duration, 1.3 * motion.duration
    found = program.solve_from(motion, enough=longest, proves=lambda each: each.duration > refused)
    assert found.decoded.trajectory is not None, "the longest is"
    found = program.solve_from(motion, proves=lambda each: each.duration > refused)
    assert found.decoded.trajectory is not None
    assert refused < found.decoded.trajectory.duration < refused / PRECISION


def test_costs_that_ask_for_more_than_short_and_smooth_are_reduced(table: to.Scene) -> None:
    plain = problem(table)
    asked = replace(plain, costs=(*(plain.costs or ()), rest_posture({"panda_joint5": 0.1})))
    seed = np.linspace(list(START.values()), list(GOAL.values()), plain.knots)
    solvers = [SpaceTime().program(each, seed).solver for each in (plain, asked)]
    assert [solver.until_feasible for solver in solvers] == [True, False]


def test_the_arm_enters_a_revolving_door_in_phase(table: to.Scene) -> None:
    # Two wings of a wall turn about an axis in front of the arm, and leave no way past them at rest.
    turns = [to.placement((0.62, 0.0, 0.5), rpy=(0.0, 0.0, (0.8 * step) % 6.28)) for step in range(9)]
    door = to.Track.through([0.5 * step for step in range(9)], turns)
    result = to.plan(problem(table.add("door", to.Box(0.6, 0.04, 1.4), motion=door)))
    motion = proven(result)
    assert motion.duration < 4.0
    halted = table.add("door", to.Box(0.6, 0.04, 1.4), to.placement((0.62, 0.0, 0.5)))
    assert not to.judge(problem(halted), motion).verified


def test_the_arm_steps_aside_for_an_obstacle_that_sweeps_its_start(table: to.Scene) -> None:
    hand = table.placement_of("panda_hand", table.robot.positions(START)).translation
    goal = table.placement_of("panda_hand", table.robot.positions(GOAL)).translation
    places = [hand + offset for offset in ((0.0, -0.7, 0.0), (0.0, 0.0, 0.0), (0.9, 0.0, 0.0))]
    sweeps = to.Track.through([0.3, 0.7, 1.2], [to.placement(place) for place in places])
    # The goal is free later only, so that there is no running away from it for good.
    scene = table.add("ball", to.Sphere(0.08), motion=sweeps)
    scene = scene.add("guest", to.Sphere(0.12), to.placement(goal), expires=2.0)
    result = to.plan(problem(scene))
    motion = proven(result)
    assert 2.0 < motion.duration < 3.5
    assert any("what changes with time" in remark for remark in result.remarks)


@pytest.mark.parametrize("speed", [0.6, -0.6])
def test_a_start_in_motion_is_planned_among_dynamic_obstacles(table: to.Scene, speed: float) -> None:
    crosses = to.Track.through([0.0, 1.5], [to.placement((0.5, y, 0.45)) for y in (0.9, -0.9)])
    scene = table.add("box", to.Box(0.2, 0.2, 0.2), motion=crosses)
    asked = replace(problem(scene), start_velocity={"panda_joint1": speed})
    result = to.plan(asked)
    motion = proven(result)
    assert motion(0.0, 1) == pytest.approx(asked.start_velocities, abs=1e-6)
    assert result.method == "space-time" and "what moves" not in result.method


def test_the_method_can_be_chosen_by_name(table: to.Scene) -> None:
    crosses = to.Track.through([0.0, 2.0], [to.placement((0.5, y, 0.45)) for y in (0.9, -0.9)])
    result = to.plan(problem(table.add("box", to.Box(0.2, 0.2, 0.2), motion=crosses)), method="space-time")
    assert proven(result).duration < 1.3
    still = to.plan(problem(table), method="space-time")
    assert still.verified and still.method == "space-time"


def test_a_budget_ends_it(table: to.Scene) -> None:
    crosses = to.Track.through([0.0, 2.0], [to.placement((0.5, y, 0.45)) for y in (0.9, -0.9)])
    scene = table.add("box", to.Box(0.2, 0.2, 0.2), motion=crosses)
    whole = to.plan(problem(scene))
    assert whole.verified and whole.method == "space-time"
    alone = to.plan(problem(table)).counts[WORK]
    result = to.plan(problem(scene), budget=to.Budget(work=(alone + whole.counts[WORK]) // 2))
    assert result.status is to.Status.OUT_OF_WORK and result.stopped is not None


def test_a_deadline_and_a_stay_at_the_goal_are_held(table: to.Scene) -> None:
    goal = table.placement_of("panda_hand", table.robot.positions(GOAL))
    above = goal.translation + np.array((0.0, 0.0, 1.2))
    leaves = to.Track.through(
        [1.5, 1.9, 2.4, 2.8], [to.placement(p) for p in (above, goal.translation, goal.translation, above)]
    )
    scene = table.add("ball", to.Sphere(0.1), motion=leaves)
    crosses = to.Track.through([0.0, 2.0], [to.placement((0.5, y, 0.45)) for y in (0.9, -0.9)])
    scene = scene.add("box", to.Box(0.2, 0.2, 0.2), motion=crosses)
    first = proven(to.plan(problem(scene)))
    assert first.duration < 1.5
    stays = proven(to.plan(replace(problem(scene), dwell=1.0)))
    assert stays.duration > 2.4
    late = to.plan(replace(problem(scene), dwell=1.0, finish_by=2.0))
    assert not late.verified
    assert proven(to.plan(replace(problem(scene), finish_by=1.3))).duration <= 1.3
