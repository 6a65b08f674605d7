import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.oracles.retiming.constraints import TorqueLimits, torque_along, torque_range, within
from tests.timing.retime_cases import largest_use, make_limits, make_path, moments, smooth_path
from trajopt.timing import InverseDynamics, Retimed, RetimeFailure, RetimeOptions, retime
from trajopt.values.arrays import Floats
from trajopt.values.trajectory import Trajectory

INERTIA, WEIGHT = 0.4, 6.0


def pendulum(q: Floats, v: Floats, a: Floats) -> Floats:
    """A pendulum that hangs down at 0."""
    return INERTIA * a + WEIGHT * np.sin(q)


def two_links(q: Floats, v: Floats, a: Floats) -> Floats:
    """A planar arm: unit links with unit masses at their ends, gravity along -y, q = 0 along x."""
    (q0, q1), (v0, v1), (a0, a1) = q.T, v.T, a.T
    c2, s2, g = np.cos(q1), np.sin(q1), 9.81
    first = (3.0 + 2.0 * c2) * a0 + (1.0 + c2) * a1 - s2 * (2.0 * v0 * v1 + v1**2)
    second = (1.0 + c2) * a0 + a1 + s2 * v0**2
    outer = g * np.cos(q0 + q1)
    return np.stack((first + 2.0 * g * np.cos(q0) + outer, second + outer), axis=1)


def torques(trajectory: Trajectory, dynamics: InverseDynamics, each: int = 20) -> Floats:
    t = moments(trajectory, each)
    return dynamics(trajectory(t), trajectory(t, 1), trajectory(t, 2))


def test_a_pendulum_uses_the_torque_that_it_has() -> None:
    limits = make_limits(1, velocity=50.0, acceleration=1e3, effort=WEIGHT * 1.2)
    result = retime(make_path([[0.0], [3.0]]), limits, inverse_dynamics=pendulum)
    assert isinstance(result, Retimed)
    used = np.abs(torques(result.trajectory, pendulum)) / limits.effort
    assert used.max() <= 1.0
    assert (used > 0.98).mean() > 0.95


def test_the_duration_matches_the_closed_form() -> None:
    # Bang-bang torque: energy gives the speed from both ends, the switch is where they meet.
    effort, goal = WEIGHT * 1.2, 3.0
    q = np.linspace(0.0, goal, 200001)
    up = effort * q - WEIGHT * (1.0 - np.cos(q))
    down = effort * (goal - q) + WEIGHT * (np.cos(q) - np.cos(goal))
    speed = np.sqrt(2.0 / INERTIA * np.maximum(np.minimum(up, down), 0.0))
    exact = float((2.0 * np.diff(q) / (speed[:-1] + speed[1:])).sum())
    limits = make_limits(1, velocity=50.0, acceleration=1e3, effort=effort)
    result = retime(make_path([[0.0], [goal]]), limits, inverse_dynamics=pendulum)
    assert isinstance(result, Retimed)
    assert exact * 0.999 <= result.trajectory.duration <= exact * 1.01


@settings(max_examples=15, deadline=None)
@given(st.integers(0, 10**6), st.floats(1.05, 3.0))
def test_all_limits_hold_on_a_planar_arm(seed: int, strength: float) -> None:
    rng = np.random.default_rng(seed)
    path = make_path(rng.uniform(-2.0, 2.0, (4, 2)))
    limits = make_limits(2, velocity=3.0, acceleration=20.0, effort=strength * np.array((29.43, 9.81)))
    result = retime(path, limits, inverse_dynamics=two_links)
    assert isinstance(result, Retimed)
    assert (np.abs(torques(result.trajectory, two_links)) <= limits.effort).all()
    assert largest_use(result.trajectory, limits).max() <= 1.0


def test_a_joint_too_weak_for_gravity_is_named() -> None:
    limits = make_limits(2, effort=[29.0, 50.0])
    result = retime(make_path([[-1.5, 0.0], [1.5, 0.0]]), limits, inverse_dynamics=two_links)
    assert isinstance(result, RetimeFailure)
    assert result.joint == "joint0"
    assert result.place == pytest.approx(0.5, abs=0.02)
    assert "29.4" in result.reason and "29" in result.reason


@pytest.mark.parametrize("effort", [0.0, WEIGHT, WEIGHT * (1.0 + 1e-9)])
def test_a_limit_that_leaves_nothing_for_motion_is_a_failure(effort: float) -> None:
    limits = make_limits(1, effort=effort)
    result = retime(make_path([[0.0], [np.pi]]), limits, inverse_dynamics=pendulum)
    assert isinstance(result, RetimeFailure)


def test_a_limit_that_leaves_little_for_motion_is_held() -> None:
    limits = make_limits(1, effort=WEIGHT * 1.001)
    result = retime(make_path([[1.0], [2.0]]), limits, inverse_dynamics=pendulum)
    assert isinstance(result, Retimed)
    assert np.abs(torques(result.trajectory, pendulum)).max() <= limits.effort[0]


