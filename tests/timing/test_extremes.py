import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.oracles.extremes import acceleration_range, speed_peaks
from trajopt.values.trajectory import Trajectory


def random_trajectory(seed: int) -> Trajectory:
    rng = np.random.default_rng(seed)
    size = (12, 3)
    return Trajectory(
        ("a", "b", "c"),
        np.concatenate(((0.0,), np.cumsum(rng.uniform(0.01, 1.0, 11)))),
        rng.normal(size=size),
        rng.normal(size=size) * 10.0 ** rng.uniform(-3.0, 1.0),
        rng.normal(size=size) * 10.0 ** rng.uniform(-3.0, 1.0),
    )


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 10**6))
def test_extremes_are_those_of_dense_samples(seed: int) -> None:
    trajectory = random_trajectory(seed)
    times = trajectory.times
    t = times[:-1, None] + np.diff(times)[:, None] * np.linspace(1e-9, 1.0 - 1e-9, 1001)
    speed, acceleration = np.abs(trajectory(t, 1)).max(axis=1), trajectory(t, 2)
    peaks = speed_peaks(trajectory)
    low, high = acceleration_range(trajectory)
    size = np.abs(acceleration).max(axis=1)
    assert (speed <= peaks * (1.0 + 1e-9)).all() and (peaks <= speed * (1.0 + 1e-4)).all()
    assert (low - 1e-6 * size <= acceleration.min(axis=1)).all()
    assert (acceleration.max(axis=1) <= high + 1e-6 * size).all()
    assert (np.abs(low - acceleration.min(axis=1)) <= 1e-4 * size).all()
    assert (np.abs(high - acceleration.max(axis=1)) <= 1e-4 * size).all()


def test_standing_still_has_no_extremes() -> None:
    zero = np.zeros((3, 2))
    trajectory = Trajectory(("a", "b"), np.array((0.0, 1.0, 2.0)), zero, zero, zero)
    assert (speed_peaks(trajectory) == 0.0).all()
    assert all((part == 0.0).all() for part in acceleration_range(trajectory))
