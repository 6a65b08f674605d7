"""A closed cut is a proof: nothing on it is free, and what can be planned has none."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from trajopt_problems.arms import ur5

import trajopt as to
from tests.robots_for_tests import odd_arm
from trajopt.geometry import WorkCounts
from trajopt.planning.infeasibility import closed_cut, met_braking
from trajopt.verify import Judge


def between_walls(inner: float) -> to.Problem:
    """A UR5 between two walls that begin at a distance from its axis."""
    arm = ur5()
    walls = [(to.Box(1.4, 0.02, 3.0), to.placement((side * (inner + 0.7), 0.0, 0.0))) for side in (-1.0, 1.0)]
    scene = to.Scene(arm.robot).add("walls", walls, to.placement(rpy=(0.0, 0.0, -np.pi / 4)))
    start = {**arm.ready, "shoulder_lift_joint": -0.9, "elbow_joint": 1.2}
    goal = to.joint_positions({**start, "shoulder_pan_joint": start["shoulder_pan_joint"] + np.pi})
    return to.Problem(scene=scene, group=arm.group, start=start, goal=goal)


def test_nothing_on_the_cut_is_free() -> None:
    problem = between_walls(0.11)
    cut = closed_cut(problem)
    assert cut is not None and cut.pairs[0] == ("upper_arm_link", "walls")
    reduced, rng = problem.reduced, np.random.default_rng(0)
    judge, place = Judge(reduced), reduced.joint_names.index(cut.joint)
    start, goal = reduced.start_positions[place], reduced.start_positions[place] + np.pi
    assert start < cut.position < goal
    drawn = rng.uniform(reduced.limits.lower, reduced.limits.upper, (300, 6))
    drawn[:, place] = cut.position
    assert all(judge.examine(q).collisions for q in drawn)


def test_walls_with_a_gap_are_not_a_proof() -> None:
    problem = between_walls(0.45)
    assert closed_cut(problem) is None


@pytest.mark.parametrize("inner", [0.16, 0.2, 0.25, 0.3])
def test_solvable_problems_are_not_proven_impossible(inner: float) -> None:
    problem = between_walls(inner)
    if closed_cut(problem) is not None:
        assert not to.plan(problem).verified


def test_a_goal_that_fixes_no_joint_has_no_cut() -> None:
    problem = between_walls(0.11)
    arm = ur5()
    where = problem.scene.placement_of(arm.tip, problem.start_positions)
    asked = to.Problem(
        scene=problem.scene,
        group=arm.group,
        start=problem.start_positions,
        goal=to.frame_placement(arm.tip, where),
    )
    assert closed_cut(asked) is None


def test_a_robot_without_collision_bodies_has_no_cut_and_meets_nothing() -> None:
    robot = replace(to.load("planar2"), bodies=())
    problem = to.Problem(scene=to.Scene(robot), start=[0.0, 0.0], goal=[1.0, 1.0])
    assert closed_cut(problem) is None
    moving = replace(problem, start_velocity={robot.joint_names[0]: 0.1})
    assert met_braking(moving, WorkCounts()) is None


def test_meant_contact_closes_nothing() -> None:
    problem = between_walls(0.11)
    touched = problem.scene
    for link in ("upper_arm_link", "forearm_link", "shoulder_link"):
        touched = touched.allow_contact("meant", link, "walls", first=0.1)
    cut = closed_cut(replace(problem, scene=touched))
    assert cut is None or all("wrist" in first + second for first, second in cut.pairs)


def test_an_unbounded_slide_is_not_a_proof(tmp_path: Path) -> None:
    """No box holds all places of a joint that slides without limits: it may be beyond the sheet."""
    short = odd_arm(tmp_path)
    place = short.joint_names.index("reach")
    lower, upper = np.array(short.limits.lower), np.array(short.limits.upper)
    lower[place], upper[place] = -np.inf, np.inf
    endless = replace(short, limits=replace(short.limits, lower=lower, upper=upper))
    start = {"pan": -1.0, "reach": 0.1, "elbow": 0.3, "wrist": 0.0}
    proven: list[bool] = []
    for robot in (short, endless):
        scene = to.Scene(robot).add("sheet", to.Box(1.6, 0.02, 3.0), to.placement((0.95, 0.0, 0.0)))
        goal = to.joint_positions({**start, "pan": 1.0})
        proven.append(closed_cut(to.Problem(scene=scene, start=start, goal=goal)) is not None)
    assert proven == [True, False]


def test_a_way_beyond_half_a_turn_of_a_joint_with_one_limit_is_not_closed() -> None:
    """All that such a joint reaches was taken to end at half a turn."""
    arm = to.load("planar2")
    lower, upper = np.array(arm.limits.lower), np.array(arm.limits.upper)
    lower[1], upper[1] = -1.0, np.inf
    arm = replace(arm, limits=replace(arm.limits, lower=lower, upper=upper))
    scene = to.Scene(arm)
    for number, turn in enumerate(np.linspace(-1.0, np.pi, 24)):
        here = scene.placement_of("tool", arm.positions({"joint2": turn})).translation
        scene = scene.add(f"post {number}", to.Sphere(0.06), to.placement(here))
    problem = to.Problem(scene=scene, start=[-0.9, 4.3], goal=[0.9, 4.3])
    assert closed_cut(problem) is None
