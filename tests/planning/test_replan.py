"""Planning again on the way: near to what is left of the motion where that will do, anew where not."""

import subprocess
import sys
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import trajopt as to
from trajopt.optimise.methods.space_time import SpaceTimeProgram
from trajopt.planning import Budget, Status, Stop, Stopped, on_the_way, replan
from trajopt.planning.seeds import SeedKind
from trajopt.values.errors import ProblemError, ShapeError

ON_THE_WAY = """
import sys
import trajopt as to
from trajopt.planning import replan
problem = to.named_problem("past_pillar_ur5")
running = to.plan(problem).require().trajectory
before = set(sys.modules)
assert replan(problem, running, 0.3 * running.duration).verified
print(*sorted({name.split(".")[0] for name in set(sys.modules) - before} - {"numpy"}))
"""
NAMES = ("past_pillar_ur5", "past_pillar_xarm7", "bookshelf_panda")


@pytest.fixture(scope="module", params=NAMES)
def under_way(request: pytest.FixtureRequest) -> tuple[to.Problem, to.Trajectory, float]:
    """A problem, its motion, and a time on that."""
    problem = to.named_problem(request.param)
    running = to.plan(problem).require().trajectory
    return problem, running, 0.3 * running.duration


def near_the_end(problem: to.Problem, running: to.Trajectory, share: float, size: float) -> to.Scene:
    """Put a box beside the way that is left, so that what is left runs into it."""
    at = running((0.3 + 0.7 * share) * running.duration)
    frame = problem.scene.placement_of(
        problem.scene.robot.links[-1], problem.reduced.all_positions(at)
    ).translation
    return problem.scene.add("surprise", to.Box(size, size, size), to.placement(frame))


def joins(result: to.Result, running: to.Trajectory, time: float) -> None:
    """Both agree at that time in position, velocity and acceleration, and what is new ends at rest."""
    found = result.require().trajectory
    for order in range(3):
        assert found(0.0, order) == pytest.approx(running(time, order), abs=1e-6)
    assert np.abs(found(found.duration, 1)).max() <= 1e-6
    assert to.judge(result.problem, found).verified


def test_in_an_unchanged_world_the_rest_of_the_motion_is_the_answer(
    under_way: tuple[to.Problem, to.Trajectory, float],
) -> None:
    problem, running, time = under_way
    result = replan(problem, running, time)
    joins(result, running, time)
    assert result.method == "space-time" and "left of the running motion" in str(result)
    assert [each.kind for each in result.attempts] == [SeedKind.RUNNING] and result.won is result.attempts[0]
    left = running.duration - time
    assert left - 1e-9 <= result.require().trajectory.duration <= 1.05 * left
    anew = to.plan(on_the_way(problem, running, time))
    assert result.counts["forward_kinematics"] < 0.5 * anew.counts["forward_kinematics"]


def test_no_library_is_imported_while_a_robot_drives() -> None:
    done = subprocess.run([sys.executable, "-c", ON_THE_WAY], capture_output=True, text=True, check=True)
    assert not done.stdout.split()


def test_the_rest_of_the_motion_avoids_a_new_box(under_way: tuple[to.Problem, to.Trajectory, float]) -> None:
    problem, running, time = under_way
    changed = replace(problem, scene=near_the_end(problem, running, 0.5, 0.06))
    left = running.between(time, running.duration)
    if to.judge(on_the_way(changed, running, time), left).verified:
        pytest.skip("the box is not in the way")
    result = replan(changed, running, time)
    joins(result, running, time)


def test_a_goal_that_has_moved_is_led_to(under_way: tuple[to.Problem, to.Trajectory, float]) -> None:
    problem, running, time = under_way
    end = running(running.duration)
    goal = dict(zip(problem.reduced.joint_names, (end - 0.03).tolist(), strict=True))
    result = replan(replace(problem, goal=goal), running, time)
    joins(result, running, time)
    found = result.require().trajectory
    assert found(found.duration) == pytest.approx(end - 0.03, abs=1e-4)


def test_the_goal_of_a_set_that_is_nearest_is_kept() -> None:
    problem = to.named_problem("past_pillar_ur5")
    running = to.plan(problem).require().trajectory
    names, ends = problem.reduced.joint_names, (running(0.0), running(running.duration))
    far, near = (to.joint_positions(dict(zip(names, end.tolist(), strict=True))) for end in ends)
    asked = replace(problem, goal=to.any_of({"far": far, "near": near}))
    result = replan(asked, running, 0.4 * running.duration)
    assert result.verified and result.goal_name == "near" and result.method == "space-time"


