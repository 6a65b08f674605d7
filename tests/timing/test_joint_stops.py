"""Stops of joints that brake as hard as they may: the core does what the same in plain Python does."""

import numpy as np
import pytest

from tests.oracles import joint_stops
from trajopt.native import timing
from trajopt.robot.joints import EXCESS, JointLimits
from trajopt.timing.time_scaling import stop_from
from trajopt.values.arrays import Floats, readonly
from trajopt.values.trajectory import state_of

JOINTS = 4


def drawn(rng: np.random.Generator) -> tuple[Floats, JointLimits]:
    """Return a state within limits, some of it near to them."""
    velocity, acceleration = rng.uniform(0.5, 3.0, JOINTS), rng.uniform(1.0, 20.0, JOINTS)
    jerk = acceleration / rng.uniform(0.005, 0.3, JOINTS)
    upper = rng.uniform(0.05, 3.0, JOINTS)
    arrays = (-upper, upper, velocity, acceleration, jerk, np.full(JOINTS, np.inf))
    limits = JointLimits(tuple("abcd"), *(readonly(each) for each in arrays))
    shares = rng.uniform(-1.0, 1.0, (3, JOINTS)) * rng.integers(0, 2, (3, JOINTS))
    return shares * np.stack((0.9 * upper, velocity, acceleration)), limits


def test_the_core_stops_as_the_same_in_plain_python() -> None:
    rng, together = np.random.default_rng(7), 0
    for _ in range(300):
        begin, limits = drawn(rng)
        found, wanted = stop_from(begin, limits), joint_stops.stop_from(begin, limits)
        assert found.times == pytest.approx(wanted.times, abs=1e-12)
        for order in range(3):
            assert found(found.times, order) == pytest.approx(wanted(found.times, order), abs=1e-9)
        together += len(found.times) == 4
    assert 30 < together < 270


def test_joints_end_at_rest_and_keep_accelerations_and_jerks() -> None:
    rng = np.random.default_rng(8)
    for _ in range(100):
        begin, limits = drawn(rng)
        stop = stop_from(begin, limits)
        assert stop.velocities is not None and not stop.velocities[-1].any()
        assert state_of(stop, 0.0) == pytest.approx(begin, abs=1e-12)
        times = np.linspace(0.0, stop.duration, 500)
        assert (np.abs(stop(times, 2)) <= limits.acceleration * (1.0 + EXCESS)).all()
        assert (np.abs(stop(times, 3)) <= limits.jerk * (1.0 + 1e-4)).all()


def test_the_core_refuses_values_that_are_not_finite() -> None:
    begin, limits = drawn(np.random.default_rng(9))
    rows = np.stack((limits.lower, limits.upper, limits.velocity, limits.acceleration, limits.jerk))
    begin[1, 2] = np.nan
    with pytest.raises(ValueError, match="finite"):
        timing.stop_from(begin, rows, 1e-3, EXCESS)
    with pytest.raises(ValueError, match="limits"):
        timing.stop_from(np.zeros((3, 2)), rows, 1e-3, EXCESS)
