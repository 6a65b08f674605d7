"""Boxes that contain clouds: no distance is larger than it is, and at the ends it is the cloud's own."""

from math import pi

import numpy as np
import pytest

import trajopt as to
from tests.scene.clouds.scenes_for_tests import CARRIED, arm_beside, carried, least, some_cells, some_points
from trajopt.geometry import Evaluator, Query, WorkCounts, covered_query
from trajopt.geometry.covered import CELL, FEWEST, BoxCover, cover_of
from trajopt.scene.reduced import ReducedModel

EXACT = 2e-6
"""What distances of curved shapes are off [m]."""
NOWHERE = np.empty((0, 2))
TURNED = to.placement((0.05, -0.1, 0.02), rpy=(0.4, -0.2, 0.9))


def walls(*, radius: float = 0.004) -> to.Points:
    """A table and a wall on it, both hollow, turned."""
    random = np.random.default_rng(3)
    parts = list[np.ndarray]()
    for size, at in (((0.9, 0.6, 0.04), (0.6, 0.0, -0.02)), ((0.05, 0.6, 0.5), (0.4, 0.0, 0.25))):
        on = random.uniform(-0.5, 0.5, (6000, 3))
        axis = random.integers(3, size=6000)
        on[np.arange(6000), axis] = random.choice((-0.5, 0.5), 6000)
        parts.append(on * size + at)
    points = np.concatenate(parts)
    return to.Points(to.placement(rpy=(0.0, 0.0, 0.3)) * points, radius)


def known(cloud: to.Points | to.Voxels) -> BoxCover:
    cover = cover_of(cloud)
    assert cover is not None
    return cover


def depths(cover: BoxCover, points: np.ndarray) -> np.ndarray:
    """Return how deep points are in the box that holds each best, shape (n,) [m]; negative outside."""
    apart = np.abs((points[:, None] - cover.centre) @ cover.axes)
    return (cover.half - apart).min(axis=2).max(axis=1)


def some_cloud(seed: int, *, cells: bool) -> to.Points | to.Voxels:
    return some_cells(seed, 4000, 0.05) if cells else some_points(seed, 4000, 0.025)


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("cells", (False, True))
def test_every_ball_and_cube_is_in_a_box(seed: int, cells: bool) -> None:
    cloud = some_cloud(seed, cells=cells)
    cover = known(cloud)
    if isinstance(cloud, to.Points):
        assert depths(cover, cloud.points).min() >= cloud.radius - 1e-12
    else:
        corners = np.array(np.meshgrid(*((-0.5, 0.5),) * 3)).reshape(3, -1).T * cloud.size
        every = (cloud.centres[:, None] + corners).reshape(-1, 3)
        assert depths(cover, every).min() >= -1e-12


def test_flat_things_are_few_boxes_and_no_larger_than_they_are() -> None:
    cloud = walls()
    cover = known(cloud)
    assert len(cover.half) < 12
    low, high = (cover.centre @ cover.axes + side * cover.half for side in (-1.0, 1.0))
    random = np.random.default_rng(0)
    inside = [random.uniform(low[box], high[box], (200, 3)) @ cover.axes.T for box in range(len(low))]
    there = to.placement(rpy=(0.0, 0.0, 0.3)).inverse() * np.concatenate(inside)
    sizes = (((0.9, 0.6, 0.04), (0.6, 0.0, -0.02)), ((0.05, 0.6, 0.5), (0.4, 0.0, 0.25)))
    beyond = [
        np.linalg.norm(np.maximum(np.abs(there - at) - np.array(size) / 2, 0.0), axis=1) for size, at in sizes
    ]
    assert np.min(beyond, axis=0).max() < 2.0 * CELL


def test_cut_boxes_contain_the_cloud_too() -> None:
    cloud = walls()
    cover = known(cloud)
    chosen = np.arange(0, len(cover.half), 2)
    cut = cover.cut(cloud, chosen, 4)
    assert len(cut.half) > len(cover.half)
    assert depths(cut, cloud.points).min() >= cloud.radius - 1e-12


