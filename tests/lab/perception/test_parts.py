"""Clusters and planes: every box contains the balls of its points."""

import numpy as np
import pytest

import trajopt as to
from trajopt.lab.perception import Clustering, Flatness, Workspace, clusters, planes, without
from trajopt.lab.perception.sensing import Grid


def moved(points: np.ndarray, x: float, y: float = 0.0) -> np.ndarray:
    return points + np.array((x, y, 0.0))


def on_box(
    half: tuple[float, float, float], where: to.Placement, many: int, rng: np.random.Generator
) -> np.ndarray:
    """Return points on the surface of a box."""
    points = rng.uniform(-1.0, 1.0, (many, 3))
    axis = rng.integers(0, 3, many)
    points[np.arange(many), axis] = np.sign(points[np.arange(many), axis])
    return where * (points * half)


def contains(box: to.Box, where: to.Placement, cloud: to.Points, points: np.ndarray) -> bool:
    local = where.inverse() * cloud.points[points]
    half = np.array((box.x, box.y, box.z)) / 2.0
    return bool((np.abs(local) + cloud.radius <= half).all())


@pytest.mark.parametrize("upright", [True, False])
def test_boxes_contain_the_balls_of_their_clusters(upright: bool) -> None:
    for seed in range(20):
        rng = np.random.default_rng(seed)
        parts = [moved(rng.normal(0.0, 0.03, (int(rng.integers(1, 200)), 3)), 0.5 * k) for k in range(3)]
        flat = moved(np.column_stack((rng.uniform(0, 0.1, (50, 2)), np.zeros(50))), 0.0, 1.0)
        line = moved(np.outer(np.linspace(0, 0.2, 40), rng.normal(size=3)), 0.0, -1.0)
        cloud = to.Points(np.concatenate((*parts, flat, line, [[5.0, 5.0, 5.0]])), 0.004)
        found = clusters(cloud, Clustering(gap=0.05, least=1, upright=upright))
        assert len({int(i) for each in found for i in each.points}) == len(cloud.points)
        for each in found:
            assert contains(each.box, each.placement, cloud, each.points)
            if upright:
                assert np.allclose(each.placement.rotation[:, 2], (0, 0, 1))


def test_a_turned_box_is_found_again() -> None:
    rng = np.random.default_rng(3)
    for turn in (0.0, 0.3, 1.2):
        where = to.placement((0.4, 0.1, 0.2), rpy=(0.0, 0.0, turn))
        cloud = to.Points(on_box((0.1, 0.05, 0.15), where, 4000, rng), 0.002)
        (found,) = clusters(cloud, Clustering(gap=0.02))
        assert sorted((found.box.x, found.box.y)) == pytest.approx([0.104, 0.204], abs=0.002)
        assert found.box.z == pytest.approx(0.304, abs=0.001)
        assert np.allclose(found.placement.translation, where.translation, atol=0.002)
    tilted = to.placement((0.4, 0.1, 0.2), rpy=(0.5, 0.4, 0.3))
    cloud = to.Points(on_box((0.1, 0.05, 0.15), tilted, 4000, rng), 0.002)
    (free,) = clusters(cloud, Clustering(upright=False))
    (stood,) = clusters(cloud)
    volume = [each.box.x * each.box.y * each.box.z for each in (free, stood)]
    assert volume[0] < 1.1 * 0.104 * 0.204 * 0.304 < 0.7 * volume[1]


def test_near_parts_are_joined_and_far_parts_are_separate() -> None:
    line = np.column_stack((np.linspace(0.0, 1.0, 101), np.zeros(101), np.zeros(101)))
    (one,) = clusters(to.Points(line, 0.001), Clustering(gap=0.0101))
    assert len(one.points) == 101
    two = clusters(to.Points(np.concatenate((line, moved(line, 0.0, 0.1))), 0.001), Clustering(gap=0.02))
    assert [len(each.points) for each in two] == [101, 101]
    assert [each.name for each in two] == ["cluster 1", "cluster 2"]


