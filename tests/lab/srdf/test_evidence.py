"""The statistics, against exact binomial sums and known rules."""

from math import comb

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import trajopt as to
from trajopt.lab.srdf import Confidence


def at_most(k: int, n: int, p: float) -> float:
    """Chance of at most k collisions in n configurations."""
    return sum(comb(n, i) * p**i * (1 - p) ** (n - i) for i in range(k + 1))


@settings(deadline=None)
@given(st.integers(5, 60), st.floats(0.0, 1.0), st.integers(1, 30), st.floats(0.5, 0.999))
def test_bounds_are_clopper_and_pearsons(n: int, part: float, pairs: int, level: float) -> None:
    confidence, k = Confidence(level=level), round(part * n)
    risk = (1 - level) / pairs
    lower, upper = confidence.lower(k, n, pairs=pairs), confidence.upper(k, n, pairs=pairs)
    assert 0.0 <= lower <= k / n <= upper <= 1.0
    if k < n:
        assert at_most(k, n, upper) == pytest.approx(risk, rel=1e-6)
    if k > 0:
        assert 1.0 - at_most(k - 1, n, lower) == pytest.approx(risk, rel=1e-6)


def test_the_rule_of_three() -> None:
    assert Confidence(share=1e-3, level=0.95).samples(1) == pytest.approx(3.0 / 1e-3, rel=2e-3)


@settings(deadline=None)
@given(st.floats(1e-4, 0.2), st.floats(0.5, 0.999), st.integers(1, 200))
def test_samples_are_as_few_as_will_do(share: float, level: float, pairs: int) -> None:
    confidence = Confidence(share=share, level=level)
    n = confidence.samples(pairs)
    assert confidence.upper(0, n, pairs=pairs) <= share * (1 + 1e-9)
    assert n == 1 or confidence.upper(0, n - 1, pairs=pairs) > share * (1 - 1e-9)


def test_misuse_is_named() -> None:
    with pytest.raises(to.TrajoptError, match=r"share must lie in \(0, 1\), is 0"):
        Confidence(share=0.0)
    with pytest.raises(to.TrajoptError, match="level must lie"):
        Confidence(level=1.0)
