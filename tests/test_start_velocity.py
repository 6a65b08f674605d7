"""A start in motion: who takes it, what the judge makes of it, and what is refused."""

from dataclasses import replace

import numpy as np
import pytest

import trajopt as to
from tests.conftest import PLANAR_ARM
from trajopt.optimise.methods import method_named
from trajopt.optimise.methods.free_duration import FreeDuration
from trajopt.optimise.methods.timing import stopping_motion
from trajopt.optimise.terms import Cost, Velocity, Window
from trajopt.planning import on_the_way
from trajopt.planning.infeasibility.joint_bounds import at_time, by_then, least_travel
from trajopt.planning.judgement import judge
from trajopt.planning.status import Certainty
from trajopt.values.errors import JointNotFound, ProblemError, ShapeError

JOINT = "shoulder_pan_joint"


def moving(speed: float) -> to.Problem:
    return replace(to.named_problem("past_pillar_ur5"), start_velocity={JOINT: speed})


@pytest.mark.parametrize("speed", [0.4, -0.3])
def test_a_motion_starts_with_the_given_velocity(speed: float) -> None:
    problem = moving(speed)
    plan = to.plan(problem, method=FreeDuration()).require()
    velocities = plan.trajectory(0.0, 1)
    wanted = [speed if name == JOINT else 0.0 for name in problem.reduced.joint_names]
    assert velocities == pytest.approx(np.array(wanted), abs=1e-9)
    assert plan.trajectory(0.0, 2) == pytest.approx(np.zeros(len(wanted)), abs=1e-6)
    assert any(check.name == "start velocity" and check.holds for check in plan.certificate.checks)


@pytest.mark.parametrize("problem", ["past_pillar_ur5", "cup_past_pillar", "past_pillar_xarm7"])
@pytest.mark.parametrize("share", [0.15, 0.5, 0.85])
def test_a_running_motion_is_planned_on_from_any_moment(problem: str, share: float) -> None:
    asked = to.named_problem(problem)
    running = to.plan(asked).require().trajectory
    time = share * running.duration
    result = to.plan(on_the_way(asked, running, time))
    assert result.verified and result.method == "free-duration"
    assert "the start is in motion" in result.because and result.because in str(result)
    found = result.require().trajectory
    for order in range(3):
        assert found(0.0, order) == pytest.approx(running(time, order), abs=1e-6)
    names = {check.name for check in result.require().certificate.checks if check.holds}
    assert {"start velocity", "start acceleration"} <= names
    assert result.along_path is not None and found.duration <= result.along_path


@pytest.mark.parametrize(
    "problem", ["cup_through_gap_panda", "hand_on_plane_ur5", "two_arms_tray", "insertion_ur5"]
)
def test_path_constraints_are_held_on_from_any_moment_too(problem: str) -> None:
    """Where the arm comes to rest at its soonest they need not hold."""
    asked = to.named_problem(problem)
    running = to.plan(asked).require().trajectory
    assert to.plan(on_the_way(asked, running, 0.6 * running.duration)).verified


def test_a_start_at_rest_is_planned_as_before() -> None:
    problem = to.named_problem("past_pillar_ur5")
    for still in (problem, replace(problem, start_velocity={JOINT: 0.0})):
        result = to.plan(still)
        assert (result.method, result.because, result.along_path) == ("sqp", "", None)
        assert "method" not in str(result)


def test_a_single_attempt_picks_the_method_too() -> None:
    problem = moving(0.4)
    goal = to.goal_configurations(problem)[0]
    seed = np.linspace(problem.reduced.start_positions, goal, problem.knots)
    assert to.plan_once(problem, seed).verified


def test_the_judge_refuses_another_start() -> None:
    rest = to.plan(to.named_problem("past_pillar_ur5")).require().trajectory
    failed = [check.name for check in judge(moving(0.4), rest).failed]
    assert failed == ["start velocity"]
    other = replace(moving(0.0), start_acceleration={JOINT: 2.0})
    assert {check.name for check in judge(other, rest).failed} == {"start acceleration", "jerk"}


@pytest.mark.parametrize("method", ["sqp", "bspline", "ipopt"])
def test_methods_limited_to_a_start_at_rest_report_it(method: str) -> None:
    result = to.plan(moving(0.4), method=method_named(method))
    assert result.status is to.Status.METHOD_CANNOT and "rest" in result.message
    assert "free-duration" in result.message