def test_the_same_points_are_of_the_same_cluster_in_any_order() -> None:
    rng = np.random.default_rng(4)
    points = np.concatenate([moved(rng.normal(0.0, 0.02, (100, 3)), 0.3 * k) for k in range(4)])
    order = rng.permutation(len(points))
    one = clusters(to.Points(points, 0.001), Clustering(gap=0.05, least=1))
    other = clusters(to.Points(points[order], 0.001), Clustering(gap=0.05, least=1))
    assert {frozenset(each.points.tolist()) for each in one} == {
        frozenset(order[each.points].tolist()) for each in other
    }


def test_a_box_may_take_the_place_of_its_points() -> None:
    rng = np.random.default_rng(5)
    cloud = to.Points(
        np.concatenate((rng.normal(0, 0.02, (200, 3)), moved(rng.normal(0, 0.02, (100, 3)), 1.0))), 0.01
    )
    first, second = clusters(cloud, Clustering(gap=0.05))
    left = without(cloud, (first.points,))
    assert left is not None and len(left) == len(cloud) - len(first.points) and left.radius == cloud.radius
    everything = np.arange(len(cloud))
    assert without(cloud, (everything,)) is None
    scene = to.Scene(to.load("planar2")).add(second.name, second.box, second.placement)
    assert "cluster 2" in scene.objects


def room(rng: np.random.Generator, noise: float) -> np.ndarray:
    """Return a table at a height of 0.4 m, a wall at x = 1 and some clutter."""
    table = np.column_stack((rng.uniform(0, 1, 6000), rng.uniform(-0.5, 0.5, 6000), np.full(6000, 0.4)))
    wall = np.column_stack((np.full(3000, 1.0), rng.uniform(-0.5, 0.5, 3000), rng.uniform(0.42, 1.0, 3000)))
    clutter = on_box((0.05, 0.05, 0.1), to.placement((0.5, 0.1, 0.5)), 900, rng)
    points = np.concatenate((table, wall, clutter))
    return points + rng.uniform(-noise, noise, points.shape)


def test_a_table_and_a_wall_are_found_and_named() -> None:
    cloud = to.Points(room(np.random.default_rng(6), 0.003), 0.005)
    found = planes(cloud, Flatness(gap=0.05, least=500))
    assert [each.name for each in found[:2]] == ["table", "wall"]
    table, wall = found[:2]
    assert table.normal == pytest.approx((0, 0, 1), abs=0.01)
    assert abs(wall.normal[0]) > 0.999
    top = table.placement * np.array((0.0, 0.0, table.box.z / 2))
    assert top[2] == pytest.approx(0.408, abs=0.004)
    assert sorted((table.box.x, table.box.y)) == pytest.approx([1.0, 1.0], abs=0.1)
    for each in found:
        assert contains(each.box, each.placement, cloud, each.points)


def test_planes_are_the_same_each_time_and_none_are_found_in_a_ball() -> None:
    cloud = to.Points(room(np.random.default_rng(7), 0.002), 0.005)
    one, other = planes(cloud), planes(cloud)
    assert [each.points.tolist() for each in one] == [each.points.tolist() for each in other]
    ball = np.random.default_rng(8).normal(size=(3000, 3))
    ball *= 0.3 / np.linalg.norm(ball, axis=1)[:, None]
    assert planes(to.Points(ball, 0.003), Flatness(least=400)) == ()
    assert planes(to.Points(np.zeros((2, 3)) + 1.0, 0.003)) == ()


def test_border_cells_contain_measurements_of_the_workspace() -> None:
    """A wall at 0.549 m of a workspace that ends at 0.55 m, which is not a multiple of the cell."""
    room, sensor = Workspace((-0.55, -0.55, -0.55), (0.55, 0.55, 0.55)), to.placement((0.0, 0.0, 0.0))
    grid = Grid.around(sensor, 1.0, 0.02, room)
    for wall in (0.549, -0.549):
        cells = np.array([wall, 0.0, 0.0]) / 0.02 - grid.first
        at = [np.array([cell], dtype=np.float32) for cell in cells]
        assert grid.numbered(at, np.ones(1, dtype=np.bool_))[0] >= 0
    whole = Grid.around(sensor, 1.0, 0.05, room)
    assert (whole.first == -11).all() and (whole.count == 22).all(), "a multiple gets no more cells"
