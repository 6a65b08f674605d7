"""Slow motions and many waypoints cost the judge little, and numbers that overflow are refused at once."""

from dataclasses import replace

import numpy as np
import pytest

import trajopt as to
from trajopt.problem.requirements import joint_positions
from trajopt.values.errors import ProblemError, ShapeError
from trajopt.verify import Judge, Specification
from trajopt.verify.checks.torques import inverse_dynamics
from trajopt.verify.kernel.kinematics import Kinematics
from trajopt.verify.kernel.motion import JudgedMotion, sampled_times, steps_in_pieces
from trajopt.verify.kernel.options import VerifyOptions

pytestmark = pytest.mark.timeout(60)


@pytest.fixture(scope="module")
def problem() -> to.Problem:
    return to.named_problem("bar_panda")


@pytest.fixture(scope="module")
def trajectory(problem: to.Problem) -> to.Trajectory:
    found = to.plan(problem).trajectory
    assert found is not None
    return found


def slowed(of: to.Trajectory, factor: float) -> to.Trajectory:
    assert of.velocities is not None and of.accelerations is not None
    return to.Trajectory(
        of.joint_names,
        of.times * factor,
        of.positions,
        of.velocities / factor,
        of.accelerations / factor**2,
    )


def moved(problem: to.Problem, trajectory: to.Trajectory) -> JudgedMotion:
    kinematics = Kinematics(problem.reduced)
    return JudgedMotion(problem.reduced, trajectory, kinematics=kinematics, options=VerifyOptions())


@pytest.mark.parametrize("scaling", [1e-3, 1e-5, 1e-6])
def test_a_slow_motion_is_planned_with_as_many_samples(problem: to.Problem, scaling: float) -> None:
    def samples(velocity: float, acceleration: float) -> int:
        result = to.plan(
            replace(problem, velocity_scaling=velocity, acceleration_scaling=acceleration),
            budget=to.Budget(attempts=1),
        )
        assert result.verified and result.trajectory is not None
        motion = moved(problem, result.trajectory)
        return len(sampled_times(motion)) + len(inverse_dynamics(motion)[0])

    assert samples(scaling, scaling**2) < 1.1 * samples(1e-2, 1e-4)
    assert samples(scaling, 1.0) < 1.1 * samples(1e-2, 1.0)


def test_samples_grow_with_the_way_and_not_with_the_time(
    problem: to.Problem, trajectory: to.Trajectory
) -> None:
    counts = [
        int(steps_in_pieces(moved(problem, slowed(trajectory, factor))).sum()) for factor in (1e4, 1e6, 1e8)
    ]
    assert counts[0] == counts[1] == counts[2] < 20 * len(trajectory.times)
    usual = moved(problem, trajectory)
    even = np.linspace(0.0, trajectory.duration, int(np.ceil(trajectory.duration / 0.01)) + 1)
    assert np.array_equal(sampled_times(usual), np.unique(np.concatenate((even, trajectory.times))))


def test_a_slow_motion_is_refused_for_a_violation_between_its_points(problem: to.Problem) -> None:
    start = problem.reduced.start_positions
    there = np.stack((start, start + 0.4, start))
    still = np.zeros_like(there)
    slow = to.Trajectory(problem.reduced.joint_names, np.array((0.0, 5e4, 1e5)), there, still)
    seen = sampled_times(moved(problem, slow))
    steps = np.abs(np.diff(slow(seen), axis=0)).max()
    assert steps <= 1e-3 and len(seen) < 5000


def test_a_motion_that_would_take_too_many_samples_is_refused(problem: to.Problem) -> None:
    start = problem.reduced.start_positions
    far = np.stack((start, start + 1e5))
    long = to.Trajectory(problem.reduced.joint_names, np.array((0.0, 1e6)), far, np.zeros_like(far))
    with pytest.raises(ProblemError, match="in parts"):
        steps_in_pieces(moved(problem, long))


@pytest.mark.parametrize("column", ["positions", "velocities", "accelerations"])
def test_one_number_of_1e300_is_refused(problem: to.Problem, trajectory: to.Trajectory, column: str) -> None:
    columns = {
        name: getattr(trajectory, name).copy() for name in ("positions", "velocities", "accelerations")
    }
    columns[column][5, 2] = 1e300
    huge = to.Trajectory(trajectory.joint_names, trajectory.times, **columns)
    with pytest.raises(ShapeError, match="panda_joint3 are not a motion"):
        to.judge(problem, huge)


@pytest.mark.parametrize("size", [1e10, 1e40, 1e80])
def test_large_numbers_are_judged(problem: to.Problem, trajectory: to.Trajectory, size: float) -> None:
    assert trajectory.velocities is not None
    velocities = trajectory.velocities.copy()
    velocities[5, 2] = size
    verdict = to.judge(problem, replace(trajectory, velocities=velocities))
    assert not verdict.verified and any(
        check.name == "velocity" and not check.holds for check in verdict.checks
    )


def test_points_too_near_and_ends_too_far_are_refused(problem: to.Problem, trajectory: to.Trajectory) -> None:
    times = trajectory.times.copy()
    times[1] = 1e-300
    with pytest.raises(ShapeError, match="too near to each other"):
        to.judge(problem, replace(trajectory, times=times))
    with pytest.raises(ShapeError, match="are the most"):
        slowed(trajectory, 1e100)


@pytest.mark.parametrize(("velocity", "acceleration"), [(1e-12, 1.0), (1.0, 1e-300), (1e-300, 1e-300)])
def test_limits_that_allow_almost_no_motion_are_reported(
    problem: to.Problem, velocity: float, acceleration: float
) -> None:
    asked = replace(problem, velocity_scaling=velocity, acceleration_scaling=acceleration)
    result = to.plan(asked, budget=to.Budget(attempts=1))
    assert result.status is to.Status.NO_TIMING and "are the most" in result.reason


def evaluations(count: int, monkeypatch: pytest.MonkeyPatch) -> int:
    """Count the moments looked up to judge a motion through `count` waypoints."""
    arm = to.load("planar2")
    stops = [{"joint1": 0.5 * np.sin(place), "joint2": 0.3 + 0.01 * place} for place in range(count)]
    problem = to.Problem(scene=to.Scene(arm), start=stops[0], goal=stops[-1])
    rows = np.array([[stop[name] for name in problem.reduced.joint_names] for stop in stops])
    motion = to.Trajectory(problem.reduced.joint_names, np.arange(count, dtype=float), rows)
    waypoints = {str(place): (joint_positions(stop),) for place, stop in enumerate(stops)}
    times = list[int]()
    lookup = to.Trajectory.__call__

    def counted(self: to.Trajectory, t: object, order: int = 0) -> np.ndarray:
        times.append(np.size(t))  # pyright: ignore
        return lookup(self, t, order)  # pyright: ignore

    with monkeypatch.context() as patch:
        patch.setattr(to.Trajectory, "__call__", counted)
        certificate = Judge(problem.reduced).certify(motion, Specification(goals=(), waypoints=waypoints))
    assert all(check.holds for check in certificate.checks if check.name.startswith("waypoint"))
    return sum(times)


def test_many_waypoints_cost_in_proportion_to_their_number(monkeypatch: pytest.MonkeyPatch) -> None:
    assert evaluations(80, monkeypatch) < 2.5 * evaluations(40, monkeypatch)
