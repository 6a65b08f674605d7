"""Bent lines keep their ends, differ from each other and repeat with the generator's seed."""

from itertools import islice

import numpy as np
import pytest

from tests.planning.walls import route_of, wall
from tests.robots_for_tests import odd_arm
from trajopt.geometry import WorkCounts
from trajopt.planning.seeds import Bumps, SeedContext, SeedKind
from trajopt.values.trajectory import Path


@pytest.fixture(scope="module")
def context(tmp_path_factory: pytest.TempPathFactory) -> SeedContext:
    return route_of(wall(odd_arm(tmp_path_factory.mktemp("robot"))))


def bent(context: SeedContext, seed: int, count: int) -> list[Path]:
    guesses = Bumps().seeds(context, (), np.random.default_rng(seed))
    return [guess(WorkCounts(), lambda: None) for guess in islice(guesses, count)]


def test_bumps(context: SeedContext) -> None:
    line = context.line.knots
    lines = bent(context, 5, 4)
    for one in lines:
        assert np.array_equal(one[[0, -1]], line[[0, -1]])
    assert len({one[2, 0] for one in lines}) == 4
    assert np.array_equal(bent(context, 5, 1)[0], lines[0])
    assert Bumps().kind is SeedKind.BUMP


def test_none_depends_on_whether_another_was_made(context: SeedContext) -> None:
    *_, alone = islice(Bumps().seeds(context, (), np.random.default_rng(5)), 3)
    assert np.array_equal(alone(WorkCounts(), lambda: None), bent(context, 5, 3)[2])


def test_they_bend_more_and_more(context: SeedContext) -> None:
    away = np.array([np.abs(one - context.line.knots)[:, 0].max() for one in bent(context, 1, 300)])
    assert away[250:].mean() / away[:50].mean() == pytest.approx((1 + 275 / 12) / (1 + 25 / 12), rel=0.3)
