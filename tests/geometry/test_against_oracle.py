"""The compiled query against the plain one: every shape, attached bodies, in penetration, along a motion."""

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

import trajopt as to
from tests.oracles.query import PlainDynamics, PlainQuery
from tests.robots_for_tests import odd_arm
from trajopt.geometry import Contacts, Query
from trajopt.geometry.dynamics import DynamicsQuery
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.reducing import reduce_model
from trajopt.values.arrays import Floats
from trajopt.values.shapes.mesh import Mesh
from trajopt.values.shapes.shapes import Box, Capsule, Cone, Cylinder, Plane, Shape, Sphere, convex

SHAPES: dict[str, Shape] = {
    "box": Box(0.3, 0.2, 0.25),
    "sphere": Sphere(0.15),
    "cylinder": Cylinder(0.12, 0.4),
    "capsule": Capsule(0.1, 0.2),
    "cone": Cone(0.2, 0.4),
    "plane": Plane(),
    "convex": convex(np.random.default_rng(3).normal(size=(40, 3)) * 0.12),
    "mesh": Mesh(
        np.array([[x, y, z] for x in (-0.2, 0.2) for y in (-0.15, 0.15) for z in (-0.1, 0.1)]),
        np.array([[0, 1, 3], [0, 3, 2], [4, 7, 5], [4, 6, 7], [0, 4, 5], [0, 5, 1]]),
    ),
}
EXACT = {"box", "sphere", "capsule", "plane", "convex"}
"""Where Coal's answer does not depend on how it got there; the others are good to its tolerance."""


def world(folder: Path, shape: Shape, rng: np.random.Generator, others: int = 6) -> ReducedModel:
    robot = odd_arm(folder)
    scene = to.Scene(robot).add("thing", shape, to.placement((0.5, 0.1, 0.25), rpy=rng.uniform(-1, 1, 3)))
    for count in range(others):
        where = to.placement(rng.uniform(-0.9, 0.9, 3), rpy=rng.uniform(-3, 3, 3))
        scene = scene.add(f"box{count}", Box(*rng.uniform(0.02, 0.4, 3)), where)
    held = Cylinder(0.03, 0.15)
    scene = scene.add(
        "held", held, to.placement((0.1, 0.02, 0.05)), frame="tip", touch_links=["tip", "finger"]
    )
    return reduce_model(scene, "all", robot.positions())


def limits(reduced: ReducedModel) -> tuple[Floats, Floats]:
    return np.maximum(reduced.limits.lower, -3.0), np.minimum(reduced.limits.upper, 3.0)


def keyed(found: Contacts) -> dict[tuple[int, int], int]:
    keys = [(int(s), int(p)) for s, p in zip(found.sample, found.pair, strict=True)]
    assert len(set(keys)) == len(keys)
    return {key: row for row, key in enumerate(keys)}


def compare(compiled: Contacts, plain: Contacts, reach: Floats, exact: bool) -> int:
    """Assert the same rows; return how many there were."""
    mine, theirs = keyed(compiled), keyed(plain)
    tolerance = 1e-9 if exact else 1e-6
    for key in mine.keys() ^ theirs.keys():
        source, row = (compiled, mine[key]) if key in mine else (plain, theirs[key])
        assert source.distance[row] > reach[key[1]] - tolerance, f"{key} is missing on one side"
    both = sorted(mine.keys() & theirs.keys())
    a, b = [mine[key] for key in both], [theirs[key] for key in both]
    np.testing.assert_allclose(compiled.distance[a], plain.distance[b], atol=tolerance)
    if exact:
        np.testing.assert_allclose(compiled.normal[a], plain.normal[b], atol=1e-6)
        np.testing.assert_allclose(compiled.jacobian[a], plain.jacobian[b], atol=1e-6)
    return len(both)


@pytest.mark.parametrize("name", SHAPES)
def test_random_configurations(name: str, tmp_path: Path) -> None:
    rng = np.random.default_rng(7)
    reduced = world(tmp_path, SHAPES[name], rng)
    compiled, plain = Query(reduced), PlainQuery(reduced)
    rows = penetrating = 0
    for reach in (0.05, 0.4):
        reaches = np.full(len(reduced.pairs.margin), reach)
        at = rng.uniform(*limits(reduced), (40, 4))
        found = plain.close_pairs(at, reaches)
        penetrating += int((found.distance < 0.0).sum())
        rows += compare(compiled.close_pairs(at, reaches), found, reaches, name in EXACT)
    assert rows > 200 and penetrating > 10


@pytest.mark.parametrize("seed", range(6))
def test_nothing_is_lost_along_a_changing_motion(seed: int, tmp_path: Path) -> None:
    """Bounds are kept from one call to the next; steps of all sizes, as an optimiser makes them."""
    rng = np.random.default_rng(seed)
    reduced = world(tmp_path, SHAPES["box"], rng, others=12)
    compiled = Query(reduced)
    reach = reduced.pairs.margin + rng.uniform(0.05, 0.3, len(reduced.pairs.margin))
    lower, upper = limits(reduced)
    ends = rng.uniform(lower, upper, (2, 4))
    motion = np.linspace(*ends, 37)
    rows = 0
    for size in (0.0, 1.0, 0.3, 0.1, 0.03, 0.01, 0.3, 0.003, 0.001, 0.0):
        motion = np.clip(
            motion + size * rng.normal(size=4) * np.sin(np.linspace(0, np.pi, 37))[:, None], lower, upper
        )
        rows += compare(
            compiled.close_pairs(motion, reach), PlainQuery(reduced).close_pairs(motion, reach), reach, True
        )
    assert rows > 30


