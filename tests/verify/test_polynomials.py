"""Bounds of piecewise polynomials, against dense sampling and closed forms."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import PPoly

from tests.oracles.judge_polynomials import bounds
from trajopt.native import proof
from trajopt.verify.kernel.motion import Polynomials


def random_polynomials(seed: int, degree: int, functions: int = 3) -> Polynomials:
    rng = np.random.default_rng(seed)
    times = np.concatenate(([0.0], np.cumsum(rng.uniform(0.01, 1.0, 4))))
    return Polynomials(times, rng.normal(size=(degree + 1, 4, functions)))


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
    polynomials = random_polynomials(seed, degree, functions=6)
    times = np.concatenate(
        (polynomials.times, np.random.default_rng(seed).uniform(0.0, polynomials.times[-1], 7))
    )
    begin, end = np.array([(one, other) for one in times for other in times if one < other]).T
    for found, wanted in zip(polynomials.range(begin, end), bounds(polynomials, begin, end), strict=True):
        np.testing.assert_allclose(found, wanted, rtol=1e-10, atol=1e-10)


@given(seed=st.integers(0, 10**6), degrees=st.tuples(*[st.integers(0, 5)] * 2), shift=st.floats(-4.0, 4.0))
@settings(max_examples=60, deadline=None)
def test_functions_beside_others_keep_their_values(seed: int, degrees: tuple[int, int], shift: float) -> None:
    one, other = (random_polynomials(seed + number, degree) for number, degree in enumerate(degrees))
    other = Polynomials(other.times + shift, other.coefficients)
    both = one.beside(other)
    assert both.times[0] == one.times[0] and both.times[-1] == one.times[-1]
    assert set(one.times) <= set(both.times) and (np.diff(both.times) > 0.0).all()
    times = np.random.default_rng(seed).uniform(0.0, one.times[-1], 50)
    found = PPoly(both.coefficients, both.times)(times)
    held = np.clip(times, other.times[0], other.times[-1])
    np.testing.assert_allclose(found[:, :3], PPoly(one.coefficients, one.times)(times), atol=1e-9)
    np.testing.assert_allclose(found[:, 3:], PPoly(other.coefficients, other.times)(held), atol=1e-9)


@given(seed=st.integers(0, 10**6), degree=st.integers(0, 5))
@settings(max_examples=60, deadline=None)
def test_the_fastest_function_of_each_piece_bounds_its_speed(seed: int, degree: int) -> None:
    polynomials = random_polynomials(seed, degree)
    matrix = np.random.default_rng(seed).normal(size=(4, 3))
    found = proof.speeds(polynomials.times, polynomials.coefficients, matrix)
    low, high = polynomials.derivative().range(polynomials.times[:-1], polynomials.times[1:])
    wanted = (np.maximum(high, -low) @ np.abs(matrix).T).max(axis=1)
    np.testing.assert_allclose(found, wanted, rtol=1e-12)


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
