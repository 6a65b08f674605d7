import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad

from tests.oracles.reachability import constraint_rhs, fastest, stages
from tests.oracles.retiming.constraints import Rows
from tests.oracles.retiming.profile import Profile, from_control, stations
from trajopt.values.arrays import Floats


def random_control(seed: int) -> tuple[Floats, Floats]:
    rng = np.random.default_rng(seed)
    s = np.concatenate(((0.0,), np.cumsum(rng.uniform(0.1, 2.0, 12))))
    return s, np.concatenate(((0.0,), rng.uniform(0.01, 3.0, 12), (0.0,)))


def at(profile: Profile, piece: int, ds: float) -> float:
    slope = (profile.u[piece + 1] - profile.u[piece]) / (profile.s[piece + 1] - profile.s[piece])
    return float(profile.x[piece] + 2.0 * profile.u[piece] * ds + slope * ds**2)


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 10**6))
def test_its_pieces_join_and_stay_positive(seed: int) -> None:
    profile = from_control(*random_control(seed))
    assert profile.x[0] == 0.0 and profile.x[-1] == 0.0
    for piece, width in enumerate(np.diff(profile.s)):
        assert abs(at(profile, piece, width) - profile.x[piece + 1]) < 1e-12
        assert all(at(profile, piece, width * part) > 0.0 for part in (0.01, 0.5, 0.99))


def test_its_times_are_those_of_numeric_integration() -> None:
    profile = from_control(*random_control(7))
    for piece, width in enumerate(np.diff(profile.s)):
        # ds = width * sin(phase)² takes the singular speed at both ends out of the integrand
        expected, _ = quad(
            lambda phase, piece=piece, width=width: (
                width
                * np.sin(2.0 * phase)
                / np.sqrt(max(at(profile, piece, width * np.sin(phase) ** 2), 1e-300))
            ),
            1e-9,
            np.pi / 2.0 - 1e-9,
        )
        assert abs(profile.times[piece + 1] - profile.times[piece] - expected) < 1e-6


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 10**6))
def test_limits_hold_at_every_grid_point_and_nothing_larger_does(seed: int) -> None:
    rng = np.random.default_rng(seed)
    count, columns = 30, 5
    s = np.concatenate(((0.0,), np.cumsum(rng.uniform(0.01, 0.05, count - 1))))
    waves = rng.normal(size=(2, 3, columns))
    phase = np.arange(1, 4)[None, :] * s[:, None]
    rows = Rows(np.cos(phase) @ waves[0], np.sin(phase) @ waves[1], 0.3 * np.sin(phase) @ waves[0])
    limit = np.tile(np.abs(rows.c).max(axis=0) + rng.uniform(0.1, 1.0, columns), (count, 1))
    bound = rng.uniform(0.2, 2.0, count + 1)
    table, room = stages(s, rows), constraint_rhs(rows, limit)
    control = fastest(table, room, bound)
    profile = from_control(s, control)
    needed = rows.a * profile.u[:, None] + rows.b * profile.x[:, None] + rows.c
    assert (np.abs(needed) <= limit * (1.0 + 1e-9)).all()
    assert (control <= bound).all() and (control[1:-1] > 0.0).all()
    used = table.coeff_next * control[1:, None] + table.coeff_prev * control[:-1, None]
    assert (used <= room * (1.0 + 1e-9) + 1e-12).all()
    larger = control.copy()
    larger[1:-1] *= 1.0 + 1e-6
    broken = (larger > bound).any()
    broken |= (table.coeff_next * larger[1:, None] + table.coeff_prev * larger[:-1, None] > room).any()
    assert broken


def test_constant_acceleration_gives_the_triangle() -> None:
    s = np.linspace(0.0, 1.0, 201)
    rows = Rows(np.ones((201, 1)), np.zeros((201, 1)), np.zeros((201, 1)))
    control = fastest(stages(s, rows), constraint_rhs(rows, np.full((201, 1), 2.0)), np.full(202, 1e8))
    profile = from_control(s, control)
    station = stations(s)
    np.testing.assert_allclose(control, 4.0 * np.minimum(station, 1.0 - station), atol=1e-12)
    np.testing.assert_allclose(profile.duration, np.sqrt(2.0), rtol=1e-3)