def test_a_new_path_is_planned_and_counted_with_the_replan() -> None:
    problem = to.named_problem("past_pillar_ur5")
    running = to.plan(problem).require().trajectory
    back = dict(zip(problem.reduced.joint_names, running(0.0).tolist(), strict=True))
    asked, time = replace(problem, goal=back), 0.6 * running.duration
    result = replan(asked, running, time)
    joins(result, running, time)
    anew = to.plan(on_the_way(asked, running, time))
    assert result.method == anew.method == "free-duration"
    assert result.counts["forward_kinematics"] > anew.counts["forward_kinematics"]


def test_an_unreachable_goal_has_the_reason_of_planning() -> None:
    problem = to.named_problem("past_pillar_ur5")
    running = to.plan(problem).require().trajectory
    end = problem.reduced.all_positions(running(running.duration))
    at = problem.scene.placement_of("tool0", end).translation
    walled = replace(problem, scene=problem.scene.add("on the goal", to.Sphere(0.1), to.placement(at)))
    time = 0.2 * running.duration
    result = replan(walled, running, time)
    assert result.status is to.plan(on_the_way(walled, running, time)).status
    assert not result.verified and result.reason


def test_among_things_that_move_the_rest_of_the_motion_is_worked_on_in_time() -> None:
    problem = to.named_problem("past_pillar_ur5")
    running = to.plan(problem).require().trajectory
    time, away = 0.3 * running.duration, to.placement((2.0, 2.0, 0.5))
    track = to.Track.through([0.0, 2.0], [away, away * to.placement((0.5, 0.0, 0.0))])
    asked = replace(problem, scene=problem.scene.add("cart", to.Box(0.2, 0.2, 0.2), motion=track))
    result = replan(asked, running, time)
    joins(result, running, time)
    assert result.method == "space-time"


def test_at_its_end_or_after_it_there_is_nothing_left_to_begin_with() -> None:
    problem = to.named_problem("past_pillar_ur5")
    running = to.plan(problem).require().trajectory
    back = dict(zip(problem.reduced.joint_names, running(0.0).tolist(), strict=True))
    for time in (running.duration, running.duration + 1.0):
        result = replan(replace(problem, goal=back), running, time)
        assert result.verified and result.method == "sqp"


def test_a_budget_ends_it_with_a_reason() -> None:
    problem = to.named_problem("past_pillar_ur5")
    running = to.plan(problem).require().trajectory
    result = replan(problem, running, 0.5, budget=Budget(work=1))
    assert result.status is Status.OUT_OF_WORK and result.stopped is Stop.WORK and result.reason
    improved = replan(problem, running, 0.5, budget=Budget(attempts=2, improve=True))
    assert improved.verified and improved.method == "free-duration"


def test_returns_the_motion_proven_before_the_budget_ran_out(monkeypatch: pytest.MonkeyPatch) -> None:
    problem = to.named_problem("past_pillar_ur5")
    running = to.plan(problem).require().trajectory
    solve_from = SpaceTimeProgram.solve_from

    def stopped_late(self: SpaceTimeProgram, *given: Any, **named: Any) -> None:
        solve_from(self, *given, **named)
        raise Stopped(Stop.CLOCK)

    monkeypatch.setattr(SpaceTimeProgram, "solve_from", stopped_late)
    result = replan(problem, running, 0.3 * running.duration)
    assert result.verified and result.stopped is Stop.CLOCK
    joins(result, running, 0.3 * running.duration)


def test_misuse_is_refused() -> None:
    problem = to.named_problem("past_pillar_ur5")
    running = to.plan(problem).require().trajectory
    with pytest.raises(ShapeError, match=r"begins at 0 s; is -0\.1"):
        replan(problem, running, -0.1)
    with pytest.raises(ProblemError, match="running must be a Trajectory"):
        replan(problem, "motion", 0.1)  # pyright: ignore[reportArgumentType]
    with pytest.raises(ProblemError, match="give seconds once"):
        replan(problem, running, 0.1, seconds=1.0, budget=Budget(seconds=1.0))
