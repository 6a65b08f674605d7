"""Time scaling: the rate and its derivatives belong together, and the scaled motion stays on its path."""

from itertools import pairwise

import numpy as np
import pytest

import trajopt as to
from trajopt.timing.time_scaling import RateChange, TimeScaling

CHANGES = [
    RateChange(1.0, 0.25, 0.4),
    RateChange(0.8, 0.5, 0.2, slope=-0.7),
    RateChange(0.0, 1.0, 0.3, bulge=0.05),
    RateChange(0.5, 0.8, 0.6, slope=0.3, bulge=-0.02),
]


@pytest.mark.parametrize("change", CHANGES)
def test_rates_are_derivatives_of_the_clock(change: RateChange) -> None:
    z = np.linspace(0.0, 1.0, 20_001)
    values = change.at(z)
    for value, slope in pairwise(values):
        numeric = np.gradient(value, z * change.duration)
        assert np.abs(numeric - slope)[1:-1].max() < 1e-6


@pytest.mark.parametrize("change", CHANGES)
def test_change_has_the_stated_ends(change: RateChange) -> None:
    clock, rate, slope, _ = change.at(np.array((0.0, 1.0)))
    time = change.duration
    advance = time * ((change.before + change.after) / 2.0 + change.bulge) + change.slope * time**2 / 12.0
    np.testing.assert_allclose(clock, (0.0, advance), atol=1e-15)
    np.testing.assert_allclose(rate, (change.before, change.after), atol=1e-15)
    np.testing.assert_allclose(slope, (change.slope, 0.0), atol=1e-15)


def test_change_without_duration_has_the_final_rate() -> None:
    clock, rate, slope, curvature = RateChange(1.0, 0.5, 0.0).at(np.array((0.0, 1.0)))
    assert not clock.any() and not slope.any() and not curvature.any()
    np.testing.assert_array_equal(rate, (0.5, 0.5))


def test_scaled_motion_stays_on_the_path_with_the_accelerations_of_the_formula() -> None:
    times = np.linspace(0.0, 2.0, 21)
    positions = np.stack((np.sin(times), times**2), axis=1)
    motion = to.Trajectory(("one", "other"), times, positions)
    change = RateChange(1.0, 0.5, 2.0)
    clock, rate, slope, _ = change.at(np.linspace(0.0, 1.0, 101))
    scaled = TimeScaling(np.linspace(0.0, 2.0, 101), clock, rate, slope).applied_to(motion)
    assert scaled.duration == 2.0
    np.testing.assert_allclose(scaled(scaled.times), motion(clock), atol=1e-12)
    step = 1e-4
    at = np.array((0.7, 1.3))
    numeric = (scaled(at + step, 1) - scaled(at - step, 1)) / (2.0 * step)
    np.testing.assert_allclose(scaled(at, 2), numeric, rtol=1e-4, atol=1e-6)
    elsewhere, rates, slopes, _ = change.at(at / 2.0)
    formula = motion(elsewhere, 2) * rates[:, None] ** 2 + motion(elsewhere, 1) * slopes[:, None]
    np.testing.assert_allclose(scaled(at, 2), formula, atol=2e-3)
