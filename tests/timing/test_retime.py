import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from scipy.interpolate import CubicSpline

from tests.timing.retime_cases import (
    core_timed,
    distance_from,
    largest_use,
    make_limits,
    make_path,
    moments,
    polylines,
    smooth_path,
)
from trajopt.robot.joints import JointLimits
from trajopt.timing import Retimed, RetimeFailure, RetimeOptions, retime
from trajopt.values.arrays import Floats
from trajopt.values.errors import ShapeError
from trajopt.values.trajectory import Interpolation, Path


def timed(path: Path, limits: JointLimits, options: RetimeOptions | None = None) -> Retimed:
    result = retime(path, limits, options=options or RetimeOptions())
    assert isinstance(result, Retimed), result
    return result


@settings(max_examples=120, deadline=None)
@given(polylines())
def test_limits_hold_from_rest_to_rest_along_the_path(case: tuple[Path, JointLimits]) -> None:
    path, limits = case
    result = timed(path, limits)
    trajectory = result.trajectory
    assert trajectory.velocities is not None
    assert trajectory.interpolation is Interpolation.QUINTIC
    assert largest_use(trajectory, limits).max() <= 1.0
    assert (trajectory.velocities[[0, -1]] == 0.0).all()
    assert (trajectory.positions[[0, -1]] == path.knots[[0, -1]]).all()
    assert result.deviation <= 5e-3
    if result.passes:
        again = core_timed(path, limits)
        np.testing.assert_array_equal(again.times, trajectory.times)
        assert distance_from(trajectory, smooth_path(path, limits), again.parameters) <= 1e-5


@settings(max_examples=30, deadline=None)
@given(polylines())
def test_little_is_added_between_the_points(case: tuple[Path, JointLimits]) -> None:
    result = timed(*case)
    assert result.added_duration <= 0.03 * result.trajectory.duration
    assert result.passes <= RetimeOptions().passes
    assert len(result.trajectory.times) < 400


def test_some_limit_is_used_nearly_everywhere() -> None:
    rng = np.random.default_rng(5)
    limits = make_limits(7)
    for _ in range(5):
        trajectory = timed(make_path(rng.uniform(-1.2, 1.2, (3, 7))), limits).trajectory
        t = np.linspace(0.0, trajectory.duration, 2001)
        speed, acceleration = np.abs(trajectory(t, 1)), np.abs(trajectory(t, 2))
        used = np.maximum(speed / limits.velocity, acceleration / limits.acceleration).max(axis=1)
        assert (used > 0.98).mean() > 0.9


def test_the_deviation_bound_decides_how_tight_corners_are() -> None:
    path, limits = make_path([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]]), make_limits(2)
    asked: list[int] = []

    def bound(a: Floats, b: Floats) -> Floats:
        asked.append(len(a))
        assert a.shape == b.shape == (len(a), 2)
        return 10.0 * np.linalg.norm(a - b, axis=1)

    loose, tight = timed(path, limits), retime(path, limits, deviation=bound)
    assert isinstance(tight, Retimed)
    assert asked and tight.deviation <= 5e-3
    assert tight.trajectory.duration > 1.02 * loose.trajectory.duration
    corner = np.linalg.norm(tight.trajectory(moments(tight.trajectory)) - path.knots[1], axis=1).min()
    assert corner <= 5e-4


@pytest.mark.parametrize("count", [2, 5])
def test_going_nowhere_takes_the_shortest_duration(count: int) -> None:
    result = timed(make_path([[0.5, -1.0]] * count), make_limits(2))
    assert result.trajectory.duration == RetimeOptions().shortest
    assert (result.trajectory(moments(result.trajectory)) == [0.5, -1.0]).all()
    assert (result.deviation, result.added_duration) == (0.0, 0.0)


def test_a_loop_that_ends_where_it_starts_is_a_motion() -> None:
    result = timed(make_path([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [0.0, 0.0]]), make_limits(2))
    assert result.trajectory.duration > 1.0


def test_repeated_knots_change_nothing() -> None:
    knots, limits = [[0.0, 0.0], [1.0, 0.5], [0.2, 1.0]], make_limits(2)
    repeated = [knots[0], knots[0], knots[1], knots[1], knots[1], knots[2], knots[2]]
    once, often = timed(make_path(knots), limits), timed(make_path(repeated), limits)
    np.testing.assert_array_equal(once.trajectory.times, often.trajectory.times)