@pytest.mark.parametrize("cells", (False, True))
@pytest.mark.parametrize("kind", [kind for kind in CARRIED if kind not in ("points", "cells")])
def test_no_distance_is_larger_than_it_is(kind: str, cells: bool) -> None:
    model = arm_beside(some_cloud(4, cells=cells), carried(kind), TURNED, parts=False)
    positions = np.random.default_rng(2).uniform(-2.0, 2.0, (40, 2))
    true = smallest(model, Query(model), positions)
    for ends in (NOWHERE, positions[:3]):
        query = covered_query(model, WorkCounts(), ends)
        assert query is not None
        found = smallest(model, query, positions)
        assert len(true) > 40
        assert set(true) <= set(found)
        assert all(found[key] <= distance + EXACT for key, distance in true.items() if distance > 0.0)


def smallest(model: ReducedModel, query: Evaluator, positions: np.ndarray) -> dict[object, float]:
    seen = query.close_pairs(positions, np.full(len(model.pairs.first), 0.12))
    return least(model, seen.sample, seen.pair, seen.distance)


def test_where_the_robot_has_to_be_the_boxes_leave_as_much_room_as_the_cloud() -> None:
    """A ball in a hollow box of points: the box is solid, and the points are not."""
    random = np.random.default_rng(1)
    on = random.uniform(-0.5, 0.5, (4000, 3))
    on[np.arange(4000), random.integers(3, size=4000)] = random.choice((-0.5, 0.5), 4000)
    model = arm_beside(to.Points(on, 0.02), to.Sphere(0.05), to.placement((2.0, 0.0, 0.0)), parts=False)
    tip = model.scene.placement_of("held", model.all_positions(np.zeros(2))).translation
    model = arm_beside(to.Points(0.5 * on, 0.02), to.Sphere(0.05), to.placement(tip), parts=False)
    ends, required = np.zeros((1, 2)), model.pairs.required
    mine = [{"cloud", "held"} == set(model.owners(pair)) for pair in range(len(required))]
    reach = np.where(mine, required + 1e-9, -np.inf)
    assert not len(Query(model).close_pairs(ends, reach).pair)
    blocked, opened = covered_query(model, WorkCounts(), NOWHERE), covered_query(model, WorkCounts(), ends)
    assert blocked is not None and opened is not None
    assert len(blocked.close_pairs(ends, reach).pair)
    assert not len(opened.close_pairs(ends, reach).pair)


def test_small_and_carried_clouds_stay_as_they_are() -> None:
    few = some_points(1, FEWEST - 1)
    assert covered_query(arm_beside(few, to.Sphere(0.05), TURNED, parts=False), WorkCounts(), NOWHERE) is None
    assert cover_of(to.Points(np.random.default_rng(0).uniform(-5.0, 5.0, (4000, 3)), 0.001)) is None


def test_a_path_through_a_gap_that_boxes_fill_is_still_found() -> None:
    """The arm has to turn within a ring of points that the boxes fill: start and goal are in it."""
    angle = np.linspace(-pi, pi, 1500)
    ring = np.concatenate([
        np.stack((1.4 * np.cos(angle), 1.4 * np.sin(angle), np.full(1500, height)), axis=1)
        for height in np.linspace(-0.2, 0.5, 24)
    ])  # fmt: skip
    robot = to.load("planar2")
    scene = to.Scene(robot).add("cloud", to.Points(ring, 0.01))
    start, end = (dict(zip(robot.joint_names, values, strict=True)) for values in ((-1.2, 0.3), (1.2, -0.4)))
    result = to.plan(to.Problem(scene=scene, start=start, goal=to.joint_positions(end)))
    assert result.status is to.Status.SOLVED


def test_points_of_one_place_or_one_line() -> None:
    """What has no width, or all points twice, is covered as well."""
    line = np.zeros((1000, 3))
    line[:, 0] = np.linspace(0.0, 1.0, 1000)
    for points in (np.zeros((300, 3)), line, np.repeat(line, 3, axis=0), line + 40.0):
        cover = known(to.Points(points, 0.01))
        assert depths(cover, points).min() >= 0.01 - 1e-12
