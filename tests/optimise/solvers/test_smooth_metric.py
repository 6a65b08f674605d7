"""The metric against its definition."""

import numpy as np
import pytest

from trajopt.optimise.solvers.covariant import smooth_metric
from trajopt.values.arrays import Bools, Floats


def moves(fixed: list[int], knots: int = 9) -> Bools:
    free = np.ones((knots, 2), dtype=np.bool_)
    free[fixed] = False
    return free


@pytest.mark.parametrize("fixed", [[0], [0, 8], [0, 4, 8]])
def test_the_inverse_minimises_squared_accelerations(fixed: list[int]) -> None:
    """Independent: the effort of the inverse's column has the slope 1 at its knot and 0 at others."""
    free = moves(fixed)
    metric = smooth_metric(free, np.ones(2))
    assert metric.inverse.max() == pytest.approx(1.0)
    assert not metric.inverse[:, fixed].any() and not metric.inverse[:, :, fixed].any()

    def effort(path: Floats) -> float:
        rested = np.concatenate((path[:1], path, path[-1:]))
        return 0.5 * float(np.sum((rested[2:] - 2.0 * rested[1:-1] + rested[:-2]) ** 2))

    for pulled in np.flatnonzero(free[:, 0]):
        path = metric.inverse[0, :, pulled] * metric.largest
        for knot in np.flatnonzero(free[:, 0]):
            away = 1e-3 * (np.arange(len(path)) == knot)
            slope = (effort(path + away) - effort(path - away)) / 2e-3
            assert slope == pytest.approx(float(knot == pulled), abs=1e-3)


def test_scale_counts_squared() -> None:
    free = moves([0, 8])
    plain, scaled = smooth_metric(free, np.ones(2)), smooth_metric(free, np.array([1.0, 0.1]))
    assert scaled.inverse[0] == pytest.approx(plain.inverse[0])
    assert scaled.inverse[1] == pytest.approx(0.01 * plain.inverse[1])


def test_noise_has_the_inverse_as_its_covariance() -> None:
    metric = smooth_metric(moves([0, 8]), np.array([1.0, 0.5]))
    assert np.einsum("nij,nkj->nik", metric.root, metric.root) == pytest.approx(metric.inverse, abs=1e-9)
    rng = np.random.default_rng(0)
    drawn = np.stack([metric.draw(rng) for _ in range(4000)])
    assert not drawn[:, [0, 8]].any()
    assert np.einsum("ktn,ksn->nts", drawn, drawn) / 4000 == pytest.approx(metric.inverse, abs=0.08)


def test_averages_have_columns_of_one_height() -> None:
    metric = smooth_metric(moves([0, 8]), np.ones(2))
    for knot in range(1, 8):
        change = np.zeros((9, 2))
        change[knot] = 1.0
        assert metric.average(change).max(axis=0) == pytest.approx([1 / 9, 1 / 9])


def test_nothing_fixed_and_nothing_free() -> None:
    one = np.ones((1, 3), dtype=np.bool_)
    assert smooth_metric(one, np.ones(3)).inverse == pytest.approx(np.ones((3, 1, 1)))
    assert not smooth_metric(~one, np.ones(3)).inverse.any()