def test_kinematics_and_displacement(tmp_path: Path) -> None:
    rng = np.random.default_rng(1)
    reduced = world(tmp_path, SHAPES["box"], rng)
    compiled, plain = Query(reduced), PlainQuery(reduced)
    start, end = rng.uniform(*limits(reduced), (2, 25, 4))
    one, other = compiled.kinematics(start), plain.kinematics(start)
    for name in ("rotation", "translation", "jacobian"):
        np.testing.assert_allclose(getattr(one, name), getattr(other, name), atol=1e-12)
    np.testing.assert_allclose(compiled.displacement(start, end), plain.displacement(start, end), atol=1e-12)


def test_work_is_saved_and_counted(tmp_path: Path) -> None:
    rng = np.random.default_rng(2)
    reduced = world(tmp_path, SHAPES["box"], rng, others=20)
    query = Query(reduced)
    reach = np.full(len(reduced.pairs.margin), 0.03)
    motion = np.linspace(*rng.uniform(*limits(reduced), (2, 4)), 60)
    query.close_pairs(motion, reach)
    first = query.counts.bounds, query.counts.distances
    query.close_pairs(motion + 1e-3, reach)
    assert query.counts.bounds - first[0] < 0.2 * first[0]
    assert query.counts.forward_kinematics == 120


def test_several_motions_on_several_threads(tmp_path: Path) -> None:
    rng = np.random.default_rng(3)
    reduced = world(tmp_path, SHAPES["convex"], rng)
    reach = np.full(len(reduced.pairs.margin), 0.1)
    motions = [np.linspace(*rng.uniform(*limits(reduced), (2, 4)), 50) for _ in range(12)]

    def distances(motion: Floats) -> Floats:
        query = Query(reduced)
        return np.concatenate(
            [query.close_pairs(motion + shift, reach).distance for shift in (0.0, 0.01, 0.02)]
        )

    alone = [distances(motion) for motion in motions]
    with ThreadPoolExecutor(4) as pool:
        together = list(pool.map(distances, motions))
    for one, other in zip(alone, together, strict=True):
        assert np.array_equal(one, other)


def test_a_foreign_object_is_refused(tmp_path: Path) -> None:
    from trajopt.native import proximity

    reduced = world(tmp_path, SHAPES["box"], np.random.default_rng(0))
    none = np.empty((0, 3))
    with pytest.raises(TypeError, match="pinocchio model"):
        proximity.Cell(
            model=reduced,  # pyright: ignore[reportArgumentType]
            expand=np.ascontiguousarray(reduced.mimic_matrix), offset=reduced.mimic_offset, geometries=[],
            solids=[], joint=np.empty(0, dtype=np.int64),
            rotation=np.empty((0, 3, 3)), translation=none, centre=none,
            half=none, first=np.empty(0, dtype=np.int64), second=np.empty(0, dtype=np.int64),
            accuracy=(1e-9, 1e-6, 1e-4),
        )  # fmt: skip


def test_arrays_of_the_wrong_shape_are_refused(tmp_path: Path) -> None:
    query = Query(world(tmp_path, SHAPES["box"], np.random.default_rng(0)))
    reach = np.full(len(query.reduced.pairs.margin), 0.1)
    with pytest.raises(ValueError, match="one position for each joint"):
        query.close_pairs(np.zeros((2, 3)), reach)
    with pytest.raises(ValueError, match="one reach and one aim for each pair"):
        query.close_pairs(np.zeros((2, 4)), reach[:-1])
    with pytest.raises(ValueError, match="as many ends as starts"):
        query.displacement(np.zeros((2, 4)), np.zeros((3, 4)))
    assert len(query.close_pairs(np.zeros((0, 4)), reach).distance) == 0


def test_torques(tmp_path: Path) -> None:
    rng = np.random.default_rng(5)
    reduced = world(tmp_path, SHAPES["box"], rng)
    states = rng.uniform(*limits(reduced), (20, 4)), rng.normal(size=(20, 4)), rng.normal(size=(20, 4))
    plain, compiled = PlainDynamics(reduced), DynamicsQuery(reduced)
    np.testing.assert_allclose(compiled.torque(*states), plain.torque(*states), atol=1e-10)
    with pytest.raises(ValueError, match="one number for each state and joint"):
        compiled.torque(states[0], states[1][:5], states[2])
    mine, theirs = compiled.torque_slopes(*states), plain.torque_slopes(*states)
    for name in ("torque", "position", "velocity", "acceleration"):
        np.testing.assert_allclose(getattr(mine, name), getattr(theirs, name), atol=1e-10, err_msg=name)
    held, expected = compiled.gravity(states[0]), plain.gravity(states[0])
    np.testing.assert_allclose(held.torque, expected.torque, atol=1e-10)
    np.testing.assert_allclose(held.position, expected.position, atol=1e-10)
    with pytest.raises(ValueError, match="one position for each joint"):
        compiled.gravity(states[0][:, :3])
