"""Distances to clouds, of the optimiser and of the judge, against the same balls and cubes one by one."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import trajopt as to
from tests.scene.clouds.scenes_for_tests import (
    CARRIED,
    REACH,
    arm_beside,
    carried,
    least,
    some_cells,
    some_points,
)
from trajopt.geometry import Query
from trajopt.geometry.query import SearchSpace, search_path
from trajopt.scene.reduced import ReducedModel
from trajopt.verify.kernel.kinematics import Kinematics
from trajopt.verify.kernel.pair_distances import PairDistances

NEGLIGIBLE = 6e-5
"""What the optimiser leaves out of a union, and what Coal's depths of curved shapes are off [m]."""
TURNED = to.placement((0.05, -0.1, 0.02), rpy=(0.4, -0.2, 0.9))


def both(kind: str, seed: int, *, cells: bool) -> tuple[ReducedModel, ReducedModel]:
    cloud = some_cells(seed) if cells else some_points(seed)
    held = carried(kind)
    one, other = (arm_beside(cloud, held, TURNED, parts=parts) for parts in (False, True))
    return one, other


@pytest.mark.parametrize("cells", (False, True))
@pytest.mark.parametrize("kind", CARRIED)
@settings(max_examples=6, deadline=None)
@given(seed=st.integers(0, 10_000))
def test_the_nearest_is_the_nearest_of_all_balls(kind: str, cells: bool, seed: int) -> None:
    cloud, parts = both(kind, seed, cells=cells)
    positions = np.random.default_rng(seed).uniform(-2.0, 2.0, (12, 2))
    reaches = [np.full(len(model.pairs.first), REACH) for model in (cloud, parts)]
    seen, single = (
        Query(cloud).close_pairs(positions, reaches[0]),
        Query(parts).close_pairs(positions, reaches[1]),
    )
    mine = least(cloud, seen.sample, seen.pair, seen.distance)
    true = least(parts, single.sample, single.pair, single.distance)
    assert {key for key, value in true.items() if value < REACH - NEGLIGIBLE} <= set(mine)
    for key, distance in mine.items():
        assert distance == pytest.approx(true[key], abs=NEGLIGIBLE)


@pytest.mark.parametrize("kind", CARRIED)
def test_every_row_is_the_row_of_a_ball(kind: str) -> None:
    cloud, parts = both(kind, 7, cells=False)
    positions = np.random.default_rng(1).uniform(-2.0, 2.0, (20, 2))
    seen = Query(cloud).close_pairs(positions, np.full(len(cloud.pairs.first), REACH))
    single = Query(parts).close_pairs(positions, np.full(len(parts.pairs.first), REACH))
    assert len(seen.pair)
    for row in range(len(seen.pair)):
        near = single.sample == seen.sample[row]
        apart = np.abs(single.distance[near] - seen.distance[row])
        apart += np.abs(single.jacobian[near] - seen.jacobian[row]).max(axis=1)
        apart += np.abs(np.abs(single.normal[near]) - np.abs(seen.normal[row])).max(axis=1)
        assert apart.min() < 1e-6


def test_few_rows_and_several_sides() -> None:
    """A hand between two walls of points has a row of each, and few of the many points."""
    sheet = np.stack(np.meshgrid(np.arange(0.8, 1.1, 0.01), (-0.1, 0.1), np.arange(0.0, 0.5, 0.01)), axis=-1)
    cloud = to.Points(sheet.reshape(-1, 3), 0.005)
    model = arm_beside(cloud, to.Box(0.08, 0.08, 0.08), to.Placement(), parts=False)
    seen = Query(model).close_pairs(np.zeros((1, 2)), np.full(len(model.pairs.first), 0.2))
    held = [{"cloud", "held"} == set(model.owners(pair)) for pair in seen.pair.tolist()]
    assert 2 <= sum(held) <= 6
    across = seen.normal[held][:, 1]
    assert across.min() < -0.7
    assert across.max() > 0.7


@pytest.mark.parametrize("kind", CARRIED)
def test_a_path_is_searched_as_among_single_balls(kind: str) -> None:
    corners = list[np.ndarray | None]()
    for model in both(kind, 3, cells=False):
        space = SearchSpace(
            lower=np.full(2, -2.5), upper=np.full(2, 2.5), unit=np.full(2, 0.5),
            reach=np.zeros(len(model.pairs.first)), step=0.01,
        )  # fmt: skip
        corners.append(
            search_path(
                Query(model), np.array((-1.5, 0.3)), np.array([(1.5, -0.4), (0.3, 2.0)]), space, checked=3000,
                shortening=300, seed=4, check=lambda: None,
            ).corners
        )  # fmt: skip
    one, other = corners
    assert (one is None) == (other is None)
    if one is not None and other is not None:
        assert np.allclose(one, other)


@pytest.mark.parametrize("cells", (False, True))
@pytest.mark.parametrize("kind", CARRIED)
@settings(max_examples=5, deadline=None)
@given(seed=st.integers(0, 10_000))
def test_the_judge_measures_the_nearest_of_all_balls(kind: str, cells: bool, seed: int) -> None:
    cloud, parts = both(kind, seed, cells=cells)
    positions = np.random.default_rng(seed).uniform(-2.0, 2.0, (5, 2))
    found = list[dict[object, float]]()
    for model in (cloud, parts):
        kinematics = Kinematics(model)
        poses = kinematics.poses(positions)
        count = len(model.pairs.first)
        cell, pair = np.repeat(np.arange(5), count), np.tile(np.arange(count), 5)
        distances = PairDistances(kinematics, error=0.0).measure(poses, cell, pair)
        found.append(least(model, cell, pair, distances))
    assert found[0].keys() == found[1].keys()
    for key, distance in found[0].items():
        if max(distance, found[1][key]) > 0.0:
            assert distance == pytest.approx(found[1][key], abs=1e-6), key
        else:  # Coal's depth of round shapes is a lower bound that hangs on what was measured before
            assert distance == pytest.approx(found[1][key], abs=0.02), key


def test_against_numpy() -> None:
    """A ball that is carried: every distance is known."""
    cloud = some_points(11, 400)
    model = arm_beside(cloud, to.Sphere(0.05), TURNED, parts=False)
    positions = np.random.default_rng(2).uniform(-2.0, 2.0, (30, 2))
    seen = Query(model).close_pairs(positions, np.full(len(model.pairs.first), 3.0))
    names = {number: set(model.owners(number)) for number in range(len(model.pairs.first))}
    mine = [number for number, owners in names.items() if owners == {"cloud", "held"}]
    poses = Kinematics(model).poses(positions)
    distances = PairDistances(Kinematics(model), error=0.0)
    for sample in range(len(positions)):
        at = model.scene.placement_of("held", positions[sample]).translation
        true = float(np.linalg.norm(TURNED * cloud.points - at, axis=1).min()) - 0.05 - cloud.radius
        rows = (seen.sample == sample) & np.isin(seen.pair, mine)
        assert seen.distance[rows].min() == pytest.approx(true, abs=NEGLIGIBLE)
        judged = distances.measure(poses, np.array([sample]), np.array(mine[:1]))
        assert judged[0] == pytest.approx(true, abs=1e-9)