def test_reports_a_moving_start_that_no_method_supports() -> None:
    early = Cost(Velocity(), window=Window(0.0, 0.5))
    result = to.plan(replace(moving(0.4), costs=(early,)))
    assert result.status is to.Status.METHOD_CANNOT
    assert "the start is in motion" in result.message and "part of the motion only" in result.message


def test_limits_of_tool_speeds_are_held_from_a_start_in_motion() -> None:
    asked = replace(to.named_problem("past_pillar_ur5"), tool_speed=to.tool_speed("tool0", linear=0.4))
    running = to.plan(asked).require().trajectory
    result = to.plan(on_the_way(asked, running, 0.4 * running.duration))
    assert any(check.name == "path: tool speed" for check in result.require().certificate.checks)
    fast = replace(
        on_the_way(asked, running, 0.4 * running.duration), tool_speed=to.tool_speed("tool0", linear=0.1)
    )
    refused = to.plan(fast, budget=to.Budget(attempts=1))
    assert refused.status is to.Status.START_TOO_FAST and refused.certainty is Certainty.PROVEN
    assert "the speed of tool0 is 3" in refused.message and "its limit is 100 mm/s" in refused.message


def test_a_start_in_motion_passes_waypoints_within_limits_of_tool_speeds() -> None:
    asked = to.named_problem("past_pillar_ur5")
    asked = replace(asked, scene=to.Scene(asked.scene.robot), start=[0.3, -1.2, 0.9, -1.0, 0.4, 0.2])
    asked = replace(asked, goal=[-1.5, -2.0, 1.9, 0.4, -1.0, 0.9], start_velocity={JOINT: 0.3})
    asked = replace(asked, waypoints=[[1.9, -0.6, -0.8, 1.2, 1.4, -0.8]])
    result = to.plan(replace(asked, tool_speed=to.tool_speed("tool0", linear=0.6)))
    assert result.verified, result.reason


def test_impossible_start_velocities_are_refused() -> None:
    with pytest.raises(ProblemError, match=r"its velocity limit is [0-9.]+ deg/s"):
        moving(1e3)
    with pytest.raises(ProblemError, match=r"its acceleration limit is [0-9.]+ deg/s\^2"):
        replace(moving(0.1), start_acceleration={JOINT: -1e3})
    for given in ("start_velocity", "start_acceleration"):
        with pytest.raises(JointNotFound, match=JOINT):
            replace(moving(0.1), **{given: {"shoulder_pan_join": 0.1}})
    assert f"{JOINT} at 22.92 deg/s" in str(moving(0.4))
    assert "at 57.3 deg/s^2" in str(replace(moving(0.1), start_acceleration={JOINT: 1.0}))


def test_standing_still_is_a_motion_too() -> None:
    problem = to.named_problem("past_pillar_ur5")
    here = dict(zip(problem.reduced.joint_names, problem.reduced.start_positions.tolist(), strict=True))
    assert to.plan(replace(problem, goal=to.joint_positions(here)), method=FreeDuration()).verified


def test_a_start_that_no_braking_keeps_within_the_limits_is_named_and_proven(planar_arm: to.Robot) -> None:
    problem = to.Problem(
        scene=to.Scene(planar_arm),
        group="arm",
        start={"shoulder": 0.0, "elbow": 2.2},
        goal=to.joint_positions({"shoulder": 0.5, "elbow": 0.0}),
        start_velocity={"elbow": 2.0},
    )
    # 2 rad/s at 4 rad/s^2 take 0.5 rad, and there are 0.3.
    result = to.plan(problem)
    assert result.status is to.Status.START_TOO_FAST and result.certainty is Certainty.PROVEN
    assert "elbow" in result.message and "upper limit" in result.message
    assert "17.19 deg before" in result.message and "28.65 deg" in result.message
    explained = result.explain(plan_again=True)
    assert explained.certainty is Certainty.PROVEN and "brake" in explained.grounds
    back = to.plan(replace(problem, start={"elbow": -2.2}, start_velocity={"elbow": -2.0}))
    assert back.status is to.Status.START_TOO_FAST and "lower limit" in back.message
    assert to.plan(replace(problem, start={"elbow": 1.9})).verified
    assert to.plan(replace(problem, start_velocity={"elbow": -2.0})).verified


