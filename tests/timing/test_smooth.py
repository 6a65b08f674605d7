import numpy as np
import pytest
from hypothesis import given, settings

from tests.oracles.retiming.smoothing import polyline
from tests.timing.retime_cases import make_limits, make_path, polylines, smooth_path, smoothing
from trajopt.robot.joints import JointLimits
from trajopt.values.arrays import Floats
from trajopt.values.trajectory import Path


def test_a_straight_line_stays_straight_and_even() -> None:
    path = smooth_path(make_path([[0.0, 1.0], [1.0, 0.0]]), make_limits(2))
    s = np.linspace(0.0, path.length, 50)
    expected = np.stack((s, path.length - s), axis=1) / path.length
    np.testing.assert_allclose(path(s), expected, atol=1e-15)
    np.testing.assert_allclose(path(s, 2), 0.0, atol=1e-12)


def test_it_passes_through_the_knots_of_a_path_that_is_smooth_already() -> None:
    angle = np.linspace(0.0, 2.0, 24)
    path = make_path(np.stack((np.cos(angle), np.sin(angle)), axis=1))
    limits = make_limits(2)
    curve = smooth_path(path, limits)
    s = polyline(path.knots, limits.velocity).parameters
    np.testing.assert_allclose(curve(s), path.knots, atol=1e-12)


def test_a_sharp_corner_is_rounded_within_the_tolerance_and_not_much_less() -> None:
    path, limits = make_path([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]]), make_limits(2)
    for tolerance in (1e-2, 1e-3, 1e-4):
        curve = smooth_path(path, limits, tolerance)
        nearest = np.linalg.norm(curve(np.linspace(0.0, curve.length, 20001)) - path.knots[1], axis=1).min()
        assert 0.8 * tolerance < nearest <= np.sqrt(2.0) * tolerance


@settings(max_examples=40, deadline=None)
@given(polylines())
def test_the_deviation_holds_between_the_samples_too(case: tuple[Path, JointLimits]) -> None:
    path, limits = case
    line = polyline(path.knots, limits.velocity)
    if line.length == 0.0:
        return
    weights = np.linspace(1.0, 0.2, len(path.joint_names))

    def bound(a: Floats, b: Floats) -> Floats:
        return np.abs(a - b) @ weights

    found = smoothing(path, limits, 2e-3, bound)
    s = np.linspace(0.0, line.length, 4001)
    far = bound(found.path(s), line.origin + line(s))
    assert far.max() <= 2e-3
    assert found.deviation <= 2e-3
    assert far.max() <= found.deviation / 0.97 + 1e-12


@settings(max_examples=20, deadline=None)
@given(polylines())
def test_its_second_derivative_is_continuous(case: tuple[Path, JointLimits]) -> None:
    path, limits = case
    line = polyline(path.knots, limits.velocity)
    if line.length == 0.0:
        return
    curve = smooth_path(path, limits)
    inner = curve.knots[1:-1]
    step = 1e-7 * np.minimum(np.diff(curve.knots)[:-1], np.diff(curve.knots)[1:])
    for order in (0, 1, 2):
        before, after = curve(inner - step, order), curve(inner + step, order)
        scale = max(1.0, float(np.abs(curve(curve.knots, order)).max()))
        np.testing.assert_allclose(before, after, atol=1e-5 * scale)


def test_position_limits_hold_where_the_path_touches_them() -> None:
    rng = np.random.default_rng(3)
    limits = make_limits(3, position=1.0)
    for _ in range(20):
        path = make_path(np.clip(rng.uniform(-2.0, 2.0, (7, 3)), -1.0, 1.0))
        curve = smooth_path(path, limits, 0.05)
        q = curve(np.linspace(0.0, curve.length, 2001))
        assert np.abs(q).max() <= 1.0 + 1e-12


def test_repeated_knots_are_merged_and_both_ends_kept() -> None:
    knots = [[0.0], [0.0], [1.0], [1.0 + 1e-13], [2.0], [2.0]]
    line = polyline(np.array(knots), np.ones(1))
    np.testing.assert_allclose(line.corners, [[0.0], [1.0], [2.0]])
    assert line.goal == pytest.approx(2.0)


def test_a_still_joint_has_derivatives_of_exactly_zero() -> None:
    path = make_path([[0.3, 0.0], [0.3, 1.0], [0.3, 0.2]])
    curve = smooth_path(path, make_limits(2))
    s = np.linspace(0.0, curve.length, 500)
    assert (curve(s)[:, 0] == 0.3).all()
    assert (curve(s, 1)[:, 0] == 0.0).all() and (curve(s, 2)[:, 0] == 0.0).all()


@settings(max_examples=40, deadline=None)
@given(polylines())
def test_samples_that_are_not_measured_are_not_the_largest(case: tuple[Path, JointLimits]) -> None:
    path, limits = case
    line = polyline(path.knots, limits.velocity)
    if line.length == 0.0:
        return

    def bound(a: Floats, b: Floats) -> Floats:
        return np.linalg.norm(a - b, axis=1)

    found = smoothing(path, limits, 2e-3, bound)
    knots = found.path.knots
    s = (knots[:-1, None] + np.diff(knots)[:, None] * np.arange(8) / 8).ravel()
    assert bound(found.path(s), line.origin + line(s)).max() <= found.deviation * (1.0 + 1e-9) + 1e-8
