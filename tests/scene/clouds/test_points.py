"""Clouds as shapes: what they take and refuse, how they are thinned, kept and shown."""

import copy
import pickle
import tracemalloc
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import trajopt as to
from trajopt.files.bundle import read_bundle, save
from trajopt.values.errors import ShapeError, SizeError
from trajopt.values.shapes.clouds import cloud_surface, fewer
from trajopt.values.shapes.shapes import bounding_box, bounding_sphere, scaled


def some(count: int = 200, seed: int = 0) -> np.ndarray:
    return np.random.default_rng(seed).uniform(-0.4, 0.7, (count, 3))


def test_points_are_copied_and_read_only() -> None:
    given_points = some()
    cloud = to.Points(given_points, 0.01)
    given_points[0] = 9.0
    assert cloud.points[0, 0] < 1.0
    assert not cloud.points.flags.writeable
    assert to.Points(some().astype(np.float32).tolist(), 1).radius == 1.0


def test_a_point_that_is_not_finite_is_named_by_its_number() -> None:
    points = some()
    points[17, 2] = np.nan
    points[40] = np.inf
    with pytest.raises(ShapeError, match=r"not finite at \[17\].*and 1 more"):
        to.Points(points, 0.01)


@pytest.mark.parametrize("empty", ((), np.empty((0, 3)), [[]]))
def test_an_empty_cloud_is_refused(empty: object) -> None:
    with pytest.raises(ShapeError):
        to.Points(empty, 0.01)  # pyright: ignore[reportArgumentType]
    with pytest.raises(ShapeError):
        to.Voxels(empty, 0.01)  # pyright: ignore[reportArgumentType]


def test_an_empty_cloud_is_refused_with_a_remedy() -> None:
    with pytest.raises(ShapeError, match=r"is empty: omit the object"):
        to.Points(np.empty((0, 3)), 0.01)


@pytest.mark.parametrize("radius", (0.0, -1.0, np.nan, np.inf, 51.0, "x", None))
def test_a_radius_that_is_none_is_refused(radius: float) -> None:
    with pytest.raises(ShapeError, match="radius"):
        to.Points(some(), radius)
    with pytest.raises(ShapeError, match="size"):
        to.Voxels(np.eye(3, dtype=np.int64), radius)


def test_millimetres_are_suggested() -> None:
    with pytest.raises(SizeError, match="millimetres"):
        to.Points(1000.0 * some(), 0.01)


@pytest.mark.parametrize(
    "keys", (np.full((1, 3), 0.5), np.full((2, 3), np.nan), np.full((1, 3), 1e300), "abc")
)
def test_keys_are_whole_numbers(keys: object) -> None:
    with pytest.raises(ShapeError, match="keys"):
        to.Voxels(keys, 0.01)  # pyright: ignore[reportArgumentType]


def test_cells_count_once_and_keep_their_place() -> None:
    cells = to.Voxels(np.array([(1, 0, -2), (0, 0, 0), (1, 0, -2)]), 0.1)
    assert len(cells) == 2
    lower, upper = bounding_box(cells)
    assert np.allclose(lower, (0.0, 0.0, -0.2))
    assert np.allclose(upper, (0.2, 0.1, 0.1))
    assert np.allclose(cells.centres[1], (0.15, 0.05, -0.15))


@settings(max_examples=60, deadline=None)
@given(seed=st.integers(0, 999), cell=st.floats(1e-3, 0.5), radius=st.floats(1e-4, 0.1))
def test_thinned_balls_contain_every_ball(seed: int, cell: float, radius: float) -> None:
    cloud = to.Points(some(300, seed), radius)
    thin = cloud.thinned(cell)
    apart = np.linalg.norm(cloud.points[:, None] - thin.points, axis=2).min(axis=1)
    assert (apart + cloud.radius <= thin.radius).all()
    assert thin.radius - cloud.radius <= cell * np.sqrt(3.0) / 2.0 * (1.0 + 1e-9)
    occupied = np.floor((cloud.points - cloud.points.min(axis=0)) / cell).astype(int)
    assert len(thin) == len(np.unique(occupied, axis=0))


def test_tiny_cells_keep_every_point() -> None:
    cloud = to.Points(some(50), 0.01)
    thin = cloud.thinned(1e-9)
    assert len(thin) == 50
    assert np.allclose(np.sort(thin.points, axis=0), np.sort(cloud.points, axis=0))