def swinging_at_a_wall(speed: float) -> to.Problem:
    """Return a UR5 whose outstretched hand moves towards a wall 30 mm away."""
    start = {JOINT: 0.0, "shoulder_lift_joint": -0.6, "elbow_joint": 0.9, "wrist_1_joint": -0.3}
    scene = to.Scene(to.load("ur5")).add("wall", to.Box(1.5, 0.02, 1.5), to.placement((1.0, 0.33, 0.5)))
    return to.Problem(
        scene=scene,
        group="manipulator",
        start={**start, "wrist_2_joint": 0.0, "wrist_3_joint": 0.0},
        goal=to.joint_positions({**start, JOINT: -0.8}),
        start_velocity={JOINT: speed},
    )


def test_a_start_that_no_braking_keeps_off_an_obstacle_is_proven() -> None:
    result = to.plan(swinging_at_a_wall(2.0))
    assert result.status is to.Status.START_TOO_FAST and result.certainty is Certainty.PROVEN
    assert len(result.attempts) == 1 and "wrist_3_link and wall collide at 0.1" in result.message
    (remedy, *_) = result.explain(plan_again=True).remedies or ()
    assert remedy.what == "speed of the start" and remedy.words == "start at 53 % of the speed"
    assert remedy.problem.start_velocities.max() == pytest.approx(1.06)
    assert to.plan(swinging_at_a_wall(1.06)).verified


def test_samples_are_evidence_that_no_braking_avoids_an_obstacle() -> None:
    """Narrowly: no box proves it."""
    close = swinging_at_a_wall(2.0)
    problem = replace(close, scene=close.scene.move("wall", to.placement((1.0, 0.4, 0.5))))
    result = to.plan(problem)
    assert result.status is to.Status.START_TOO_FAST and result.certainty is Certainty.EVIDENCE
    assert "none of 256 configurations" in result.message
    assert "at random" in result.explain().grounds


def test_motions_from_a_start_in_motion_are_in_the_box_at_each_time() -> None:
    problem = swinging_at_a_wall(1.06)
    motion = to.plan(problem).require().trajectory
    for time in np.linspace(0.0, 0.5, 40).tolist():
        lower, upper = at_time(problem, time)
        assert (lower <= motion(time)).all() and (motion(time) <= upper).all()
        wide = by_then(problem, time)
        assert (wide[0] <= lower).all() and (upper <= wide[1]).all()
    assert at_time(problem, 0.1)[0][0] > 0.05, "it cannot be at the start any more"


def test_least_travel_matches_the_hardest_braking() -> None:
    """Against a fine integration of full jerk until the hardest deceleration, then that."""
    rng = np.random.default_rng(5)
    for _ in range(200):
        hardest, jerk = rng.uniform(1.0, 10.0), 10.0 ** rng.uniform(0.0, 3.0)
        speed, gain = rng.uniform(-2.0, 2.0), rng.uniform(-hardest, hardest)
        times = np.linspace(0.0, 20.0, 200_001)
        pull = np.maximum(gain - jerk * times, -hardest)
        step = times[1]
        speeds = speed + np.concatenate(((0.0,), np.cumsum((pull[1:] + pull[:-1]) / 2.0))) * step
        places = np.concatenate(((0.0,), np.cumsum((speeds[1:] + speeds[:-1]) / 2.0))) * step
        goes = (speeds > 1e-3).any()
        found = least_travel(speed, gain, hardest, jerk)
        if goes:
            last = int(np.flatnonzero(speeds > 0.0)[-1])
            assert found == pytest.approx(places[last], abs=1e-3)
        elif speeds.max() < 0.0:
            assert found == -np.inf


