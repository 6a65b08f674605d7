"""The core against retiming in plain Python, from the polyline to the trajectory."""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.oracles.retiming.constraints import TorqueLimits
from tests.oracles.retiming.smoothing import polyline, smooth
from tests.oracles.retiming.timing import fastest_trajectory
from tests.timing.retime_cases import core_timed, make_limits, make_path, polylines
from tests.timing.test_tool import chain_speeds
from tests.timing.test_torque import two_links
from trajopt.robot.joints import JointLimits
from trajopt.timing import DeviationBound, Retimed, RetimeFailure, RetimeOptions, ToolLimits, retime
from trajopt.values.arrays import Floats
from trajopt.values.errors import ShapeError
from trajopt.values.trajectory import Path


def compare(
    path: Path,
    limits: JointLimits,
    *,
    torque: bool = False,
    tools: Floats | None = None,
    deviation: DeviationBound | None = None,
    options: RetimeOptions | None = None,
) -> None:
    """Check that the core does what plain Python does; both may refuse."""
    options = options or RetimeOptions()
    limited = None if tools is None else ToolLimits(chain_speeds, tools, ("speed", "turning"))
    found = retime(
        path,
        limits,
        inverse_dynamics=two_links if torque else None,
        tools=limited,
        deviation=deviation,
        options=options,
    )
    line = polyline(path.knots, limits.velocity)
    smoothing = smooth(
        line, lower=limits.lower, upper=limits.upper, deviation=deviation, tolerance=options.path_tolerance
    )
    expected, _ = fastest_trajectory(
        smoothing,
        limits,
        options=options,
        torque=TorqueLimits(two_links, np.arange(2), limits.effort) if torque else None,
        tools=limited,
    )
    if isinstance(expected, RetimeFailure):
        assert isinstance(found, RetimeFailure)
        assert found.joint == expected.joint
        assert found.place == pytest.approx(expected.place, abs=1e-6)
        return
    assert isinstance(found, Retimed)
    assert found.deviation == pytest.approx(expected.deviation, rel=1e-6, abs=1e-12)
    assert found.passes == expected.passes
    assert found.added_duration == pytest.approx(expected.added_duration, abs=1e-6)
    np.testing.assert_allclose(found.trajectory.times, expected.trajectory.times, rtol=1e-6)
    np.testing.assert_allclose(found.trajectory.positions, expected.trajectory.positions, atol=1e-6)
    for mine, other in (
        (found.trajectory.velocities, expected.trajectory.velocities),
        (found.trajectory.accelerations, expected.trajectory.accelerations),
    ):
        assert mine is not None and other is not None
        np.testing.assert_allclose(mine, other, atol=1e-4 * max(1.0, float(np.abs(other).max())))
    assert dict(found.binding) == pytest.approx(dict(expected.binding), abs=0.02)


def corners(seed: int, joints: int) -> Path:
    return make_path(np.random.default_rng(seed).uniform(-1.2, 1.2, (5, joints)))


def curve(seed: int, joints: int) -> Path:
    """A smooth path of 24 knots."""
    weights = np.random.default_rng(seed).uniform(-0.5, 0.5, (3, joints))
    return make_path(np.sin(np.linspace(0.0, 2.0, 24)[:, None] * np.arange(1, 4)) @ weights)


def jerky(limits: JointLimits, jerk: float) -> JointLimits:
    return replace(limits, jerk=np.full(len(limits.jerk), jerk))


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("make", [corners, curve])
@pytest.mark.parametrize("jerk", [np.inf, 40.0])
def test_it_times_paths_as_plain_python_does(
    seed: int, make: Callable[[int, int], Path], jerk: float
) -> None:
    compare(make(seed, 5), jerky(make_limits(5), jerk))


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("jerk", [np.inf, 60.0])
def test_torques_are_limited_as_in_plain_python(seed: int, jerk: float) -> None:
    strong = make_limits(2, velocity=3.0, acceleration=20.0, effort=1.6 * np.array((29.43, 9.81)))
    compare(corners(seed, 2), jerky(strong, jerk), torque=True)
    weak = replace(strong, effort=np.array((25.0, 9.0)))
    compare(corners(seed, 2), jerky(weak, jerk), torque=True)


