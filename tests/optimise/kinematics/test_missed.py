"""What a configuration misses is said in millimetres and degrees, each by itself."""

import re
import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import trajopt as to
from tests.robots_for_tests import odd_arm
from trajopt.optimise.kinematics.validity import missed_at
from trajopt.tasks.cartesian import follows_curve, line

INF = np.inf
START = {"shoulder_lift_joint": -1.2, "elbow_joint": 1.6, "wrist_2_joint": -1.5}
SCENE = to.Scene(to.load("ur5")).add("bag", to.Sphere(0.05), to.placement((0, 0, 5)))
HERE = SCENE.placement_of("tool0", SCENE.robot.positions(START))
OFF = HERE * to.placement((0.0121, 0, 0), rpy=(0, 0, 0.71), degrees=True)


def looking(farthest: float = INF) -> to.Requirement:
    """Look at a point 1 m ahead and 0.2 m aside: 11.3 deg off the axis, and 1.02 m away."""
    ahead = (HERE * to.placement((0.2, 0, 1))).translation
    return to.gaze("tool0", ahead, angle=np.deg2rad(10.3), farthest=farthest)


@pytest.mark.parametrize(
    ("required", "said"),
    [
        (lambda: to.frame_placement("tool0", OFF), "12 mm and 0.653 deg"),
        (lambda: to.frame_placement("tool0", OFF, rotation_tolerance=INF), "12 mm"),
        (lambda: to.frame_placement("tool0", OFF, position_tolerance=INF), "0.653 deg"),
        (lambda: to.axis_alignment("tool0", direction=(0, 0, 1), tolerance=3.1), "next to nothing"),
        (looking, "1.01 deg"),
        (lambda: looking(farthest=1.0), "19.8 mm and 1.01 deg"),
        (lambda: to.joint_positions({"elbow_joint": 1.5}), "5.72 deg"),
        (lambda: to.distance_between("tool0", "bag", lower=20.0), "15.26 m"),
        (lambda: to.gravity_torque(0.01), "0.191"),
    ],
)
def test_each_unit_is_reported_separately(required: Callable[[], to.Requirement], said: str) -> None:
    problem = to.Problem(scene=SCENE, group="manipulator", start=START, goal=required())
    assert missed_at(problem.reduced, problem.goals, problem.reduced.start_positions) == said


def test_a_curve_does_not_constrain_a_single_configuration() -> None:
    """It has no place along the curve; before, 0 was divided by 0, with a RuntimeWarning in every plan."""
    curve = follows_curve("tool0", line(OFF, OFF * to.placement((0.1, 0, 0))))
    problem = to.Problem(scene=SCENE, group="manipulator", start=START, goal=START, constraints=[curve])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        said = missed_at(problem.reduced, problem.requirements_at(0), problem.reduced.start_positions)
    assert said == "next to nothing"


def test_the_largest_error_of_several_is_reported() -> None:
    goals = (
        to.frame_placement("tool0", OFF, rotation_tolerance=INF),
        to.frame_placement("tool0", OFF * to.placement((0.1, 0, 0)), rotation_tolerance=0.01),
    )
    problem = to.Problem(scene=SCENE, group="manipulator", start=START, goal=goals)
    words = missed_at(problem.reduced, problem.goals, problem.reduced.start_positions)
    assert words.startswith("0.112 m and 0.1"), words


def test_unreachable_goal_reports_position_and_rotation_errors() -> None:
    """A cup upright on the flange, too low for the forearm: its place and its turn are missed, and no sum."""
    here = to.placement((0.0, 0.0, 1.1), rpy=(0, 90, 0), degrees=True)
    goal = to.frame_placement("tool0", here, rotation_tolerance=0.01)
    result = to.plan(to.Problem(scene=to.Scene(SCENE.robot), group="manipulator", start=START, goal=goal))
    said = f"{result.reason} {result.explain()}"
    assert re.search(r"misses the goal by [0-9.]+ m?m and [0-9.]+ deg", said) and "added up" not in said


def test_an_arm_with_fewer_joints_than_fixed_axes_gets_a_hint(tmp_path: Path) -> None:
    arm = to.Scene(odd_arm(tmp_path))
    there = arm.placement_of("tip", arm.robot.positions({"pan": 0.4})) * to.placement(rpy=(0.3, 0.2, 0.0))
    for turn, fixed, free in ((0.01, 6, "2"), ((0.01, 0.01, np.inf), 5, "one")):
        goal = to.frame_placement("tip", there, rotation_tolerance=turn)
        said = to.plan(to.Problem(scene=arm, start={}, goal=goal)).reason
        assert "; 4 joints move in group all, and the goal fixes" in said
        assert f"{fixed} axes of tip: leave {free} of them free" in said
        assert ("such as rotation_tolerance=inf" in said) is (turn == 0.01), "one axis is free already"
    goal = to.frame_placement("tip", to.placement((9.0, 0.0, 0.0)), rotation_tolerance=np.inf)
    assert "axes of tip" not in to.plan(to.Problem(scene=arm, start={}, goal=goal)).reason


def test_a_goal_of_a_frame_that_the_group_does_not_move_gets_a_hint() -> None:
    """The reason was a distance only, as if another place could be reached."""
    arms = to.Scene(to.load("two_pandas"))
    group, other = "left_panda_arm", "right_panda_hand_tcp"
    placed = to.frame_placement(other, to.placement((0.4, -0.4, 0.4)))
    relative = to.frame_placement(other, to.placement((0, 0, 0.1)), reference="right_panda_link5")
    for goal, against in ((placed, ""), (relative, " relative to right_panda_link5")):
        said = to.plan(to.Problem(scene=arms, group=group, start="left_ready", goal=goal)).reason
        assert f"; no joint of group {group} moves {other}{against}" in said
