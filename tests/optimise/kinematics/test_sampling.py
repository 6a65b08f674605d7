"""Random configurations: valid by the judge, evenly spread, the same for the same generator."""

import numpy as np
import pytest

import trajopt as to
from trajopt.optimise.kinematics import random_configurations, validity
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.reducing import reduce_model


def test_samples_are_valid_and_omitted_ones_are_not(odd: ReducedModel) -> None:
    found = random_configurations(odd, 300, rng=np.random.default_rng(1), margin=0.02)
    assert found.positions.shape == (300, 4) and found.colliding > 0 and found.missed == 0
    assert all(validity(odd, q, margin=0.0199).valid for q in found.positions)


def test_requirements_are_held(panda: ReducedModel) -> None:
    down = to.axis_alignment("panda_hand_tcp", direction=(0, 0, -1), tolerance=0.05)
    found = random_configurations(panda, 100, rng=np.random.default_rng(1), requirements=[down])
    assert len(found.positions) == 100
    assert all(validity(panda, q, requirements=[down]).valid for q in found.positions)


def test_colliding_share_matches_uniform_sampling(odd: ReducedModel) -> None:
    """The share that is left out is the share that the judge finds in contact, within chance."""
    found = random_configurations(odd, 4000, rng=np.random.default_rng(2), margin=0.0)
    share = found.colliding / found.drawn
    rng = np.random.default_rng(3)
    lower, upper = np.maximum(odd.limits.lower, -np.pi), np.minimum(odd.limits.upper, np.pi)
    judged = [not validity(odd, q).valid for q in rng.uniform(lower, upper, (800, 4))]
    assert abs(share - np.mean(judged)) < 5.0 * np.sqrt(share * (1 - share) / 800)


def test_the_same_generator_gives_the_same(odd: ReducedModel) -> None:
    one, other = (random_configurations(odd, 50, rng=np.random.default_rng(4)).positions for _ in range(2))
    np.testing.assert_array_equal(one, other)


def test_too_few_is_a_result(odd: ReducedModel) -> None:
    told: list[int] = []
    walls = odd.scene.add("solid", to.Box(5, 5, 5), to.placement((0, 0, 0.4)))
    walled = reduce_model(walls, "all", odd.start)
    found = random_configurations(walled, 5, rng=np.random.default_rng(0), progress=told.append)
    assert len(found.positions) == 0 and found.colliding == found.drawn > 1000
    assert "0 valid configurations" in str(found) and set(told) == {0}


def test_misuse_is_named(odd: ReducedModel) -> None:
    with pytest.raises(to.TrajoptError, match="count: must be at least 1, is 0"):
        random_configurations(odd, 0, rng=np.random.default_rng(0))
    with pytest.raises(to.TrajoptError, match="margin: is negative"):
        random_configurations(odd, 1, rng=np.random.default_rng(0), margin=-1.0)
