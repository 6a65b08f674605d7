"""Clearances and margins that no configuration can keep: proven, and named before any search."""

from pathlib import Path

import numpy as np
import pytest
from trajopt_problems.arms import ur5

import trajopt as to
from tests.robots_for_tests import odd_arm
from trajopt.geometry import Query, WorkCounts
from trajopt.planning.infeasibility import never_apart
from trajopt.planning.infeasibility.cover import NeverApart
from trajopt.planning.status import Certainty
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.reducing import reduce_model
from trajopt.values.arrays import Floats

NEAR = ("forearm_link", "wrist_2_link")
"""Links of a UR5 with two joints between, which are never 3 cm apart."""


def arm(scene: to.Scene) -> to.Problem:
    """Turn the shoulder of a UR5 by a radian."""
    known = ur5()
    start = {**known.ready, "shoulder_lift_joint": -1.2, "elbow_joint": 1.2}
    goal = to.joint_positions({**start, "shoulder_pan_joint": start["shoulder_pan_joint"] + 1.0})
    return to.Problem(scene=scene, group=known.group, start=start, goal=goal)


def apart(reduced: ReducedModel, pair: tuple[str, str], positions: Floats) -> Floats:
    """Measure two links at configurations, shape (S,) [m]."""
    mine = [set(reduced.owners(each)) == set(pair) for each in range(len(reduced.pairs.first))]
    found = Query(reduced).close_pairs(positions, np.where(mine, 10.0, -np.inf))
    distance = np.full(len(positions), np.inf)
    np.minimum.at(distance, found.sample, found.distance)
    return distance


def test_a_clearance_that_two_links_never_have_is_refused_before_the_search() -> None:
    scene = to.Scene(ur5().robot)
    result = to.plan(arm(scene.with_clearance(0.03)))
    assert result.status is to.Status.CLEARANCE_IMPOSSIBLE and result.certainty is Certainty.PROVEN
    assert "30 mm are required of forearm_link and wrist_2_link, which are" in result.message
    assert "in every configuration" in result.message and not result.attempts
    explained = result.explain(plan_again=True)
    assert explained.certainty is Certainty.PROVEN and "were closed one by one" in explained.grounds
    assert any("forearm_link and wrist_2_link lowered" in str(remedy) for remedy in explained.remedies)


@pytest.mark.parametrize("asked", [{"world": 0.03}, {"value": 0.03, "robot": 0.005}])
def test_the_same_clearance_from_the_world_alone_is_kept(asked: dict[str, float]) -> None:
    scene = to.Scene(ur5().robot).add("wall", to.Box(0.02, 1.0, 1.0), to.placement((1.2, 0, 0)))
    certificate = to.plan(arm(scene.with_clearance(**asked))).require().certificate
    rows = {check.name: check.bound for check in certificate.checks if check.name.startswith("clearance")}
    assert rows["clearance from the world"] == 0.03
    assert rows["clearance of the robot from itself"] == asked.get("robot", 0.0)


def test_the_bound_holds_at_all_configurations() -> None:
    reduced = arm(to.Scene(ur5().robot)).reduced
    limits, rng = reduced.limits, np.random.default_rng(5)
    measured = apart(reduced, NEAR, rng.uniform(limits.lower, limits.upper, (4000, 6)))
    (found,) = never_apart(reduced, {NEAR: 0.12}, WorkCounts())
    assert measured.max() <= found.most <= 0.03 and found.farthest <= found.most
    assert not never_apart(reduced, {NEAR: 0.9 * float(measured.max())}, WorkCounts())


def test_only_the_joints_between_two_links_are_searched() -> None:
    reduced, counts = arm(to.Scene(ur5().robot)).reduced, WorkCounts()
    assert never_apart(reduced, {NEAR: 0.1}, counts)
    assert counts.forward_kinematics < 60_000, "of six joints two count"
    away = WorkCounts()
    assert not never_apart(reduced, {("shoulder_link", "wrist_3_link"): 0.1}, away)
    assert away.forward_kinematics < 100, "the first look shows that there is room"


@pytest.mark.parametrize("seed", range(12))
def test_random_things_that_are_named_are_never_apart(tmp_path: Path, seed: int) -> None:
    rng = np.random.default_rng(seed)
    scene = to.Scene(odd_arm(tmp_path)).add("ball", to.Sphere(0.05), to.placement(rng.uniform(-0.3, 0.3, 3)))
    scene = scene.add("drill", to.Sphere(0.02), to.placement(rng.uniform(-0.1, 0.1, 3)), frame="tip")
    reduced = reduce_model(scene, "all", scene.robot.positions())
    pairs = sorted({tuple(sorted(reduced.owners(pair))) for pair in range(len(reduced.pairs.first))})
    asked = {pair: float(rng.choice([0.02, 0.1, 0.4, 1.0])) for pair in pairs}
    lower = np.maximum(reduced.limits.lower, -4.0)
    drawn = rng.uniform(lower, np.minimum(reduced.limits.upper, 4.0), (2000, len(lower)))
    named = never_apart(reduced, asked, WorkCounts())
    for found in named:
        assert apart(reduced, (found.first, found.second), drawn).max() <= found.most <= found.distance
    assert seed > 0 or named, "of the first something is found"


def test_a_margin_that_no_configuration_keeps_gives_way_and_is_named() -> None:
    problem = arm(to.Scene(ur5().robot).with_margin(0.05, *NEAR))
    result = to.plan(problem)
    assert result.verified and len(result.remarks) == 1
    assert "50 mm of margin are asked of forearm_link and wrist_2_link" in result.remarks[0]
    assert result.remarks[0] in str(result) and result.as_dict()["remarks"] == list(result.remarks)
    assert result.problem.scene.margin_of(*NEAR) == 0.01 and problem.scene.margin_of(*NEAR) == 0.05
    assert result.require().certificate.margin == (0.01, 0.01)


def test_a_margin_that_can_be_kept_stays_as_it_is() -> None:
    problem = arm(to.Scene(ur5().robot).with_margin(world=0.05))
    result = to.plan(problem)
    assert result.verified and not result.remarks and result.problem is problem


@pytest.mark.parametrize(
    "farthest,said",
    [
        (0.004, "are nearer (4.0 mm in the farthest measured) in every configuration"),
        (-0.09, "overlap (by 90.0 mm in the farthest measured) in every configuration"),
    ],
)
def test_overlapping_links_are_not_reported_with_negative_distance(farthest: float, said: str) -> None:
    pair = NeverApart(first="wrist", second="cup", distance=0.01, most=0.02, farthest=farthest)
    assert pair.words("are required of") == f"10 mm are required of wrist and cup, which {said}"
