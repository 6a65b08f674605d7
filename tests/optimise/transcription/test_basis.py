"""The B-spline basis against scipy's splines, and what its hull promises."""

import numpy as np
import pytest
from scipy.interpolate import BSpline

from trajopt.optimise.transcription.bspline import SplineBasis, even_basis, fitted

BREAKS = np.array((0.0, 0.1, 0.15, 0.4, 0.7, 0.75, 1.0))


@pytest.fixture(params=[1, 3, 5], ids=lambda degree: f"degree {degree}")
def basis(request: pytest.FixtureRequest) -> SplineBasis:
    return SplineBasis(request.param, BREAKS)


def test_points_are_weighted_means_of_neighbouring_control_points(basis: SplineBasis) -> None:
    control = np.random.default_rng(1).normal(size=(basis.count, 2))
    at = np.linspace(0.0, 1.0, 41)
    stencils = basis.at(at)
    assert (stencils.weight >= 0.0).all()
    assert stencils.weight.sum(axis=1) == pytest.approx(np.ones(41))
    expected = BSpline(basis.knots, control, basis.degree)(at)
    assert stencils(control) == pytest.approx(expected, abs=1e-12)
    assert stencils(control)[[0, -1]] == pytest.approx(control[[0, -1]])


def test_derivatives_lie_between_their_control_points(basis: SplineBasis) -> None:
    control = np.random.default_rng(2).normal(size=(basis.count, 2))
    for order in range(1, min(basis.degree, 3) + 1):
        points = basis.derivative(order)(control)
        assert points == pytest.approx(
            np.asarray(BSpline(basis.knots, control, basis.degree).derivative(order).c)[: len(points)]
        )
        dense = basis.derivative_at(np.linspace(0.0, 1.0, 301), order)(control)
        assert (dense.max(axis=0) <= points.max(axis=0) + 1e-9).all()
        assert (dense.min(axis=0) >= points.min(axis=0) - 1e-9).all()


def test_weights_are_those_of_unit_splines_to_the_last_bit(basis: SplineBasis) -> None:
    at = np.sort(np.concatenate((BREAKS, np.random.default_rng(4).uniform(size=60))))
    unit = BSpline(basis.knots, np.eye(basis.count), basis.degree)
    for order in range(basis.degree + 1):
        found = basis.derivative_at(at, order)
        expected = np.take_along_axis(np.asarray(unit(at, order)), found.support, axis=1)
        assert np.array_equal(found.weight, expected)


def test_parameters_are_breaks_and_even_ones_between(basis: SplineBasis) -> None:
    found = basis.parameters(np.array((2, 1, 5, 1, 1, 2)))
    assert np.isin(BREAKS, found).all() and len(found) == 13
    assert found[:3] == pytest.approx([0.0, 0.05, 0.1])
    assert found[3:9] == pytest.approx([0.15, 0.2, 0.25, 0.3, 0.35, 0.4])


def test_a_spline_is_found_again_by_fitting() -> None:
    basis = SplineBasis(3, np.linspace(0.0, 1.0, 9))
    control = np.random.default_rng(3).normal(size=(basis.count, 3))
    control[:3], control[-3:] = control[0], control[-1]
    at = np.linspace(0.0, 1.0, 60)
    assert fitted(basis, at, basis.at(at)(control), resting=3) == pytest.approx(control, abs=1e-4)


def test_cached_samples_equal_new_ones() -> None:
    basis = even_basis(3, 12)
    assert even_basis(3, 12) is basis
    for exact in (np.zeros(0), np.array((0.31, 0.5))):
        for sampling in (np.full(12, 2), np.full(12, 3), np.arange(1, 13), np.full(12, 2)):
            parameters, stencils = basis.sampled(sampling, exact)
            asked = np.union1d(basis.parameters(sampling), exact)
            assert np.array_equal(parameters, asked)
            assert np.array_equal(stencils.support, basis.at(asked).support)
            assert np.array_equal(stencils.weight, basis.at(asked).weight)
