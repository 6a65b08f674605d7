"""Distances of near pairs: closed forms, culling that loses nothing, counts, half-spaces, meshes."""

from pathlib import Path

import numpy as np
import pytest

import trajopt as to
from tests.oracles.query import PlainQuery
from tests.robots_for_tests import odd_arm
from trajopt.geometry import Query
from trajopt.scene.reducing import reduce_model
from trajopt.values.shapes.shapes import Shape

Body = type[PlainQuery] | type[Query]
both_bodies = pytest.mark.parametrize("body", [PlainQuery, Query])


def query(body: Body, scene: to.Scene) -> Query:
    return body(reduce_model(scene, "all", scene.robot.positions()))


def tip_distance(asked: Query, positions: list[float], thing: str) -> float:
    """Measure the tip's sphere against a thing."""
    bodies, pairs = asked.reduced.bodies, asked.reduced.pairs
    found = asked.close_pairs(np.array([positions]), np.full(len(pairs.margin), 10.0))
    for pair, distance in zip(found.pair, found.distance, strict=True):
        if {bodies[pairs.first[pair]].owner, bodies[pairs.second[pair]].owner} == {"tip", thing}:
            return float(distance)
    raise AssertionError(f"tip and {thing} were not measured")


@both_bodies
@pytest.mark.parametrize(
    ("shape", "closed_form"),
    [
        (to.Sphere(0.1), lambda p: np.linalg.norm(p) - 0.1),
        (to.Box(0.2, 0.2, 0.2), lambda p: np.linalg.norm(np.maximum(np.abs(p) - 0.1, 0))),
        (to.Cylinder(0.1, 0.3), lambda p: np.hypot(max(np.hypot(*p[:2]) - 0.1, 0), max(abs(p[2]) - 0.15, 0))),
        (to.Capsule(0.1, 0.3), lambda p: np.linalg.norm([*p[:2], max(abs(p[2]) - 0.15, 0)]) - 0.1),
        (to.Plane(), lambda p: p[2]),
    ],
    ids=lambda value: type(value).__name__,
)
def test_closed_forms(tmp_path: Path, shape: Shape, closed_form: object, body: Body) -> None:
    where = to.placement((0.9, 0.4, -0.1), rpy=(0.2, 0.1, 0.4))
    scene = to.Scene(odd_arm(tmp_path)).add("thing", shape, where)
    asked = query(body, scene)
    for positions in ([0.0, 0.1, 0.2, 0.3], [1.0, 0.2, -0.5, 1.0], [-0.6, 0.0, 0.8, 2.0]):
        full = scene.robot.positions(dict(zip(("pan", "reach", "elbow", "wrist"), positions, strict=True)))
        centre = scene.placement_of("tip", full) * np.array([0.06, 0.0, 0.0])
        expected = closed_form(where.inverse() * centre) - 0.04  # pyright: ignore[reportCallIssue]
        assert tip_distance(asked, positions, "thing") == pytest.approx(expected, abs=1e-6)


@both_bodies
def test_culling_loses_nothing(tmp_path: Path, body: Body) -> None:
    rng = np.random.default_rng(4)
    scene = to.Scene(odd_arm(tmp_path))
    for count in range(12):
        where = to.placement(rng.uniform(-0.9, 0.9, 3), rpy=rng.uniform(-3, 3, 3))
        scene = scene.add(f"box{count}", to.Box(*rng.uniform(0.02, 0.4, 3)), where)
    asked = query(body, scene)
    margin, counts = asked.reduced.pairs.margin, asked.counts
    at = rng.uniform(-1.0, 1.0, (20, 4))
    everything = asked.close_pairs(at, np.full(len(margin), 50.0))
    assert counts.distances == 20 * len(margin)
    near = asked.close_pairs(at, np.full(len(margin), 0.05))
    assert counts.distances < 1.5 * 20 * len(margin)
    expected = {
        (s, p)
        for s, p, d in zip(everything.sample, everything.pair, everything.distance, strict=True)
        if d < 0.05
    }
    assert {(int(s), int(p)) for s, p in zip(near.sample, near.pair, strict=True)} == expected


@both_bodies
def test_displacement_bounds_every_point(tmp_path: Path, body: Body) -> None:
    asked = query(body, to.Scene(odd_arm(tmp_path)))
    reduced = asked.reduced
    rng = np.random.default_rng(0)
    before = rng.uniform(-1, 1, (30, 4))
    after = before + rng.normal(size=(30, 4)) * 0.2
    bound = asked.displacement(before, after)
    robot = reduced.scene.robot
    for row in range(30):
        for link in ("turret", "slide", "fore", "tip", "finger"):
            one = reduced.scene.placement_of(link, reduced.all_positions(before[row]))
            other = reduced.scene.placement_of(link, reduced.all_positions(after[row]))
            for part in (part for part in robot.bodies if part.owner == link):
                centre = part.placement.translation
                assert np.linalg.norm(one * centre - other * centre) <= bound[row] + 1e-12


@both_bodies
def test_thin_cylinder_deep_inside_is_finite(tmp_path: Path, body: Body) -> None:
    """Coal's expanding polytope gives up on curved shapes at tight tolerances."""
    scene = to.Scene(odd_arm(tmp_path)).add("pole", to.Cylinder(0.05, 0.8), to.placement((0.6, 0.0, 0.3)))
    asked = query(body, scene)
    samples = np.random.default_rng(1).uniform([-0.3, 0, -1, -3], [0.3, 0.3, 1, 3], (300, 4))
    found = asked.close_pairs(samples, np.zeros(len(asked.reduced.pairs.margin)))
    assert len(found.distance) > 100
    assert np.abs(found.distance).max() < 1.0
    assert np.linalg.norm(found.normal, axis=1) == pytest.approx(1.0, abs=1e-6)