def test_a_stop_holds_the_limits_of_the_joints() -> None:
    asked, rng = to.named_problem("past_pillar_ur5"), np.random.default_rng(3)
    names, limits = asked.reduced.joint_names, asked.limits
    for _ in range(50):
        pull = rng.uniform(-1.0, 1.0, len(names)) * limits.acceleration
        # A speed that was reached with the acceleration, and from which it can be taken off again.
        room = limits.velocity - pull**2 / (2.0 * limits.jerk) - 0.01
        speed = rng.uniform(-1.0, 1.0, len(names)) * room
        stop = stopping_motion(
            replace(
                asked,
                start_velocity=dict(zip(names, speed.tolist(), strict=True)),
                start_acceleration=dict(zip(names, pull.tolist(), strict=True)),
            )
        )
        assert stop(0.0, 1) == pytest.approx(speed, abs=1e-12)
        assert stop(0.0, 2) == pytest.approx(pull, abs=1e-12)
        assert not stop.velocities[-1].any() and not stop.accelerations[-1].any()
        times = np.linspace(0.0, stop.duration, 3000)
        for order, most in ((1, limits.velocity), (2, limits.acceleration), (3, limits.jerk)):
            assert (np.abs(stop(times, order)) <= most * (1.0 + 1e-6)).all()


def test_time_that_runs_out_leaves_the_motion_that_there_was(planar_arm: to.Robot) -> None:
    """The clock stops in the middle of the improvement; the motion along the path is verified by then."""
    calls: list[float] = []

    def until_improved() -> float:
        return calls[-1] if calls else 0.0

    def progress(stage: str, step: object) -> None:
        seen.append(stage)
        if seen.count("optimise") and "verify" in seen and stage == "optimise":
            calls.append(1e9)

    seen: list[str] = []
    budget = to.Budget(seconds=10.0, clock=until_improved)
    result = to.plan(moving(0.4), budget=budget, progress=progress)
    assert result.verified and result.stopped_by_clock
    assert result.along_path == pytest.approx(result.require().trajectory.duration)


def test_joints_without_a_jerk_limit_stop_as_well(planar_arm: to.Robot) -> None:
    assert "jerk" not in PLANAR_ARM and np.isinf(planar_arm.limits.jerk).all()
    problem = to.Problem(
        scene=to.Scene(planar_arm),
        group="arm",
        start={"shoulder": 0.0, "elbow": 0.5},
        goal=to.joint_positions({"shoulder": 0.05, "elbow": 0.5}),
        start_velocity={"shoulder": 1.9, "elbow": -1.5},
        start_acceleration={"shoulder": 3.0, "elbow": 2.0},
    )
    assert to.plan(problem).verified


def test_a_problem_starts_where_the_running_motion_is() -> None:
    asked = to.named_problem("past_pillar_ur5")
    running = to.plan(asked).require().trajectory
    half = running.duration / 2.0
    turned = running.ordered(running.joint_names[::-1])
    for motion in (running, turned):
        ahead = on_the_way(asked, motion, half)
        assert np.array_equal(ahead.reduced.start_positions, running(half))
        assert np.array_equal(ahead.start_velocities, running(half, 1))
        assert np.array_equal(ahead.start_accelerations, running(half, 2))
    after = on_the_way(asked, running, running.duration + 1.0)
    assert not after.starts_moving
    assert np.array_equal(after.reduced.start_positions, running.positions[-1])
    with pytest.raises(ShapeError, match="begins at 0 s"):
        on_the_way(asked, running, -0.1)
    with pytest.raises(ProblemError, match="cannot start at"):
        on_the_way(replace(asked, velocity_scaling=0.05), running, half)


def test_the_motion_keeps_the_constraints_of_the_program() -> None:
    """Fast random starts, at which a longer duration would move the first control points."""
    asked, rng = to.named_problem("past_pillar_ur5"), np.random.default_rng(11)
    names, limits = asked.reduced.joint_names, asked.limits
    ended: list[to.Status] = []
    for number in range(6):
        pull = rng.uniform(-1.0, 1.0, len(names)) * limits.acceleration * (number % 2)
        speed = rng.uniform(-1.0, 1.0, len(names)) * (limits.velocity - pull**2 / (2.0 * limits.jerk))
        started = replace(
            asked,
            start_velocity=dict(zip(names, speed.tolist(), strict=True)),
            start_acceleration=dict(zip(names, pull.tolist(), strict=True)),
        )
        result = to.plan(started, budget=to.Budget(attempts=1))
        ended.append(result.status)
        if result.status is to.Status.NOT_VERIFIED:  # of others the program itself says what it does not hold
            assert "acceleration" not in result.message and "velocity" not in result.message
    assert ended.count(to.Status.SOLVED) >= 5
