"""Soft clearance: by an independent formula, and what it does to a plan."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import trajopt as to
from tests.robots_for_tests import odd_arm
from trajopt.geometry import Query
from trajopt.optimise import terms
from trajopt.planning import Plan
from trajopt.problem.motion import Motion
from trajopt.problem.smoothness import Acceleration, Velocity
from trajopt.values.errors import ObjectNotFound, ProblemError

BALL = 0.1


def scene(folder: Path) -> to.Scene:
    robot = odd_arm(folder)
    return to.Scene(robot).add("ball", to.Sphere(BALL), to.placement((0.75, 0.0, 0.25)))


def test_missing_distance_against_closed_form(tmp_path: Path) -> None:
    """The tip is a ball of 4 cm, 6 cm ahead of its frame."""
    reduced = to.Problem(
        scene=scene(tmp_path), group="all", start={}, goal=to.joint_positions({"pan": 1.0})
    ).reduced
    query, rng = Query(reduced), np.random.default_rng(4)
    residual = terms.soft_clearance(1e-3, pairs={("ball", "tip"): terms.SoftDistance(0.6, 9.0)}).residual
    seen = 0
    for _ in range(60):
        q = rng.uniform(np.maximum(reduced.limits.lower, -2.0), np.minimum(reduced.limits.upper, 2.0))
        tip = reduced.scene.placement_of("tip", reduced.all_positions(q)) * np.array((0.06, 0.0, 0.0))
        distance = float(np.linalg.norm(tip - (0.75, 0.0, 0.25))) - BALL - 0.04
        rows = residual.linearise(Motion.single(q, query))
        own = [set(reduced.owners(int(pair))) == {"ball", "tip"} for pair in rows.component]
        if distance < 0.6:
            seen += 1
            assert rows.value[own] == pytest.approx([3.0 * (0.6 - distance)], abs=1e-6)
        else:
            assert not any(own)
    assert 5 < seen < 60


def clearance_of_ball(plan: Plan) -> float:
    reduced = plan.problem.reduced
    positions = plan.trajectory(np.linspace(0.0, plan.trajectory.duration, 300))
    contacts = Query(reduced).close_pairs(positions, np.full(len(reduced.pairs.margin), 1.0))
    of_ball = np.array(["ball" in reduced.owners(int(pair)) for pair in contacts.pair])
    return float(contacts.distance[of_ball].min())


def test_a_plan_keeps_away_where_it_is_wished_and_only_there(tmp_path: Path) -> None:
    start = {"pan": -1.0, "reach": 0.1, "elbow": 0.3, "wrist": 0.0}
    problem = to.Problem(
        scene=scene(tmp_path), group="all", start=start, goal=to.joint_positions({**start, "pan": 1.0})
    )
    smooth = (terms.Cost(Velocity()), terms.Cost(Acceleration()))
    wished = replace(problem, costs=(*smooth, terms.soft_clearance(0.06, weight=1000.0)))
    weightless = {(link, "ball"): terms.SoftDistance(0.06, 0.0) for link in problem.scene.robot.links}
    elsewhere = replace(problem, costs=(*smooth, terms.soft_clearance(0.06, weight=1000.0, pairs=weightless)))
    near, far, same = (clearance_of_ball(to.plan(asked).require()) for asked in (problem, wished, elsewhere))
    assert far > near + 0.02
    assert same < near + 0.01


def test_bad_wishes_are_refused(tmp_path: Path) -> None:
    with pytest.raises(ProblemError, match="distance of a soft clearance"):
        terms.soft_clearance(0.0)
    with pytest.raises(ProblemError, match="weight of a soft clearance"):
        terms.soft_clearance(0.1, pairs={("a", "b"): terms.SoftDistance(0.1, -1.0)})
    problem = to.Problem(
        scene=scene(tmp_path),
        group="all",
        start={},
        goal=to.joint_positions({"pan": 1.0}),
        costs=[terms.soft_clearance(0.05, pairs={("tip", "bal"): terms.SoftDistance(0.1)})],
    )
    with pytest.raises(ObjectNotFound, match="ball"):
        to.plan(problem)
