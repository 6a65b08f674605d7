"""Whole plans under requirements of each kind: what the program holds, the judge proves."""

import numpy as np
import pytest

import trajopt as to
from trajopt.planning import Plan
from trajopt.problem.requirements import Requirement
from trajopt.verify import Evidence

START = {"panda_joint2": -0.785, "panda_joint4": -2.356, "panda_joint6": 1.571, "panda_joint7": 0.785}
GOAL = {"panda_joint1": 0.9, **START}
TCP = "panda_hand_tcp"


@pytest.fixture(scope="module")
def panda() -> to.Robot:
    return to.load("panda")


def planned(panda: to.Robot, constraint: Requirement, scene: to.Scene | None = None) -> Plan:
    problem = to.Problem(
        scene=scene or to.Scene(panda),
        group="panda_arm",
        start=START,
        goal=to.joint_positions(GOAL),
        constraints=[constraint],
    )
    plan = to.plan(problem).require()
    (found,) = [check for check in plan.certificate.checks if check.name.startswith("path")]
    assert found.holds
    return plan


def tcp(panda: to.Robot, joints: dict[str, float]) -> np.ndarray:
    return to.Scene(panda).placement_of(TCP, panda.positions(joints)).translation


def test_a_point_stays_in_a_union_of_regions(panda: to.Robot) -> None:
    """Two boxes that leave the arc of the straight joint motion outside."""
    first, last = tcp(panda, START), tcp(panda, GOAL)
    middle, along = (first + last) / 2, np.append((last - first)[:2], 0.0)
    yaw = float(np.arctan2(along[1], along[0]))
    half = float(np.linalg.norm(along)) / 2
    box = to.Box(half + 0.1, 0.1, 0.1)
    union = [(box, to.placement(middle + sign * along / 4, rpy=(0, 0, yaw))) for sign in (-1.0, 1.0)]
    plan = planned(panda, to.position_in_region(TCP, union))
    (check,) = [check for check in plan.certificate.checks if check.name == "path: region"]
    assert check.evidence is Evidence.PROVEN
    assert check.value is not None
    assert check.value <= 1e-6


def test_a_point_stays_on_a_line(panda: to.Robot) -> None:
    first, last = tcp(panda, START), tcp(panda, GOAL)
    planned(panda, to.point_on_line(TCP, first, last - first, tolerance=0.01))


def test_a_point_stays_on_an_arc_and_at_a_distance(panda: to.Robot) -> None:
    first = tcp(panda, START)
    radius = float(np.hypot(*first[:2]))
    planned(
        panda, to.point_on_arc(TCP, to.placement((0, 0, first[2])), radius=radius, tolerance=0.005, sweep=1.0)
    )
    planned(panda, to.distance_between(TCP, "panda_link0", upper=float(np.linalg.norm(first)) + 0.01))


def test_a_camera_keeps_looking_at_a_point(panda: to.Robot) -> None:
    """The straight motion turns the hand's axis away; the target is between start and goal."""
    first, last = tcp(panda, START), tcp(panda, GOAL)
    target = (first + last) / 2 - np.array((0.0, 0.0, 0.4))
    planned_all = to.gaze(TCP, target, angle=0.55, nearest=0.3, farthest=0.7)
    plan = to.plan(
        to.Problem(
            scene=to.Scene(panda),
            group="panda_arm",
            start=START,
            goal=to.joint_positions(GOAL),
            constraints=[planned_all],
        )
    ).require()
    kinds = [check.name for check in plan.certificate.checks if check.name.startswith("path")]
    assert kinds == ["path: gaze", "path: distance", "path: distance"]


REGION = to.Box(0.1, 0.1, 0.1), to.placement((0.4, 0.3, 0.3))


@pytest.mark.parametrize(
    "goal",
    [
        [to.position_in_region(TCP, *REGION)],
        [to.position_in_region(TCP, [REGION, (to.Sphere(0.05), to.placement((0.3, -0.4, 0.4)))])],
        [
            to.point_on_line(TCP, (0.4, 0.3, 0.3), (0, 0, 1), length=0.4, tolerance=1e-3),
            to.axis_alignment(TCP, direction=(0, 0, -1), tolerance=0.05),
        ],
        [to.point_on_arc(TCP, to.placement((0.3, 0, 0.4)), radius=0.3, sweep=2.0, tolerance=1e-3)],
        [
            to.gaze(TCP, (0.5, 0.2, 0.0), angle=0.2, nearest=0.2, farthest=0.4),
            to.singularity_distance(TCP, 0.05),
        ],
        [to.coupled_joints({"panda_joint2": 1, "panda_joint4": 1}, -2.0, tolerance=0.01)],
    ],
    ids=["region", "union", "line", "arc", "gaze", "coupled"],
)
def test_goals_of_each_kind_are_found(panda: to.Robot, goal: list[Requirement]) -> None:
    """The search for goal configurations needs no knowledge of the kinds of requirements."""
    problem = to.Problem(scene=to.Scene(panda), group="panda_arm", start=START, goal=goal)
    plan = to.plan(problem).require()
    found = [check for check in plan.certificate.checks if check.name.startswith("goal")]
    assert len(found) >= len(goal)
    assert all(check.holds for check in found)
