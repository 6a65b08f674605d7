"""Durations compared with closed forms, and with TOPP-RA's own implementation."""

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from tests.oracles.retiming.smooth_path import SmoothPath
from tests.timing.retime_cases import make_limits, make_path, smooth_path
from trajopt.robot.joints import JointLimits
from trajopt.timing import Retimed, retime
from trajopt.values.arrays import Floats
from trajopt.values.trajectory import Path


def duration(path: Path, limits: JointLimits) -> float:
    result = retime(path, limits)
    assert isinstance(result, Retimed)
    return result.trajectory.duration


@pytest.mark.parametrize("distance", [1e-3, 0.1, 1.0, 10.0])
def test_a_single_joint_takes_the_time_of_the_trapezoid(distance: float) -> None:
    velocity, acceleration = 2.0, 8.0
    if distance < velocity**2 / acceleration:
        exact = 2.0 * np.sqrt(distance / acceleration)
    else:
        exact = distance / velocity + velocity / acceleration
    found = duration(make_path([[0.0], [distance]]), make_limits(1))
    assert exact <= found <= 1.005 * exact


def test_on_a_straight_line_the_slowest_joint_decides() -> None:
    found = duration(make_path([[0.0, 0.0], [1.0, 3.0]]), make_limits(2))
    assert 3.0 / 2.0 + 2.0 / 8.0 <= found <= 1.005 * (3.0 / 2.0 + 2.0 / 8.0)


def toppra_duration(path: SmoothPath, limits: JointLimits) -> float:
    """Plain TOPP-RA on a fine grid."""
    algorithm = pytest.importorskip("toppra.algorithm")
    constraint = pytest.importorskip("toppra.constraint")
    interpolator = pytest.importorskip("toppra.interpolator")

    class Curve(interpolator.AbstractGeometricPath):
        dof = len(limits.joint_names)
        path_interval = np.array((0.0, path.length))

        def __call__(self, s: Floats, order: int = 0) -> Floats:
            return path(np.atleast_1d(s), order)

    grid = np.unique(np.concatenate((np.linspace(0.0, path.length, 1001), path.knots)))
    grid = grid[np.concatenate(((True,), np.diff(grid) > 1e-9))]
    grid[-1] = path.length
    both = [
        constraint.JointVelocityConstraint(np.stack((-limits.velocity, limits.velocity), axis=1)),
        constraint.JointAccelerationConstraint(
            np.stack((-limits.acceleration, limits.acceleration), axis=1), discretization_scheme=1
        ),
    ]
    solver = algorithm.TOPPRA(both, Curve(), gridpoints=grid, solver_wrapper="seidel")
    _, speed, _, _ = solver.compute_parameterization(0, 0, return_data=True)
    return float((2.0 * np.diff(grid) / (speed[:-1] + speed[1:])).sum())


@pytest.mark.parametrize("seed", range(6))
def test_little_longer_than_plain_toppra_on_smooth_paths(seed: int) -> None:
    rng = np.random.default_rng(seed)
    curve = CubicSpline(np.arange(4), rng.uniform(-1.2, 1.2, (4, 7)))
    path, limits = make_path(curve(np.linspace(0.0, 3.0, 24))), make_limits(7)
    plain = toppra_duration(smooth_path(path, limits), limits)
    assert 0.99 * plain <= duration(path, limits) <= 1.03 * plain


@pytest.mark.parametrize("seed", range(4))
def test_little_longer_than_plain_toppra_around_corners(seed: int) -> None:
    rng = np.random.default_rng(seed)
    path, limits = make_path(rng.uniform(-1.2, 1.2, (5, 6))), make_limits(6)
    plain = toppra_duration(smooth_path(path, limits), limits)
    assert 0.99 * plain <= duration(path, limits) <= 1.03 * plain
