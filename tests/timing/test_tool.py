"""Limits on the speed of tools: they hold between points too, and cost no more than they must."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.timing.retime_cases import largest_use, make_limits, make_path, moments, polylines
from trajopt.robot.joints import JointLimits
from trajopt.timing import Retimed, ToolLimits, retime
from trajopt.values.arrays import Floats
from trajopt.values.trajectory import Path


def chain_speeds(q: Floats, v: Floats) -> Floats:
    """Speed of the tip of a planar chain of links of 0.4 m, and how fast its last link turns."""
    angle, turning = np.cumsum(q, axis=1), np.cumsum(v, axis=1)
    velocity = 0.4 * np.stack((-np.sin(angle) * turning, np.cos(angle) * turning)).sum(axis=2)
    return np.stack((np.linalg.norm(velocity, axis=0), np.abs(turning[:, -1])), axis=1)


def tools(linear: float, angular: float) -> ToolLimits:
    return ToolLimits(chain_speeds, np.array((linear, angular)), ("speed of tip", "turning of tip"))


@settings(max_examples=60, deadline=None)
@given(polylines(), st.floats(-2.0, 1.0), st.floats(-2.0, 1.0))
def test_tool_speeds_hold_between_the_points(
    case: tuple[Path, JointLimits], linear: float, angular: float
) -> None:
    path, limits = case
    limited = tools(10.0**linear, 10.0**angular)
    result = retime(path, limits, tools=limited)
    assert isinstance(result, Retimed), result
    t = moments(result.trajectory)
    speeds = chain_speeds(result.trajectory(t), result.trajectory(t, 1))
    assert (speeds <= limited.limit).all()
    assert largest_use(result.trajectory, limits).max() <= 1.0


def test_a_slow_tool_takes_the_time_of_its_way() -> None:
    path, limits = make_path([[0.0], [1.5]]), make_limits(1)
    result = retime(path, limits, tools=tools(0.2, np.inf))
    assert isinstance(result, Retimed)
    speed = 0.2 / 0.4
    exact = 1.5 / speed + speed / 8.0  # a trapezoid
    assert exact <= result.trajectory.duration <= 1.005 * exact


def test_a_limit_that_does_not_bind_changes_nothing() -> None:
    path = make_path(np.random.default_rng(3).uniform(-1.0, 1.0, (6, 3)))
    free, loose = retime(path, make_limits(3)), retime(path, make_limits(3), tools=tools(1e3, 1e3))
    assert isinstance(free, Retimed) and isinstance(loose, Retimed)
    np.testing.assert_array_equal(free.trajectory.coefficients, loose.trajectory.coefficients)


@pytest.mark.parametrize("joints", [1, 3])
def test_a_path_that_goes_nowhere_needs_no_tool(joints: int) -> None:
    path = make_path(np.ones((2, joints)))
    assert isinstance(retime(path, make_limits(joints), tools=tools(0.1, 0.1)), Retimed)
