"""Jerk-limited timing: limits at all times, rest at both ends, and little more time than must be."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import CubicSpline

from tests.oracles.retiming.peaks import jerk_peaks
from tests.timing.retime_cases import (
    core_timed,
    distance_from,
    largest_use,
    make_limits,
    make_path,
    polylines,
    smooth_path,
)
from trajopt.robot.joints import JointLimits
from trajopt.timing import Retimed, RetimeFailure, ToolLimits, retime
from trajopt.values.arrays import Floats
from trajopt.values.trajectory import Path, Trajectory


def with_jerk(limits: JointLimits, jerk: float | Floats) -> JointLimits:
    return dataclasses.replace(limits, jerk=np.broadcast_to(jerk, limits.velocity.shape).astype(float))


def timed(path: Path, limits: JointLimits) -> Retimed:
    result = retime(path, limits)
    assert isinstance(result, Retimed), result
    return result


def dense_jerk(trajectory: Trajectory) -> Floats:
    return np.abs(trajectory(np.linspace(0.0, trajectory.duration, 3001), 3))


def s_curve(distance: float, velocity: float, acceleration: float, jerk: float) -> float:
    """Least duration from rest to rest of one joint: up to seven segments of constant jerk."""
    ramp = acceleration / jerk
    rise = (
        velocity / acceleration + ramp if velocity >= acceleration * ramp else 2.0 * np.sqrt(velocity / jerk)
    )
    if distance >= velocity * rise:  # the largest velocity is reached
        return distance / velocity + rise
    if distance >= 2.0 * acceleration * ramp**2:  # the largest acceleration is
        peak = (
            -acceleration * ramp + np.sqrt((acceleration * ramp) ** 2 + 4.0 * acceleration * distance)
        ) / 2.0
        return 2.0 * (peak / acceleration + ramp)
    return 4.0 * np.cbrt(distance / (2.0 * jerk))


@pytest.mark.parametrize("distance", [1e-4, 1e-3, 0.02, 0.1, 0.4, 1.0, 10.0])
@pytest.mark.parametrize("jerk", [10.0, 80.0])
def test_a_single_joint_takes_the_time_of_the_s_curve(distance: float, jerk: float) -> None:
    limits = with_jerk(make_limits(1), jerk)
    found = timed(make_path([[0.0], [distance]]), limits).trajectory.duration
    exact = s_curve(distance, 2.0, 8.0, jerk)
    assert exact <= found <= 1.01 * exact


def test_a_jerk_limit_that_hardly_binds_costs_little() -> None:
    free = timed(make_path([[0.0], [1.0]]), make_limits(1)).trajectory.duration
    found = timed(make_path([[0.0], [1.0]]), with_jerk(make_limits(1), 1e5)).trajectory.duration
    assert free <= found <= 1.03 * free


@settings(max_examples=60, deadline=None)
@given(polylines(), st.floats(0.5, 3.5))
def test_all_limits_hold_from_rest_to_rest_along_the_path(
    case: tuple[Path, JointLimits], magnitude: float
) -> None:
    path, bounds = case
    limits = with_jerk(bounds, 10.0**magnitude)
    result = timed(path, limits)
    trajectory = result.trajectory
    assert trajectory.velocities is not None and trajectory.accelerations is not None
    assert largest_use(trajectory, limits).max() <= 1.0
    assert (dense_jerk(trajectory) <= limits.jerk).all()
    assert (jerk_peaks(trajectory) <= limits.jerk).all()
    assert (trajectory.velocities[[0, -1]] == 0.0).all()
    assert (trajectory.accelerations[[0, -1]] == 0.0).all()
    assert (trajectory.positions[[0, -1]] == path.knots[[0, -1]]).all()
    if result.passes:
        again = core_timed(path, limits)
        np.testing.assert_array_equal(again.times, trajectory.times)
        assert distance_from(trajectory, smooth_path(path, limits), again.parameters) <= 1e-4


@pytest.mark.parametrize("seed", range(6))
def test_much_faster_than_uniform_stretching_on_smooth_paths(seed: int) -> None:
    rng = np.random.default_rng(seed)
    curve = CubicSpline(np.arange(4), rng.uniform(-1.2, 1.2, (4, 7)))
    path, limits = make_path(curve(np.linspace(0.0, 3.0, 24))), make_limits(7)
    free = timed(path, limits).trajectory
    stretched = free.duration * np.cbrt(jerk_peaks(free).max() / 80.0)
    found = timed(path, with_jerk(limits, 80.0)).trajectory.duration
    assert free.duration < found < 0.8 * stretched
    assert found < 1.4 * free.duration


def test_only_some_joints_have_limits() -> None:
    path = make_path(np.random.default_rng(5).uniform(-1.0, 1.0, (6, 3)))
    limits = with_jerk(make_limits(3), np.array((50.0, np.inf, np.inf)))
    trajectory = timed(path, limits).trajectory
    assert (dense_jerk(trajectory)[:, 0] <= 50.0).all()
    assert largest_use(trajectory, limits).max() <= 1.0


def test_limits_of_joints_that_stand_still_change_nothing() -> None:
    path = make_path([[0.0, 0.3], [1.0, 0.3]])
    limits = with_jerk(make_limits(2), np.array((np.inf, 10.0)))
    free, same = timed(path, make_limits(2)), timed(path, limits)
    np.testing.assert_array_equal(free.trajectory.coefficients, same.trajectory.coefficients)


@pytest.mark.parametrize(
    "knots",
    [
        [[0.0, 0.0], [1.0, 0.0], [0.0, 0.0]],
        [[0.0, 0.0], [1.0, 1.0], [0.5, 0.5], [2.0, 2.0]],
        [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [0.0, 0.0]],
        [[0.0, 0.0], [1e-7, 2e-7], [1.0, 0.0]],
    ],
)
def test_paths_that_turn_back(knots: list[list[float]]) -> None:
    limits = with_jerk(make_limits(2), 60.0)
    trajectory = timed(make_path(knots), limits).trajectory
    assert largest_use(trajectory, limits).max() <= 1.0
    assert (jerk_peaks(trajectory) <= limits.jerk).all()


@pytest.mark.parametrize("size", [1e-9, 1e-7, 1e-4])
def test_tiny_motions(size: float) -> None:
    rng = np.random.default_rng(1)
    limits = with_jerk(make_limits(4), 80.0)
    path = make_path(1.0 + size * rng.uniform(-1.0, 1.0, (5, 4)))
    trajectory = timed(path, limits).trajectory
    assert (jerk_peaks(trajectory) <= limits.jerk).all()
    assert trajectory.duration < max(0.02, 40.0 * np.cbrt(size))


def test_standing_still_has_no_jerk() -> None:
    trajectory = timed(make_path([[0.5], [0.5]]), with_jerk(make_limits(1), 1.0)).trajectory
    assert (dense_jerk(trajectory) == 0.0).all()


def test_tools_and_torques_are_limited_too() -> None:
    path = make_path(np.random.default_rng(7).uniform(-1.0, 1.0, (4, 2)))
    limits = dataclasses.replace(with_jerk(make_limits(2), 60.0), effort=np.array((3.0, 2.5)))

    def torque(q: Floats, v: Floats, a: Floats) -> Floats:
        return 0.5 * a + 1.2 * np.cos(q)

    def speed(q: Floats, v: Floats) -> Floats:
        return np.abs(v).sum(axis=1, keepdims=True)

    tools = ToolLimits(speed, np.array((0.8,)), ("speed of tip",))
    result = retime(path, limits, inverse_dynamics=torque, tools=tools)
    assert isinstance(result, Retimed), result
    t = np.linspace(0.0, result.trajectory.duration, 3001)
    q, v, a = (result.trajectory(t, order) for order in range(3))
    assert (np.abs(torque(q, v, a)) <= limits.effort).all()
    assert (speed(q, v) <= 0.8).all()
    assert (jerk_peaks(result.trajectory) <= limits.jerk).all()


def test_the_same_input_gives_the_same_bits() -> None:
    path = make_path(np.random.default_rng(2).uniform(-1.0, 1.0, (6, 7)))
    limits = with_jerk(make_limits(7), 100.0)
    first, second = timed(path, limits), timed(path, limits)
    np.testing.assert_array_equal(first.trajectory.coefficients, second.trajectory.coefficients)


def test_extremes_of_the_jerk_are_exact() -> None:
    rng = np.random.default_rng(4)
    times = np.concatenate(((0.0,), np.cumsum(rng.uniform(0.1, 1.0, 5))))
    trajectory = Trajectory(("a", "b"), times, *rng.normal(size=(3, 6, 2)))
    peaks = jerk_peaks(trajectory)
    for piece in range(5):
        t = np.linspace(times[piece], times[piece + 1], 5001)[:-1]
        found = np.abs(trajectory(t, 3)).max(axis=0)
        np.testing.assert_allclose(peaks[piece], found, rtol=5e-3)
        assert (found <= peaks[piece] * (1.0 + 1e-12)).all()


def test_a_joint_without_jerk_may_stand_still_only() -> None:
    limits = with_jerk(make_limits(2), np.array((50.0, 0.0)))
    assert (jerk_peaks(timed(make_path([[0.0, 0.5], [1.0, 0.5]]), limits).trajectory)[:, 1] == 0.0).all()
    refused = retime(make_path([[0.0, 0.0], [1.0, 1.0]]), limits)
    assert isinstance(refused, RetimeFailure)
    assert refused.joint == "joint1" and "jerk" in refused.reason


def test_reports_the_binding_limits() -> None:
    free = timed(make_path([[0.0], [4.0]]), make_limits(1))  # 0.25 s up, 1.75 s at full speed, 0.25 s down
    assert list(free.binding) == ["velocity", "acceleration"]
    assert free.binding["velocity"] == pytest.approx(1.75 / 2.25, abs=0.03)
    assert free.binding["acceleration"] == pytest.approx(0.5 / 2.25, abs=0.03)
    slow = timed(make_path([[0.0], [0.01]]), with_jerk(make_limits(1), 10.0))
    assert list(slow.binding) == ["jerk"]
    assert slow.binding["jerk"] > 0.9
    tools = ToolLimits(lambda q, v: np.abs(v), np.array((0.5,)), ("speed of tip",))
    held = retime(make_path([[0.0], [4.0]]), make_limits(1), tools=tools)
    assert isinstance(held, Retimed)
    assert held.binding["tool speed"] > 0.9
    assert timed(make_path([[0.5], [0.5]]), make_limits(1)).binding == {}
