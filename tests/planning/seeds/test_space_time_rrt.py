"""Paths through space and time: clear when they say, no faster than they may, and the same every time."""

from dataclasses import replace
from threading import Event

import numpy as np
import pytest

import trajopt as to
from tests.planning.moving.test_dynamic_search import GOAL, START, problem, table
from tests.verify.test_moving_things import sampled
from trajopt.optimise.methods.space_time import SpaceTime, SpaceTimeProgram
from trajopt.planning.budget import Budget, BudgetTracker, Stop, Stopped
from trajopt.planning.seeds.space_time_rrt import SPEED, SpaceTimeProblem, searched

__all__ = ["table"]  # a fixture


@pytest.fixture(scope="module")
def swept(table: to.Scene) -> to.Scene:
    """A ball sweeps the start from 0.5 s to 1 s, and a guest leaves the goal after 2 s."""
    hand, goal = (
        table.placement_of("panda_hand", table.robot.positions(at)).translation for at in (START, GOAL)
    )
    places = [hand + offset for offset in ((0.0, -0.7, 0.0), (0.0, 0.0, 0.0), (0.9, 0.0, 0.0))]
    sweeps = to.Track.through([0.3, 0.7, 1.2], [to.placement(place) for place in places])
    return table.add("ball", to.Sphere(0.08), motion=sweeps).add(
        "guest", to.Sphere(0.12), to.placement(goal), expires=2.0
    )


def program(scene: to.Scene) -> SpaceTimeProgram:
    asked = problem(scene)
    goal = np.array([GOAL[name] for name in asked.reduced.joint_names])
    line = np.linspace(asked.reduced.start_positions, goal, asked.knots)
    return SpaceTime().program(asked, line)


def stage(
    whole: SpaceTimeProgram, *, checks: int = 40_000, tracker: BudgetTracker | None = None
) -> SpaceTimeProblem:
    assert whole.obstacles is not None
    check = (tracker or BudgetTracker(Budget())).check
    return SpaceTimeProblem(
        whole.obstacles, whole.problem.limits, *whole.polyline[[0, -1]], 4.0, 0.0, checks, check
    )


def names(whole: SpaceTimeProgram) -> tuple[str, ...]:
    return whole.problem.reduced.joint_names


def test_a_path_is_clear_at_its_times_and_becomes_a_motion(swept: to.Scene) -> None:
    whole = program(swept)
    paths = [searched(stage(whole), names(whole), np.random.default_rng(3)) for _ in range(2)]
    path, again = paths
    assert path is not None and again is not None
    assert np.array_equal(path.positions, again.positions) and np.array_equal(path.times, again.times)
    assert path(0.0) == pytest.approx(whole.polyline[0]) and path(path.duration) == pytest.approx(
        whole.polyline[-1]
    )
    assert 2.0 <= path.duration <= 4.0
    speeds = np.abs(np.diff(path.positions, axis=0)) / np.diff(path.times)[:, None]
    assert (speeds <= SPEED * whole.problem.limits.velocity * (1.0 + 1e-6)).all()
    # Between two moments that are checked things may come nearer.
    assert sampled(swept, whole.problem.reduced, path) > -0.005
    solved = whole.solve_from(path)
    motion = solved.decoded.trajectory
    assert motion is not None and to.judge(whole.problem, motion).verified


def test_a_permanent_obstacle_leaves_no_path(table: to.Scene) -> None:
    wall = table.add("wall", to.Box(3.0, 0.04, 3.0), to.placement((1.2, 0.0, 0.5)), appears=0.2)
    whole = program(wall)
    assert searched(stage(whole, checks=3000), names(whole), np.random.default_rng(0)) is None


def test_a_goal_that_is_never_free_is_detected_before_the_search(swept: to.Scene) -> None:
    soon = replace(stage(program(swept)), latest=1.9)
    assert searched(soon, names(program(swept)), np.random.default_rng(3)) is None
    assert soon.checks > 39_000


def test_a_goal_that_is_seldom_free_is_reached_then(table: to.Scene) -> None:
    goal = table.placement_of("panda_hand", table.robot.positions(GOAL))
    # Between two of the evenly spaced times at which the tree would begin.
    scene = table.add("early", to.Sphere(0.12), goal, expires=2.6).add(
        "late", to.Sphere(0.12), goal, appears=2.8
    )
    whole = program(scene)
    path = searched(stage(whole), names(whole), np.random.default_rng(3))
    assert path is not None and 2.6 <= path.duration <= 2.8


def test_it_ends_on_request(swept: to.Scene) -> None:
    whole, over = program(swept), Event()
    over.set()
    with pytest.raises(Stopped) as ended:
        searched(stage(whole, tracker=BudgetTracker(Budget(), over)), names(whole), np.random.default_rng(0))
    assert ended.value.stop is Stop.CANCEL


def test_work_is_counted(swept: to.Scene) -> None:
    whole = program(swept)
    before = replace(whole.counts)
    asked = stage(whole, checks=2000)
    searched(asked, names(whole), np.random.default_rng(0))
    counted = whole.counts.since(before).forward_kinematics
    assert counted > 0 and asked.checks < 2000