@pytest.mark.parametrize("size", [1e-11, 1e-9, 1e-7, 1e-4])
def test_tiny_motions(size: float) -> None:
    rng = np.random.default_rng(1)
    limits = make_limits(4)
    path = make_path(1.0 + size * rng.uniform(-1.0, 1.0, (5, 4)))
    for options in (RetimeOptions(), RetimeOptions(shortest=1e-9)):
        trajectory = timed(path, limits, options).trajectory
        assert largest_use(trajectory, limits).max() <= 1.0
        assert trajectory.duration >= options.shortest
        assert trajectory.duration < max(2.0 * options.shortest, 20.0 * np.sqrt(size))


def test_huge_motions() -> None:
    rng = np.random.default_rng(1)
    limits = make_limits(3)
    result = timed(make_path(rng.uniform(-1e4, 1e4, (4, 3))), limits)
    assert largest_use(result.trajectory, limits).max() <= 1.0
    assert result.deviation <= 5e-3


def test_other_joints_stand_exactly_still() -> None:
    knots = np.tile([0.1, -0.7, 0.3], (4, 1))
    knots[:, 1] = [0.0, 1.0, 0.4, 2.0]
    limits = make_limits(3, velocity=[0.0, 1.0, 1.0])
    trajectory = timed(make_path(knots), limits).trajectory
    t = moments(trajectory)
    assert (trajectory(t)[:, [0, 2]] == [0.1, 0.3]).all()
    assert (trajectory(t, 2)[:, [0, 2]] == 0.0).all()


@pytest.mark.parametrize("name", ["velocity", "acceleration"])
def test_a_joint_that_may_not_move_is_a_failure(name: str) -> None:
    limits = make_limits(2, **{name: [1.0, 0.0]})
    result = retime(make_path([[0.0, 0.0], [1.0, 0.0], [2.0, 1.0]]), limits)
    assert isinstance(result, RetimeFailure)
    assert result.joint == "joint1" and name in result.reason
    assert 0.0 < result.place < 1.0


def test_scaled_limits_slow_the_motion() -> None:
    path, limits = make_path([[0.0, 0.0], [1.0, 0.5], [0.2, 1.0]]), make_limits(2)
    scaled = limits.scaled(velocity=0.5, acceleration=0.25)
    slow, fast = timed(path, scaled), timed(path, limits)
    assert slow.trajectory.duration == pytest.approx(2.0 * fast.trajectory.duration, rel=1e-6)
    assert largest_use(slow.trajectory, scaled).max() <= 1.0


def test_the_same_input_gives_the_same_bits() -> None:
    path = make_path(np.random.default_rng(2).uniform(-1.0, 1.0, (6, 7)))
    first, second = timed(path, make_limits(7)), timed(path, make_limits(7))
    np.testing.assert_array_equal(first.trajectory.coefficients, second.trajectory.coefficients)


def test_limits_of_other_joints_are_refused() -> None:
    with pytest.raises(ShapeError, match="limits"):
        retime(make_path([[0.0], [1.0]]), make_limits(2))
    unlimited = dataclasses.replace(make_limits(1), velocity=np.array([np.inf]))
    with pytest.raises(ShapeError, match="velocity"):
        retime(make_path([[0.0], [1.0]]), unlimited)


@pytest.mark.parametrize(
    "wrong", [{"path_tolerance": 0.0}, {"points": 2}, {"passes": 0}, {"shortest": 0.0}, {"remainder": np.nan}]
)
def test_options_out_of_range_are_refused(wrong: dict[str, float]) -> None:
    with pytest.raises(ShapeError, match=next(iter(wrong))):
        dataclasses.replace(RetimeOptions(), **wrong)


def test_a_deviation_that_is_not_a_number_is_refused() -> None:
    path = make_path([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]])
    with pytest.raises(ShapeError, match="deviation"):
        retime(path, make_limits(2), deviation=lambda a, b: np.full(len(a), np.nan))


def test_smooth_paths_take_few_passes_and_configurations() -> None:
    curve = CubicSpline(np.arange(4), np.random.default_rng(2).uniform(-1.0, 1.0, (4, 7)))
    path, asked = make_path(curve(np.linspace(0.0, 3.0, 24))), [0]

    def torque(q: Floats, v: Floats, a: Floats) -> Floats:
        asked[0] += len(q)
        return a

    limits = dataclasses.replace(make_limits(7), effort=np.full(7, 1e3))
    result = retime(path, limits, inverse_dynamics=torque)
    assert isinstance(result, Retimed)
    assert result.passes <= 3
    assert asked[0] <= 600
