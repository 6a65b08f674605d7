"""Gaps along directions: closed forms, and that no proposal of a distance library is believed."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from tests.oracles.judge_distances import PlainDistances
from tests.oracles.judge_geometry import CoalPairs, gap
from tests.oracles.largest_gap import largest_gap
from tests.verify.arms import joint, link, reduced, robot
from trajopt.robot.robot import Robot
from trajopt.scene.scene import Scene
from trajopt.values.arrays import Floats, Ints
from trajopt.values.placement import Placement, placement
from trajopt.values.shapes.mesh import Mesh
from trajopt.values.shapes.shapes import Box, Capsule, Cone, Cylinder, Plane, Shape, Sphere, convex
from trajopt.verify.checks.distances import support
from trajopt.verify.kernel.kinematics import Kinematics, Poses
from trajopt.verify.kernel.pair_distances import PairDistances

CLOUD = np.random.default_rng(1).normal(size=(20, 3))
SHAPES: tuple[Shape, ...] = (
    Box(0.2, 0.3, 0.1),
    Sphere(0.1),
    Cylinder(0.08, 0.3),
    Capsule(0.06, 0.2),
    Cone(0.1, 0.25),
    convex(CLOUD),
)


def surface(shape: Shape, rng: np.random.Generator, count: int = 4000) -> Floats:
    """Points of a shape, many of them on its boundary."""
    turn = rng.uniform(0.0, 2.0 * np.pi, count)
    circle = np.stack((np.cos(turn), np.sin(turn), np.zeros(count)), axis=1)
    ball = rng.normal(size=(count, 3))
    ball /= np.linalg.norm(ball, axis=1)[:, None]
    ends = rng.choice((-0.5, 0.5), count)[:, None] * (0.0, 0.0, 1.0)
    match shape:
        case Box():
            return rng.choice((-0.5, 0.5), (count, 3)) * (shape.x, shape.y, shape.z)
        case Sphere():
            return shape.radius * ball
        case Cylinder():
            return shape.radius * circle + shape.length * ends
        case Capsule():
            return shape.radius * ball + shape.length * ends
        case Cone():
            tip = rng.random(count)[:, None] < 0.5
            return np.where(
                tip,
                shape.length * np.array((0, 0, 0.5)),
                shape.radius * circle - shape.length * np.array((0, 0, 0.5)),
            )
        case _:
            return CLOUD


@pytest.mark.parametrize("shape", SHAPES, ids=lambda shape: type(shape).__name__)
def test_support_is_the_farthest_point(shape: Shape) -> None:
    rng = np.random.default_rng(2)
    directions = rng.normal(size=(50, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    farthest = (directions @ surface(shape, rng).T).max(axis=1)
    reach = support(shape, directions)
    assert (reach >= farthest - 1e-12).all()
    np.testing.assert_allclose(reach, farthest, atol=2e-3 if isinstance(shape, Sphere | Capsule) else 1e-5)


def test_a_plane_reaches_infinitely_far_and_a_mesh_to_its_corners() -> None:
    up = np.array([(0.0, 0.0, 1.0)])
    assert support(Plane(), up)[0] == np.inf
    hull = convex(CLOUD)
    assert support(Mesh(hull.vertices, hull.faces), up)[0] == CLOUD[:, 2].max()


def box_and_ball(seed: int) -> tuple[Placement, float]:
    """Where a ball of radius 0.05 is seen from a box of 0.3 by 0.2 by 0.1, and their distance."""
    rng = np.random.default_rng(seed)
    where = placement(rng.uniform(-0.4, 0.4, 3), rotation=Rotation.random(random_state=rng).as_matrix())
    outside = np.abs(where.translation) - np.array((0.15, 0.1, 0.05))
    if (outside > 0).any():
        return where, float(np.linalg.norm(np.maximum(outside, 0.0))) - 0.05
    return where, float(outside.max()) - 0.05


@given(seed=st.integers(0, 10**6))
@example(seed=35576)
@example(seed=3627)
@settings(max_examples=40, deadline=None)
def test_the_largest_gap_of_spheres_and_boxes(seed: int) -> None:
    where, expected = box_and_ball(seed)
    apart = float(np.linalg.norm(where.translation)) - 0.3
    assert largest_gap(Sphere(0.1), Sphere(0.2), where) == pytest.approx(apart, abs=1e-9)
    box = Box(0.3, 0.2, 0.1)
    assert largest_gap(box, Sphere(0.05), where) <= expected + 1e-12
    assert largest_gap(box, Sphere(0.05), where) == pytest.approx(expected, abs=1e-5)


def native_gap(arm: Robot, first: Shape, second: Shape, where: Placement) -> float:
    """The largest gap that the native core finds."""
    scene = Scene(arm).add("first", first).add("second", second, where, frame="a")
    kinematics = Kinematics(reduced(scene, [0.0]))
    item = np.zeros(1, dtype=np.int64)
    distances = PairDistances(kinematics, error=1e-12)
    return float(distances.search_depths(kinematics.poses(np.zeros((1, 1))), item, item)[0])


def test_the_largest_gap_is_found_on_ridges_too(tmp_path: Path) -> None:
    """Near a corner or an edge few directions lead to larger gaps: the searches still end at the largest."""
    arm = robot(tmp_path, link("base"), link("a"), joint("j", "base", "a"))
    box, ball = Box(0.3, 0.2, 0.1), Sphere(0.05)
    for seed in range(300):
        where, expected = box_and_ball(seed)
        assert largest_gap(box, ball, where) == pytest.approx(expected, abs=1e-9), seed
        assert native_gap(arm, box, ball, where) == pytest.approx(expected, abs=1e-9), seed


def test_the_largest_gap_is_found_among_lower_peaks(tmp_path: Path) -> None:
    """Each face of a hull around a ball is a peak, often narrower than the directions first tried."""
    arm = robot(tmp_path, link("base"), link("a"), joint("j", "base", "a"))
    hull, ball = convex(0.1 * CLOUD), Sphere(0.05)
    a, b, c = np.moveaxis(hull.vertices[hull.faces], 1, 0)
    normals = np.cross(b - a, c - a)
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    rng = np.random.default_rng(6)
    for _ in range(100):
        centre = rng.dirichlet(np.ones(len(hull.vertices))) @ hull.vertices
        expected = float(np.einsum("ij,ij->i", normals, centre - a).max()) - 0.05
        where = placement(centre)
        assert largest_gap(hull, ball, where) == pytest.approx(expected, abs=1e-9)
        assert native_gap(arm, hull, ball, where) == pytest.approx(expected, abs=1e-9)


def test_any_direction_gives_a_lower_bound() -> None:
    where = placement((0.5, 0.0, 0.0))
    directions = np.array([(1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (-1.0, 0.0, 0.0)])
    np.testing.assert_allclose(gap(Sphere(0.1), Sphere(0.2), where, directions), (0.2, -0.3, -0.8))


@pytest.mark.parametrize(
    ("distance", "normal"),
    [
        (9.0, (1.0, 0.0, 0.0)),
        (9.0, (0.0, 0.0, 0.0)),
        (-np.finfo(float).max, (np.nan,) * 3),
        (0.2, (0.0, 1.0, 0.0)),
    ],
)
def test_a_wrong_proposal_is_not_believed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, distance: float, normal: tuple[float, ...]
) -> None:
    """Whatever the distance library says, the gap along some direction is what counts."""
    arm = robot(tmp_path, link("base"), link("a"), joint("j", "base", "a"))
    scene = (
        Scene(arm).add("post", Box(0.2, 0.2, 0.2)).add("ball", Sphere(0.1), placement((0, 0.5, 0)), frame="a")
    )
    model = reduced(scene, [0.0])

    def lie(self: CoalPairs, poses: Poses, cell: Ints, pair: Ints) -> tuple[Floats, Floats]:
        return np.full(len(cell), distance), np.tile(np.array(normal), (len(cell), 1))

    monkeypatch.setattr(CoalPairs, "measure", lie)
    distances = PlainDistances(model, error=1e-12)
    poses = Kinematics(model).poses(np.zeros((1, 1)))
    found = distances.measure(poses, np.array([0]), np.array([0]))[0]
    assert found == pytest.approx(0.3, abs=1e-6)
    assert found <= 0.3
