"""Bounds of piecewise polynomials, against dense sampling and closed forms."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import PPoly

from tests.oracles.judge_polynomials import bounds
from trajopt.verify.kernel.motion import Polynomials


def random_polynomials(seed: int, degree: int) -> Polynomials:
    rng = np.random.default_rng(seed)
    times = np.concatenate(([0.0], np.cumsum(rng.uniform(0.01, 1.0, 4))))
    return Polynomials(times, rng.normal(size=(degree + 1, 4, 3)))


@given(seed=st.integers(0, 10**6), degree=st.integers(0, 5))
@settings(max_examples=60, deadline=None)
def test_range_holds_everywhere_and_is_attained_in_the_limit(seed: int, degree: int) -> None:
    polynomials = random_polynomials(seed, degree)
    rng = np.random.default_rng(seed)
    function = PPoly(polynomials.coefficients, polynomials.times)
    begin, end = np.sort(rng.uniform(0.0, polynomials.times[-1], (2, 6)), axis=0)
    end = np.maximum(end, begin + 1e-9)
    low, high = polynomials.range(begin, end)
    for row in range(6):
        # A sample at a breakpoint belongs to the next piece, which may jump: stay inside.
        values = function(np.linspace(begin[row], end[row], 400)[:-1])
        assert (values >= low[row] - 1e-9).all()
        assert (values <= high[row] + 1e-9).all()
    middle = (begin + end) / 2
    low, high = polynomials.range(middle, middle + 1e-9)
    np.testing.assert_allclose(low, high, atol=1e-5)


@given(seed=st.integers(0, 10**6), degree=st.integers(0, 5))
@settings(max_examples=60, deadline=None)
def test_the_core_bounds_as_the_same_in_plain_python(seed: int, degree: int) -> None:
    polynomials = random_polynomials(seed, degree)
    times = np.concatenate(
        (polynomials.times, np.random.default_rng(seed).uniform(0.0, polynomials.times[-1], 7))
    )
    begin, end = np.array([(one, other) for one in times for other in times if one < other]).T
    for found, wanted in zip(polynomials.range(begin, end), bounds(polynomials, begin, end), strict=True):
        np.testing.assert_allclose(found, wanted, rtol=1e-10, atol=1e-10)


@given(seed=st.integers(0, 10**6), degree=st.integers(0, 5))
@settings(max_examples=60, deadline=None)
def test_largest_is_the_largest_sample_or_a_little_more(seed: int, degree: int) -> None:
    polynomials = random_polynomials(seed, degree)
    found, lowest = polynomials.extremes()
    lengths = np.diff(polynomials.times)
    fractions = np.linspace(0.0, 1.0, 2001)
    sampled = np.full(3, -np.inf)
    for piece, length in enumerate(lengths):
        for joint in range(3):
            values = np.polyval(polynomials.coefficients[:, piece, joint], fractions * length)
            sampled[joint] = max(sampled[joint], values.max())
    assert (found.values >= sampled - 1e-8).all()
    assert (found.values <= sampled + 1e-4).all()
    assert (lowest.values <= found.values + 1e-9).all()


def test_extreme_of_a_parabola_is_exact() -> None:
    parabola = Polynomials(np.array((0.0, 2.0)), np.array((-1.0, 1.4, 0.51)).reshape(3, 1, 1))
    found, lowest = parabola.extremes()
    assert found.values[0] == pytest.approx(1.0, abs=2e-9)
    assert found.times[0] == pytest.approx(0.7, abs=1e-4)
    assert lowest.values[0] == pytest.approx(-0.69, abs=1e-12)


def test_derivatives_and_combinations() -> None:
    cubic = Polynomials(np.array((0.0, 1.0)), np.array((1.0, -2.0, 3.0, 4.0)).reshape(4, 1, 1))
    np.testing.assert_allclose(cubic.derivative().coefficients.ravel(), (3.0, -4.0, 3.0))
    constant = cubic.derivative().derivative().derivative()
    np.testing.assert_allclose(constant.coefficients.ravel(), (6.0,))
    np.testing.assert_allclose(constant.derivative().coefficients.ravel(), (0.0,))
    twice = cubic.combined(np.array([[2.0]]), np.array([1.0]))
    np.testing.assert_allclose(twice.coefficients.ravel(), (2.0, -4.0, 6.0, 9.0))