@pytest.mark.parametrize("jerk", [np.inf, 60.0])
def test_tools_are_limited_as_in_plain_python(jerk: float) -> None:
    limits = jerky(make_limits(3), jerk)
    for seed in range(3):
        compare(curve(seed, 3), limits, tools=np.array((0.4, 1.0)))


@settings(max_examples=25, deadline=None)
@given(polylines(), st.sampled_from((np.inf, 30.0)))
def test_any_polyline_is_timed_as_in_plain_python(case: tuple[Path, JointLimits], jerk: float) -> None:
    path, limits = case
    if np.abs(path.knots - path.knots[0]).max() > 1e-12:
        compare(path, jerky(limits, jerk))


@settings(max_examples=40, deadline=None)
@given(polylines(), st.sampled_from((5e-3, 1e-4)), st.booleans())
def test_paths_are_smoothed_as_in_plain_python(
    case: tuple[Path, JointLimits], tolerance: float, measured: bool
) -> None:
    path, limits = case
    if np.abs(path.knots - path.knots[0]).max() <= 1e-12:
        return

    def bound(smooth: Floats, straight: Floats) -> Floats:
        return 2.0 * np.linalg.norm(smooth - straight, axis=1)

    deviation = bound if measured else None
    found = core_timed(path, limits, tolerance, deviation)
    line = polyline(path.knots, limits.velocity)
    expected = smooth(line, lower=limits.lower, upper=limits.upper, deviation=deviation, tolerance=tolerance)
    np.testing.assert_allclose(found.knots, expected.path.knots, rtol=1e-9)
    np.testing.assert_allclose(found.control, expected.path.control, atol=1e-9 * np.ptp(path.knots))
    assert found.deviation == pytest.approx(expected.deviation, rel=1e-6, abs=1e-12)


def of_another_shape(*states: Floats) -> Floats:
    return np.zeros(3)


def of_no_number(*states: Floats) -> Floats:
    return np.full_like(states[0], np.nan)


@pytest.mark.parametrize(
    ("function", "words"), [(of_another_shape, "an array 3, not"), (of_no_number, "not finite")]
)
def test_functions_that_return_something_else_are_named(function: Callable[..., Floats], words: str) -> None:
    path, limits = corners(0, 2), make_limits(2, effort=50.0)
    with pytest.raises(ShapeError, match=f"inverse_dynamics: returned .*{words}"):
        retime(path, limits, inverse_dynamics=function)
    with pytest.raises(ShapeError, match=r"tools\.speeds: returned"):
        retime(path, limits, tools=ToolLimits(function, np.array((1.0, 1.0, 1.0)), ("a", "b", "c")))
    with pytest.raises(ShapeError, match="deviation: returned"):
        retime(path, limits, deviation=function)


def test_exceptions_of_a_function_pass_through() -> None:
    def broken(*states: Floats) -> Floats:
        raise LookupError("no robot")

    with pytest.raises(LookupError, match="no robot"):
        retime(corners(0, 2), make_limits(2, effort=50.0), inverse_dynamics=broken)


def test_overflowing_distances_are_reported() -> None:
    far = make_path([[0.0, 0.0], [1e200, 1e200], [0.0, 1e200]])
    with pytest.raises(ShapeError, match="path: has knots so far apart"):
        retime(far, make_limits(2, velocity=1.0e200, acceleration=1e200))
    slow = retime(far, make_limits(2))
    assert isinstance(slow, RetimeFailure) and "s are the most" in slow.reason


def test_threads_time_paths_concurrently() -> None:
    """Each with functions of its own, to the same bits as alone."""
    limits = jerky(make_limits(2, velocity=3.0, acceleration=20.0, effort=np.array((50.0, 20.0))), 60.0)

    def times(seed: int) -> Floats:
        found = retime(corners(seed, 2), limits, inverse_dynamics=two_links)
        assert isinstance(found, Retimed)
        return found.trajectory.times

    alone = [times(seed) for seed in range(8)]
    with ThreadPoolExecutor(4) as pool:
        for together, expected in zip(pool.map(times, range(8)), alone, strict=True):
            np.testing.assert_array_equal(together, expected)
