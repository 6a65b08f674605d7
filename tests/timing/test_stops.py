"""Stops along a path: as soon as the limits allow, never off the path."""

import numpy as np
import pytest

import trajopt as to
from tests.oracles import stopping
from trajopt.native import timing
from trajopt.robot.joints import EXCESS
from trajopt.timing.time_scaling import KEPT, MOMENT, RAMP, SHARES, STEP, StopsAlong
from trajopt.values.arrays import Floats

PROBLEMS = ("cup_past_pillar", "bookshelf_ur5", "planar_fold")


def planned(name: str) -> tuple[to.Problem, to.Trajectory]:
    try:
        problem = to.named_problem(name)
    except to.MissingExtra as error:
        pytest.skip(str(error))
    return problem, to.plan(problem).require().trajectory


@pytest.fixture(scope="module", params=PROBLEMS)
def case(request: pytest.FixtureRequest) -> tuple[to.Problem, to.Trajectory, StopsAlong]:
    problem, motion = planned(request.param)
    return problem, motion, StopsAlong(motion, problem.limits)


@pytest.mark.parametrize("share", SHARES)
def test_the_core_brakes_as_the_same_in_plain_python(
    case: tuple[to.Problem, to.Trajectory, StopsAlong], share: float
) -> None:
    problem, motion, _ = case
    limits = problem.limits
    for begin in np.linspace(0.0, motion.duration, 7).tolist():
        rows, last = timing.brake(
            motion.times,
            motion.coefficients,
            limits.acceleration,
            limits.jerk,
            RAMP,
            begin,
            share,
            KEPT,
            STEP,
        )
        wanted, wanted_last = stopping.brake(
            motion, limits, begin, ramp=RAMP, share=share, kept=KEPT, step=STEP
        )
        assert rows == pytest.approx(wanted, abs=1e-9)
        assert last == pytest.approx(wanted_last, abs=1e-9)


def test_the_core_takes_the_stops_of_the_same_in_plain_python(
    case: tuple[to.Problem, to.Trajectory, StopsAlong],
) -> None:
    problem, motion, stops = case
    plain = stopping.PlainStops(motion, problem.limits)
    for time, ahead in ((0.0, 0.0), (0.1, 0.12), (motion.duration / 2.0, 0.0), (motion.duration - 0.1, 0.0)):
        found, wanted = (each.earliest(time, after=time + ahead) for each in (stops, plain))
        assert found.leaves == wanted.leaves
        assert found.trajectory.times == pytest.approx(wanted.trajectory.times, abs=1e-9)
        for order in range(3):
            times = wanted.trajectory.times
            assert found.trajectory(times, order) == pytest.approx(wanted.trajectory(times, order), abs=1e-6)


def moments(motion: to.Trajectory) -> Floats:
    return np.linspace(MOMENT, motion.duration - MOMENT, 15)


def test_a_stop_begins_as_the_motion_is_and_ends_at_rest(
    case: tuple[to.Problem, to.Trajectory, StopsAlong],
) -> None:
    _, motion, stops = case
    for time in moments(motion).tolist():
        stop = stops.earliest(time)
        until = np.linspace(0.0, stop.leaves - time, 5)
        for order in range(3):
            assert stop.trajectory(until, order) == pytest.approx(motion(time + until, order), abs=1e-5)
        assert np.abs(stop.trajectory(stop.trajectory.duration, 1)).max() < 1e-12


def test_a_stop_is_within_all_limits(case: tuple[to.Problem, to.Trajectory, StopsAlong]) -> None:
    problem, motion, stops = case
    limits = problem.limits
    for time in moments(motion).tolist():
        stop = stops.earliest(time).trajectory
        times = np.linspace(0.0, stop.duration, 3000)
        for order, most in ((1, limits.velocity), (2, limits.acceleration), (3, limits.jerk)):
            assert (np.abs(stop(times, order)) <= most * (1.0 + EXCESS)).all()


def test_a_stop_stays_on_the_path(case: tuple[to.Problem, to.Trajectory, StopsAlong]) -> None:
    """Off it by no more than the distance of the points to which it is compared."""
    _, motion, stops = case
    path = motion(np.linspace(0.0, motion.duration, 60_000))
    for time in moments(motion)[::4].tolist():
        stop = stops.earliest(time).trajectory
        for place in stop(np.linspace(0.0, stop.duration, 40)):
            nearest = np.abs(path - place).max(axis=1).min()
            assert nearest < 1e-4


def test_a_stop_is_as_soon_as_the_acceleration_limits_allow(
    case: tuple[to.Problem, to.Trajectory, StopsAlong],
) -> None:
    """By the phase plane of path position and speed, integrated on a fine grid of its own."""
    problem, motion, stops = case
    most = problem.limits.acceleration
    # Braking begins, ends, and may change over from one joint to another, each with a ramp down and up.
    ramps = 6.0 * max(RAMP, float((most / problem.limits.jerk).max()))
    for time in moments(motion)[::3].tolist():
        stop = stops.earliest(time)
        took = stop.trajectory.duration
        assert took >= soonest(motion, most, time) - 1e-3
        braking = took - (stop.leaves - time)
        assert braking <= soonest(motion, most, stop.leaves) / SHARES[0] + ramps


def soonest(motion: to.Trajectory, most: Floats, begin: float) -> float:
    """How soon it comes to rest within its acceleration limits alone [s]."""
    grid = np.linspace(begin, motion.duration, 4000)
    step = grid[1] - grid[0]
    squared, took = 1.0, 0.0
    for velocity, acceleration in zip(motion(grid, 1), motion(grid, 2), strict=True):
        slopes = [
            (-limit - squared * a * np.sign(v)) / abs(v)
            for v, a, limit in zip(velocity, acceleration, most, strict=True)
            if abs(v) > 1e-9
        ]
        hardest = max(slopes, default=0.0)
        slower = squared + 2.0 * min(hardest, 0.0) * step
        if slower <= 0.0:
            break
        took += step / np.sqrt((squared + slower) / 2.0)
        squared = slower
    return took


def test_the_motion_continues_for_the_requested_time(
    case: tuple[to.Problem, to.Trajectory, StopsAlong],
) -> None:
    _, motion, stops = case
    stop = stops.earliest(0.1, after=0.3)
    assert stop.leaves >= 0.3
    assert stop.trajectory(0.2) == pytest.approx(motion(0.3), abs=1e-9)


@pytest.mark.parametrize("name", PROBLEMS)
def test_stops_do_not_depend_on_earlier_queries(name: str) -> None:
    """Moments are looked at only as far as they matter: asked in any order, the stops are the same."""
    problem, motion = planned(name)
    asked = StopsAlong(motion, problem.limits)
    for time, ahead in ((0.5, 0.3), (0.1, 0.6), (0.3, 0.0), (0.2, 0.1), (0.0, 0.0), (0.4, 0.2)):
        begin = time * motion.duration
        fresh = StopsAlong(motion, problem.limits).earliest(begin, after=begin + ahead * motion.duration)
        again = asked.earliest(begin, after=begin + ahead * motion.duration)
        assert again.leaves == fresh.leaves
        assert again.trajectory.positions == pytest.approx(fresh.trajectory.positions, abs=0.0)