def test_bounds_hold_every_ball_and_cube() -> None:
    cloud, cells = to.Points(some(), 0.03), to.Voxels(np.round(some() * 20).astype(int), 0.05)
    centre, radius = bounding_sphere(cloud)
    assert (np.linalg.norm(cloud.points - centre, axis=1) + cloud.radius <= radius + 1e-12).all()
    lower, upper = bounding_box(cloud)
    assert np.allclose(lower, cloud.points.min(axis=0) - 0.03)
    assert np.allclose(upper, cloud.points.max(axis=0) + 0.03)
    centre, radius = bounding_sphere(cells)
    corners = cells.centres[:, None] + np.array(np.meshgrid(*[(-0.025, 0.025)] * 3)).reshape(3, 8).T
    assert (np.linalg.norm(corners - centre, axis=2) <= radius + 1e-12).all()


def test_scaled_about_a_point() -> None:
    cloud = to.Points(np.array([(1.0, 0.0, 0.0)]), 0.1)
    twice = scaled(cloud, 2.0, np.array((0.5, 0.0, 0.0)))
    assert isinstance(twice, to.Points)
    assert np.allclose(twice.points, (1.5, 0.0, 0.0))
    assert twice.radius == pytest.approx(0.2)


def test_copies_pickles_and_prints() -> None:
    for cloud in (to.Points(some(), 0.01), to.Voxels(np.round(some() * 9).astype(int), 0.05)):
        _ = cloud.sphere
        for other in (copy.copy(cloud), copy.deepcopy(cloud), pickle.loads(pickle.dumps(cloud))):
            assert type(other) is type(cloud)
            assert len(other) == len(cloud)
            assert np.array_equal(bounding_box(other), bounding_box(cloud))
    assert repr(to.Points(some(), 0.01)) == "Points(200 points, radius=0.01)"
    assert repr(to.Voxels(np.array([(0, 0, 0)]), 0.05)) == "Voxels(1 cell, size=0.05)"


def test_a_million_points_take_little_memory() -> None:
    many = np.random.default_rng(0).uniform(-1.0, 1.0, (1_000_000, 3))
    empty = to.Scene(to.load("planar2"))
    tracemalloc.start()
    cloud = to.Points(many, 0.002)
    scene = empty.add("room", cloud)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert len(cloud) == 1_000_000
    assert scene.object("room").parts[0][0] is cloud
    assert peak < 2 * many.nbytes


def test_fewer_contain_all() -> None:
    cloud = to.Points(some(3000), 0.01)
    few = fewer(cloud, 100)
    assert isinstance(few, to.Points)
    assert len(few) <= 100
    apart = np.linalg.norm(cloud.points[:, None] - few.points, axis=2).min(axis=1)
    assert (apart + cloud.radius <= few.radius).all()
    cells = to.Voxels(np.round(some(3000) * 40).astype(int), 0.025)
    coarse = fewer(cells, 200)
    assert isinstance(coarse, to.Voxels)
    assert len(coarse) <= 200
    assert (bounding_box(coarse)[0] <= bounding_box(cells)[0] + 1e-12).all()


def test_surfaces_are_closed_and_face_outward() -> None:
    cells = to.Voxels(np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (-1, -1, -1)]), 0.1)
    vertices, faces = cloud_surface(cells)
    a, b, c = (vertices[faces[:, corner]] for corner in range(3))
    assert np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6.0 == pytest.approx(4e-3)
    ball, faces = cloud_surface(to.Points(np.array([(1.0, 2.0, 3.0)]), 0.1))
    a, b, c = (ball[faces[:, corner]] for corner in range(3))
    assert np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6.0 == pytest.approx(4e-3 / 3.0)


def test_saved_in_a_bundle(tmp_path: Path) -> None:
    robot = to.load("planar2")
    scene = to.Scene(robot).add("seen", to.Points(np.array([(3.0, 0.0, 0.0)]), 0.1))
    scene = scene.add("map", to.Voxels(np.array([(40, 0, 0)]), 0.1))
    problem = to.Problem(
        scene=scene, start=dict.fromkeys(robot.joint_names, 0.0),
        goal=to.joint_positions(dict.fromkeys(robot.joint_names, 0.5)),
    )  # fmt: skip
    result = to.plan(problem)
    assert result.status is to.Status.SOLVED
    save(result, tmp_path / "plan.trajopt")
    again = read_bundle(tmp_path / "plan.trajopt").problem.scene
    seen, cells = again.object("seen").parts[0][0], again.object("map").parts[0][0]
    assert isinstance(seen, to.Points)
    assert seen.radius == 0.1
    assert np.array_equal(seen.points, [(3.0, 0.0, 0.0)])
    assert isinstance(cells, to.Voxels)
    assert np.array_equal(cells.keys, [(40, 0, 0)])


def test_takes_whatever_converts_to_an_array() -> None:
    class Tensor:
        def __array__(self, dtype: object = None, copy: bool | None = None) -> np.ndarray:
            return np.zeros((2, 3))

    assert len(to.Points(Tensor(), 0.01)) == 2  # pyright: ignore[reportArgumentType]