def test_friction_is_respected_although_profiles_do_not_know_it() -> None:
    def viscous(q: Floats, v: Floats, a: Floats) -> Floats:
        return pendulum(q, v, a) + 0.5 * v

    limits = make_limits(1, velocity=5.0, acceleration=50.0, effort=WEIGHT * 1.5)
    result = retime(make_path([[0.0], [2.0]]), limits, inverse_dynamics=viscous)
    assert isinstance(result, Retimed)
    assert np.abs(torques(result.trajectory, viscous)).max() <= limits.effort[0]


def test_friction_beyond_the_limit_is_a_failure() -> None:
    def dry(q: Floats, v: Floats, a: Floats) -> Floats:
        return pendulum(q, v, a) + 2.0 * WEIGHT * np.sign(v)

    limits = make_limits(1, effort=WEIGHT * 1.5)
    result = retime(make_path([[0.0], [2.0]]), limits, inverse_dynamics=dry)
    assert isinstance(result, RetimeFailure)
    assert result.joint == "joint0" and "effort" in result.reason


def test_unlimited_joints_need_no_torque() -> None:
    limits = make_limits(2, effort=[np.inf, 12.0])
    path = make_path([[-1.0, 0.5], [1.0, -0.5]])
    result = retime(path, limits, inverse_dynamics=two_links)
    assert isinstance(result, Retimed)
    assert np.abs(torques(result.trajectory, two_links))[:, 1].max() <= 12.0
    free = make_limits(2)

    def never(q: Floats, v: Floats, a: Floats) -> Floats:
        raise AssertionError("no joint has an effort limit")

    assert isinstance(retime(path, free, inverse_dynamics=never), Retimed)


@pytest.mark.parametrize("passes", [1, 2, 8])
def test_torque_limits_hold_for_any_number_of_passes(passes: int) -> None:
    corners = make_path([[-0.5, 0.3], [0.8, -0.4], [0.7, 1.2], [-0.3, -0.6]])
    limits = make_limits(2, velocity=6.0, acceleration=60.0, effort=[45.0, 14.0])
    options = RetimeOptions(passes=passes, points=20)
    result = retime(corners, limits, inverse_dynamics=two_links, options=options)
    assert isinstance(result, Retimed)
    used = np.abs(torques(result.trajectory, two_links)) / limits.effort
    assert 0.9 < used.max() <= 1.0


def test_a_long_piece_with_its_largest_torque_inside_is_seen() -> None:
    still = np.zeros((2, 1))
    swing = Trajectory(("joint0",), np.array((0.0, 9.0)), np.array(((0.0,), (np.pi,))), still, still)
    for limit in (3.0 * WEIGHT, WEIGHT):  # far from the limit, near the limit
        low, high = torque_range(TorqueLimits(pendulum, np.array([0]), np.array([limit])), swing)
        used = torques(swing, pendulum, 1000)
        assert low.item() <= used.min() and used.max() <= high.item()


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 10**6))
def test_the_torque_along_a_path_matches_the_equation_of_motion(seed: int) -> None:
    rng = np.random.default_rng(seed)
    path = smooth_path(make_path(np.cumsum(rng.uniform(-0.3, 0.3, (12, 2)), axis=0)), make_limits(2))
    asked: list[int] = []

    def counting(q: Floats, v: Floats, a: Floats) -> Floats:
        asked.append(len(q))
        return two_links(q, v, a)

    along = torque_along(path, TorqueLimits(counting, np.arange(2), np.full(2, 100.0)))
    s = np.linspace(0.0, path.length, 2001)
    x, u = rng.uniform(0.1, 1.0), rng.uniform(-1.0, 1.0)
    rows = along(s)
    found = rows.a * u + rows.b * x + rows.c
    exact = two_links(path(s), path(s, 1) * np.sqrt(x), path(s, 1) * u + path(s, 2) * x)
    assert np.abs(found - exact).max() <= 5e-3 * np.abs(exact).max()
    assert sum(asked) <= 3 * (2 * 3 * len(path.knots) + 1)


def test_states_within_pieces_are_those_of_the_trajectory() -> None:
    rng = np.random.default_rng(4)
    q, v, a = rng.normal(size=(3, 6, 2))
    moved = Trajectory(("a", "b"), np.array((0.0, 0.3, 0.5, 1.1, 2.0, 2.1)), q, v, a)
    pieces = np.array([0, 2, 4])
    t = moved.times[pieces] + 0.3 * np.diff(moved.times)[pieces]
    for order, found in enumerate(within(moved, 0.3, pieces)):
        np.testing.assert_allclose(found, moved(t, order), rtol=1e-9, atol=1e-12)
