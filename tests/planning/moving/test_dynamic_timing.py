"""Plans timed on their path: they stop on the way, pass before, or enter after, whichever is sooner."""

from dataclasses import replace

import numpy as np
import pytest

import trajopt as to
from tests.planning.moving.test_dynamic_search import GOAL, START, problem, table
from tests.verify.test_moving_things import sampled
from trajopt.geometry import Query
from trajopt.planning.moving.dynamic_timing import DynamicTiming
from trajopt.timing.time_scaling import begun_later

__all__ = ["table"]

GATE = to.Box(1.2, 0.04, 3.0)
"""From in front of the base to beyond the arm's reach, from below the floor to above the reach."""


def gate(
    scene: to.Scene, name: str, y: float, *, appears: float | None = None, expires: float | None = None
) -> to.Scene:
    return scene.add(name, GATE, to.placement((0.75, y, 0.5)), appears=appears, expires=expires)


def alone(table: to.Scene) -> to.Trajectory:
    return to.plan(problem(table)).require().trajectory


def rests(motion: to.Trajectory) -> tuple[float, float]:
    """Return how long a motion rests before it moves, and how long on its way [s]."""
    t = np.linspace(0.0, motion.duration, 4001)
    still = np.abs(motion(t, 1)).max(axis=1) < 1e-9
    begins = int((~still).argmax())
    return float(t[begins]), float(still[begins:-2].sum() * (t[1] - t[0]))


def test_it_passes_one_gate_before_it_closes_and_stops_until_the_next_opens(table: to.Scene) -> None:
    still = alone(table)
    scene = gate(gate(table, "early", -0.35, appears=0.4, expires=5.0), "late", 0.25, expires=1.5)
    asked = problem(scene)
    timing = DynamicTiming.of(asked, Query(asked.reduced))
    assert timing is not None
    timed = next(each for each in timing.timings(still) if to.judge(asked, each.trajectory).verified)
    motion = timed.trajectory
    before, between = rests(motion)
    assert before < 0.1 and between > 0.3, "it has to leave at once, and to stop on its way"
    assert motion.duration < 1.5 + 0.6 * still.duration
    assert sampled(scene, asked.reduced, motion) > 0.0
    (said,) = timed.remarks
    assert said.startswith("stops at 3") and said.endswith(" s, for late") and "% of the path for 0.7" in said
    found = to.plan(asked).require().trajectory
    assert found.duration <= motion.duration, "or another way, if that is sooner"


def test_with_a_tool_speed_limit_a_remark_names_the_stop_and_its_obstacle(table: to.Scene) -> None:
    scene = gate(gate(table, "early", -0.35, appears=0.6, expires=5.0), "late", 0.25, expires=1.8)
    asked = replace(problem(scene), tool_speed=to.tool_speed("panda_hand", linear=1.2))
    result = to.plan(asked)
    certificate = result.require().certificate
    (said,) = result.remarks
    assert said.startswith("stops at") and said.endswith("for late"), said
    assert f"note     {said}" in str(result)
    motion = result.require().trajectory
    assert rests(motion)[1] > 0.2 and sampled(scene, asked.reduced, motion) > 0.0
    assert certificate.verified and "path: tool speed" in [each.name for each in certificate.checks]


def test_waiting_for_a_crossing_obstacle_beats_the_detour(table: to.Scene) -> None:
    ends = [to.placement((x, 0.0, 0.35)) for x in (1.2, 0.5, 1.2)]
    scene = table.add("box", to.Box(0.1, 0.1, 1.0), motion=to.Track.through([0.0, 0.5, 1.0], ends))
    motion = to.plan(problem(scene)).require().trajectory
    stands = table
    for number, x in enumerate(np.arange(0.5, 1.2, 0.1).tolist()):
        stands = stands.add(f"box {number}", to.Box(0.1, 0.1, 1.0), to.placement((x, 0.0, 0.35)))
    detour = to.plan(problem(stands)).require().trajectory
    assert motion.duration < detour.duration
    assert sampled(scene, problem(scene).reduced, motion) > 0.0


def test_it_passes_before_a_late_obstacle(table: to.Scene) -> None:
    still = alone(table)
    ends = [to.placement((0.5, y, 0.4)) for y in (1.2, -1.2)]
    scene = table.add("box", to.Box(0.8, 0.1, 1.5), motion=to.Track.through([0.0, 6.0], ends))
    towards = replace(problem(scene), start=START, goal=to.joint_positions({**GOAL, "panda_joint1": 0.3}))
    result = to.plan(towards)
    assert result.verified and not result.remarks
    assert result.require().trajectory.duration < still.duration
    later = begun_later(result.require().trajectory, 3.0)
    assert not to.judge(result.problem, later).verified, "later it would be in the way"


