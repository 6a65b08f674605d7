"""The problems among measured points: what they are made of was seen, and they are solved as they say."""

import numpy as np
import pytest
from trajopt_problems.unknown_shelf import unknown_shelf_panda, unknown_shelf_ur5

import trajopt as to


@pytest.mark.parametrize("make", [unknown_shelf_panda, unknown_shelf_ur5])
def test_the_fixed_instance_is_solved(make: object) -> None:
    problem = make()  # type: ignore[operator]
    ((cloud, _),) = problem.scene.objects["camera"].parts
    assert isinstance(cloud, to.Points) and len(cloud) > 3000
    result = to.plan(problem)
    assert result.verified
    assert result.require().certificate.clearance >= 0.0


def test_random_instances_differ_and_are_the_same_for_the_same_seed() -> None:
    one, again, other = (unknown_shelf_panda(np.random.default_rng(seed)) for seed in (1, 1, 2))
    points = [each.scene.objects["camera"].parts[0][0].points for each in (one, again, other)]
    assert np.array_equal(points[0], points[1])
    assert not np.array_equal(points[0], points[2])
