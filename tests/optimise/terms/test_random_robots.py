"""Robots drawn at random: Jacobians against finite differences, both bodies of the query alike."""

import tempfile
from pathlib import Path

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

import trajopt as to
from tests.oracles.query import PlainQuery
from trajopt.geometry import Query
from trajopt.optimise.terms import constrain
from trajopt.problem.motion import Motion
from trajopt.problem.residual import WHOLE, Constraint
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.reducing import reduce_model
from trajopt.values.arrays import Floats

SHAPES = (
    '<box size="0.12 0.05 0.04"/>',
    '<cylinder radius="0.03" length="0.15"/>',
    '<sphere radius="0.04"/>',
    '<capsule radius="0.03" length="0.1"/>',
)


def numbers(values: Floats) -> str:
    return " ".join(f"{value:.6f}" for value in values)


def random_robot(rng: np.random.Generator) -> to.Robot:
    """Draw a chain, or a tree of two, of joints of every kind about any axes."""
    count = int(rng.integers(2, 7))
    text = '<robot name="random"><link name="base"/>'
    for index in range(count):
        parent = "base" if index == 0 else f"link{int(rng.integers(max(index - 2, 0), index))}"
        kind = rng.choice(["revolute", "revolute", "continuous", "prismatic"])
        limit = 'lower="-0.3" upper="0.3"' if kind == "prismatic" else 'lower="-2.5" upper="2.5"'
        limit = "" if kind == "continuous" else limit
        shape, axis = rng.choice(SHAPES), rng.normal(size=3)
        text += (
            f'<link name="link{index}"><collision><origin xyz="{numbers(rng.uniform(-0.1, 0.1, 3))}" '
            f'rpy="{numbers(rng.uniform(-3, 3, 3))}"/><geometry>{shape}</geometry></collision></link>'
            f'<joint name="joint{index}" type="{kind}"><parent link="{parent}"/><child link="link{index}"/>'
            f'<origin xyz="{numbers(rng.uniform(-0.3, 0.3, 3))}" rpy="{numbers(rng.uniform(-3, 3, 3))}"/>'
            f'<axis xyz="{numbers(axis / np.linalg.norm(axis))}"/>'
            f'<limit {limit} effort="10" velocity="1"/></joint>'
        )
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "random.urdf"
        path.write_text(text + "</robot>")
        return to.Robot.from_urdf(path)


def random_world(seed: int) -> tuple[ReducedModel, np.random.Generator]:
    rng = np.random.default_rng(seed)
    robot = random_robot(rng)
    scene = to.Scene(robot)
    for count in range(3):
        where = to.placement(rng.uniform(-0.6, 0.6, 3), rpy=rng.uniform(-3, 3, 3))
        scene = scene.add(f"box{count}", to.Box(*rng.uniform(0.05, 0.4, 3)), where)
    return reduce_model(scene, "all", robot.positions()), rng


def requirements(reduced: ReducedModel, rng: np.random.Generator) -> list[to.Requirement]:
    """Draw one of each kind that speaks of frames, with any frames, offsets and tolerances."""
    links = [link for link in reduced.scene.robot.links if link != "base"]
    frame, other = rng.choice(links, 2) if len(links) > 1 else (links[0], "box0")
    reference = str(rng.choice(["world", "box0", other])) if other != frame else "world"
    where = to.placement(rng.uniform(-0.5, 0.5, 3), rpy=rng.uniform(-1.5, 1.5, 3))
    direction = rng.normal(size=3)
    return [
        to.frame_placement(
            str(frame),
            where,
            reference=reference,
            offset=rng.uniform(-0.1, 0.1, 3),
            position_tolerance=rng.uniform(1e-3, 0.1, 3),
            coordinates=rng.choice(list(to.RotationCoordinates)),
        ),
        to.axis_alignment(str(frame), axis=rng.normal(size=3), direction=direction, tolerance=0.2),
        to.point_on_line(str(frame), where.translation, direction, tolerance=1e-2),
        to.point_on_plane(str(frame), where.translation, direction, tolerance=1e-2),
        to.gaze(str(frame), where.translation, angle=0.3, nearest=0.2, farthest=1.0),
    ]


def positions(reduced: ReducedModel, rng: np.random.Generator, count: int) -> Floats:
    low, high = np.maximum(reduced.limits.lower, -2.5), np.minimum(reduced.limits.upper, 2.5)
    return rng.uniform(low, high, (count, len(low)))


def values(item: Constraint, at: Floats, query: Query) -> Floats:
    return item.residual.linearise(Motion.each(at, query)).value


@settings(max_examples=60, deadline=None)
@given(seed=st.integers(0, 10**6))
def test_jacobians(seed: int) -> None:
    reduced, rng = random_world(seed)
    query, at, step = Query(reduced), positions(reduced, rng, 4), 1e-6
    direction = rng.normal(size=at.shape)
    for required in requirements(reduced, rng):
        for item in constrain(required, reduced, WHOLE):
            rows = item.residual.linearise(Motion.each(at, query))
            plus, minus = (values(item, at + sign * step * direction, query) for sign in (1.0, -1.0))
            if len(plus) != len(rows.value) or len(minus) != len(rows.value):
                continue  # the nearest member of a union changed in between
            predicted = np.einsum("mn,mn->m", rows.jacobian[:, 0], direction[rows.knots[:, 0]])
            numeric = (plus - minus) / (2.0 * step)
            # Angles wrap, and have a kink where two vectors point the same way: not more than one of many.
            off = np.abs(predicted - numeric) > 1e-4 * (1.0 + np.abs(numeric))
            assert off.sum() <= 1, f"{required}: {predicted[off]} is not {numeric[off]}"


@settings(max_examples=60, deadline=None)
@given(seed=st.integers(0, 10**6))
def test_bodies_of_the_query_agree(seed: int) -> None:
    reduced, rng = random_world(seed)
    compiled, plain, at = Query(reduced), PlainQuery(reduced), positions(reduced, rng, 5)
    for name in ("rotation", "translation", "jacobian"):
        one, other = (getattr(query.kinematics(at), name) for query in (compiled, plain))
        np.testing.assert_allclose(one, other, atol=1e-12)
    reach = np.full(len(reduced.pairs.margin), 0.2)
    mine, theirs = compiled.close_pairs(at, reach), plain.close_pairs(at, reach)
    found = dict(zip(zip(mine.sample, mine.pair, strict=True), mine.distance, strict=True))
    for sample, pair, distance in zip(theirs.sample, theirs.pair, theirs.distance, strict=True):
        if distance < 0.2 - 1e-4:
            # In penetration Coal's polytope is good to its own tolerance, the second of which is 1e-4.
            assert abs(found[(sample, pair)] - distance) < (1e-6 if distance > 0.0 else 1e-3)
