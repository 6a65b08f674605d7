"""Robots on wheels and slides: around a column to a table out of reach, out of buildings, far away."""

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from trajopt_problems.moving_bases import past_column_pr2, past_column_tiago

import trajopt as to
from tests.robots_for_tests import sliding_base, wheeled_base
from trajopt.optimise.kinematics import reduce_model
from trajopt.optimise.kinematics.inverse import random_starts
from trajopt.planning.budget import BudgetTracker
from trajopt.planning.seeds.sampled import knots_along
from trajopt.tasks.grasping.grasp import GraspingOptions
from trajopt.tasks.grasping.straight import along_line, to_configuration, track_line
from trajopt.verify import CheckKind


@pytest.fixture(scope="module")
def base(tmp_path_factory: pytest.TempPathFactory) -> to.Robot:
    return sliding_base(tmp_path_factory.mktemp("base"))


@pytest.fixture(scope="module")
def wheels(tmp_path_factory: pytest.TempPathFactory) -> to.Robot:
    return wheeled_base(tmp_path_factory.mktemp("wheels"))


def building(robot: to.Robot, half: float) -> to.Scene:
    scene = to.Scene(robot).add("front", to.Box(0.2, 2.0 * half, 2.0), to.placement((2.0, 0.0, 1.0)))
    for name, side in (("left", half), ("right", -half)):
        scene = scene.add(name, to.Box(4.0, 0.2, 2.0), to.placement((0.1, side, 1.0)))
    return scene


@pytest.mark.parametrize("half", [2.0, 4.0, 8.0])
def test_it_leaves_a_building_whose_door_is_behind_it(base: to.Robot, half: float) -> None:
    scene = building(base, half)
    problem = to.Problem(scene=scene, start=base.positions(), goal=to.joint_positions({"x": 4.0, "y": 0.0}))
    result = to.plan(problem)
    assert np.abs(result.require().trajectory.positions[:, 1]).max() > half
    assert len(result.attempts) <= 4, "a sampled path, no lucky bend"


@pytest.mark.parametrize("half", [1.5, 3.0, 6.0])
def test_on_wheels_it_leaves_too(wheels: to.Robot, half: float) -> None:
    goal = to.joint_positions({"world_joint/x": 4.0, "world_joint/y": 0.0, "world_joint/theta": 0.0})
    problem = to.Problem(scene=building(wheels, half), start=wheels.positions(), goal=goal)
    result = to.plan(problem)
    certificate = result.require().certificate
    assert certificate.verified and any(check.kind is CheckKind.ROLLING for check in certificate.checks)
    assert len(result.attempts) <= 8


@given(
    points=st.lists(st.tuples(*[st.floats(-5.0, 5.0)] * 3, st.floats(-2.0, 2.0)), min_size=2, max_size=6),
    segments=st.integers(20, 60),
)
def test_the_paths_of_wheels_roll(wheels: to.Robot, points: list[tuple[float, ...]], segments: int) -> None:
    reduced = reduce_model(to.Scene(wheels), "all", wheels.positions())
    corners = np.array(points)
    path = knots_along(corners, segments, reduced)
    assert path.shape == (segments + 1, 4)
    assert np.array_equal(path[[0, -1]], corners[[0, -1]])
    heading = (path[1:, 2] + path[:-1, 2]) / 2.0
    step = np.diff(path, axis=0)
    assert np.abs(np.cos(heading) * step[:, 1] - np.sin(heading) * step[:, 0]).max() < 1e-3


@pytest.mark.parametrize("away", [5.0, 50.0, 300.0])
def test_it_finds_a_placement_of_its_hand_far_away(base: to.Robot, away: float) -> None:
    start = base.positions({"x": 700.0, "y": -200.0})
    goal = to.frame_placement("boom", to.placement((700.0 + away, -200.0 - away, 0.9)))
    plan = to.plan(to.Problem(scene=to.Scene(base), start=start, goal=goal)).require()
    end = to.Scene(base).placement_of("boom", plan.trajectory.positions[-1]).translation
    assert np.abs(end - (700.0 + away, -200.0 - away, 0.9)).max() < 1e-3


def test_searches_for_a_goal_begin_near_where_it_stands(base: to.Robot) -> None:
    reduced = reduce_model(to.Scene(base), "all", base.positions({"x": 700.0, "y": -200.0}))
    begin = random_starts(reduced, np.random.default_rng(0), 50)
    assert np.abs(begin[:, :2] - (700.0, -200.0)).max() < np.pi


@pytest.mark.slow
@pytest.mark.parametrize("make", [past_column_pr2, past_column_tiago])
@pytest.mark.parametrize("draw", [None, 0, 1, 2])
def test_base_and_arm_reach_the_table(make: Callable[..., to.Problem], draw: int | None) -> None:
    problem = make(None if draw is None else np.random.default_rng(draw))
    base = problem.scene.robot.base.joints
    assert problem.reduced.joint_names[:3] == base
    plan = to.plan(problem).require()
    assert plan.certificate.verified
    travelled = plan.trajectory.positions[-1, :2] - plan.trajectory.positions[0, :2]
    assert np.linalg.norm(travelled) > 1.0, "no arm reaches so far"
    rolling = [check for check in plan.certificate.checks if check.kind is CheckKind.ROLLING]
    assert len(rolling) == (1 if make is past_column_tiago else 0)
    run = to.simulate(plan)
    assert run.diverged is None and not run.collisions and run.tracking_error.maximum.max() < 0.02


def test_a_tool_lowers_straight_after_a_long_drive() -> None:
    """The leg of 9 cm had one step of 24, on which base and arm together do not move the tool straight."""
    known = past_column_pr2()
    scene, group, tool = to.Scene(known.scene.robot), known.group, "r_gripper_tool_frame"
    far = to.frame_placement(tool, to.placement((4.0, 2.0, 0.9)))
    above = to.plan(to.Problem(scene=scene, group=group, start=known.start, goal=far)).require().trajectory
    arm = scene.robot.group(group)
    reduced = reduce_model(scene, arm.name, known.start)
    tracker = BudgetTracker(to.Budget(), None, None)
    low = track_line(reduced, tool, above.positions[-1], np.array((0.0, 0.0, -0.09)), tracker).end
    begin, end = (reduced.all_positions(each) for each in (above.positions[-1], low))
    straight = along_line(scene, begin, end, tool, GraspingOptions())
    problem = to.Problem(
        scene=scene,
        group=group,
        start=known.start,
        waypoints={"above": to_configuration(scene, group, begin)},
        goal=to_configuration(scene, group, end),
        constraints=[to.during(item, after="above") for item in straight],
    )
    result = to.plan(problem, budget=to.Budget(attempts=4))
    assert result.verified, result.explain()