def test_timing_alone_does_not_pass_an_obstacle_parked_on_the_path(table: to.Scene) -> None:
    lands = to.Track.through([0.0, 0.3], [to.placement((0.55, 0.0, z)) for z in (1.4, 0.2)])
    scene = table.add("box", to.Box(0.08, 0.08, 0.5), motion=lands)
    asked = problem(scene)
    timing = DynamicTiming.of(asked, Query(asked.reduced))
    assert timing is not None and list(timing.timings(alone(table))) == []
    result = to.plan(asked)
    assert result.verified
    ways = [np.asarray(result.require().path.knots), np.asarray(to.plan(problem(table)).require().path.knots)]
    assert ways[0].shape != ways[1].shape or np.abs(ways[0] - ways[1]).max() > 0.05, "another way"


def test_motions_beyond_the_deadline_are_not_timed(table: to.Scene) -> None:
    still = alone(table)
    asked = problem(gate(table, "wall", 0.3, expires=2.0))
    timing = DynamicTiming.of(asked, Query(asked.reduced))
    assert timing is not None
    soonest = next(timing.timings(still)).trajectory.duration
    assert soonest > 2.0
    latest = 1.02 * soonest
    assert all(each.trajectory.duration <= latest + 1e-9 for each in timing.timings(still, latest))
    assert list(timing.timings(still, 0.9 * soonest)) == []


def test_it_starts_early_and_enters_after_the_obstacle_expires(table: to.Scene) -> None:
    still = alone(table)
    scene = gate(table, "wall", 0.3, expires=2.0)
    result = to.plan(problem(scene))
    motion = result.require().trajectory
    assert motion.duration < 2.0 + 0.6 * still.duration
    assert np.abs(motion(1.98) - motion(0.0)).max() > 0.3, "well on its way when the wall goes"
    assert sampled(scene, result.problem.reduced, motion) > 0.0


def test_a_start_that_is_swept_is_left_in_time(table: to.Scene) -> None:
    hand = table.placement_of("panda_hand", table.robot.positions(START)).translation
    comes = to.Track.through(
        [0.2, 0.6, 4.0], [to.placement((*hand[:2], z)) for z in (hand[2] + 1.0, hand[2], hand[2])]
    )
    scene = gate(table, "late", 0.3, expires=1.6).add("ball", to.Sphere(0.1), motion=comes)
    result = to.plan(problem(scene))
    motion = result.require().trajectory
    assert rests(motion)[0] < 0.3 and motion.duration < 1.6 + 0.6 * alone(table).duration
    assert sampled(scene, result.problem.reduced, motion) > 0.0


def test_a_motion_that_starts_fast_brakes_for_an_obstacle(table: to.Scene) -> None:
    asked = replace(problem(gate(table, "wall", 0.25, expires=1.2)), start_velocity={"panda_joint1": 0.6})
    still = to.plan(replace(asked, scene=table)).require().trajectory
    timing = DynamicTiming.of(asked, Query(asked.reduced))
    assert timing is not None
    timed = next(each for each in timing.timings(still) if to.judge(asked, each.trajectory).verified)
    assert timed.remarks[0].startswith("stops at") and timed.trajectory.duration < 1.2 + still.duration
    assert timed.trajectory(0.0, 1)[0] == pytest.approx(0.6)
    assert to.plan(asked).require().trajectory.duration <= timed.trajectory.duration


@pytest.mark.parametrize("jerk", [False, True])
def test_a_planar_arm_stops_between_two_gates(*, jerk: bool) -> None:
    robot = to.load("planar2")
    robot = robot if jerk else replace(robot, limits=replace(robot.limits, jerk=np.full(2, np.inf)))
    scene = to.Scene(robot)
    ball = to.Sphere(0.06)
    scene = scene.add("first", ball, to.placement((1.0, -0.6, 0.0)), appears=0.9, expires=9.0)
    scene = scene.add("second", ball, to.placement((1.1, 0.5, 0.0)), expires=2.0)
    asked = to.Problem(
        scene=scene,
        start={"joint1": -1.2, "joint2": 0.1},
        goal=to.joint_positions({"joint1": 1.2, "joint2": 0.1}),
    )
    result = to.plan(asked)
    motion = result.require().trajectory
    assert motion.duration < 3.5 and sampled(scene, asked.reduced, motion) > 0.0
