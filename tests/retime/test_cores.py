"""The native core against its body in plain Python."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.retime.retime_cases import make_limits, make_path
from trajopt.arrays import Floats
from trajopt.retime import Retimed, cores, extremes, reachability, retime
from trajopt.retime.stages import Rows, rooms, stages, stations
from trajopt.trajectory import Trajectory

needs_native = pytest.mark.skipif(not cores.NATIVE, reason="installed without native cores")


def compare(s: Floats, rows: Rows, limit: Floats, bound: Floats) -> Floats:
    """Return what the core finds, after comparing it with the oracle."""
    found = cores.fastest(s, rows, limit, bound)
    expected = reachability.fastest(stages(s, rows), rooms(rows, limit), bound)
    assert found.shape == bound.shape and found[0] == found[-1] == 0.0
    table, room = stages(s, rows), rooms(rows, limit)
    used = table.onward * found[1:, None] + table.held * found[:-1, None]
    reach = np.abs(table.onward) * found[1:, None] + np.abs(table.held) * found[:-1, None]
    assert (used <= room + 1e-7 * reach + 1e-12).all()
    np.testing.assert_allclose(found, expected, rtol=1e-5, atol=1e-12 * float(expected.max()))
    return found


def random_rows(rng: np.random.Generator, count: int, columns: int) -> tuple[Floats, Rows]:
    s = np.concatenate(((0.0,), np.cumsum(10.0 ** rng.uniform(-3.0, -1.0, count - 1))))
    waves = rng.normal(size=(2, 3, columns)) * 10.0 ** rng.uniform(-1.0, 1.0, columns)
    phase = np.arange(1, 4)[None, :] * s[:, None]
    return s, Rows(np.cos(phase) @ waves[0], np.sin(phase) @ waves[1], 0.3 * np.sin(phase) @ waves[0])


@needs_native
@settings(max_examples=150, deadline=None)
@given(st.integers(0, 10**6), st.sampled_from(("smooth", "rough", "still", "noise", "equal", "weak", "stop")))
def test_it_finds_what_plain_python_finds(seed: int, kind: str) -> None:
    rng = np.random.default_rng(seed)
    count, columns = int(rng.integers(2, 80)), int(rng.integers(1, 15))
    s, rows = random_rows(rng, count, columns)
    limit = np.tile(np.abs(rows.c).max(axis=0) + rng.uniform(0.1, 1.0, columns), (count, 1))
    bound = rng.uniform(0.2, 2.0, count + 1)
    match kind:
        case "rough":
            rows = Rows(rng.normal(size=rows.a.shape), rng.normal(size=rows.a.shape), rows.c)
        case "still":  # joints that stand still, in places or everywhere
            gone = (rng.random((1, columns)) < 0.5) | (rng.random((count, columns)) < 0.2)
            rows = Rows(*(np.where(gone, 0.0, part) for part in (rows.a, rows.b, rows.c)))
            bound[rng.random(count + 1) < 0.3] = 1e4
        case "noise":  # rounding errors in place of zeros, as where a path turns back
            gone = rng.random((2, count, columns)) < 0.3
            noise = rng.normal(size=(2, count, columns)) * 1e-16
            a, b = np.where(gone, noise, (rows.a, rows.b))
            rows = Rows(a, b, rows.c)
        case "equal":  # half-planes that bound the value after a grid point, or before it, alone
            step = 2.0 * np.diff(stations(s))[:, None]
            sign = rng.choice((-1.0, 1.0), rows.a.shape)
            rows = Rows(rows.a, sign * rows.a / step, rows.c)
        case "weak":  # limits below what rest needs: `rooms` leaves a trifle
            limit = 0.5 * limit * rng.random(limit.shape)
        case "stop":  # stations at which the path must nearly stand
            bound[rng.random(count + 1) < 0.3] = 1e-12
        case _:
            pass
    compare(s, rows, limit, bound)


@needs_native
def test_nothing_moves_where_nothing_may() -> None:
    s, rows = random_rows(np.random.default_rng(1), 20, 3)
    found = compare(s, rows, np.abs(rows.c) + 1.0, np.zeros(21))
    assert (found == 0.0).all()


@needs_native
def test_no_row_leaves_the_bound() -> None:
    empty = np.zeros((4, 0))
    found = cores.fastest(np.arange(4.0), Rows(empty, empty, empty), empty, np.arange(1.0, 6.0))
    np.testing.assert_array_equal(found, [0.0, 2.0, 3.0, 4.0, 0.0])


@needs_native
def test_shapes_that_do_not_match_are_refused() -> None:
    s, table = np.arange(4.0), np.ones((4, 2))
    rows = Rows(table, table, table)
    with pytest.raises(ValueError, match="one shape"):
        cores.fastest(s, rows, np.ones((4, 3)), np.ones(5))
    with pytest.raises(ValueError, match="bound"):
        cores.fastest(s, rows, table, np.ones(4))


@needs_native
@settings(max_examples=100, deadline=None)
@given(st.integers(0, 10**6), st.sampled_from(("random", "still", "touching", "tiny", "straight")))
def test_extremes_are_those_of_plain_python(seed: int, kind: str) -> None:
    rng = np.random.default_rng(seed)
    points, joints = int(rng.integers(2, 40)), int(rng.integers(1, 8))
    times = np.concatenate(((0.0,), np.cumsum(10.0 ** rng.uniform(-3.0, 0.5, points - 1))))
    q, v, a = rng.normal(size=(3, points, joints)) * 10.0 ** rng.uniform(-2.0, 2.0, (3, 1, 1))
    match kind:
        case "still":  # from rest to rest, in places and joints that do not move
            v, a = (np.where(rng.random(part.shape) < 0.5, 0.0, part) for part in (v, a))
            q[:, 0], v[:, 0], a[:, 0] = 0.3, 0.0, 0.0
        case "touching":  # the acceleration is zero at points
            a = np.zeros_like(a)
        case "tiny":
            q, v, a = q * 1e-9, v * 1e-9, a * 1e-9
        case "straight":  # constant acceleration
            a[:] = a[0]
            v = v[0] + a * times[:, None]
            q = q[0] + v[0] * times[:, None] + a * times[:, None] ** 2 / 2.0
        case _:
            pass
    trajectory = Trajectory(tuple(f"joint{i}" for i in range(joints)), times, q, v, a)
    speed, low, high = cores.motion_extremes(trajectory)
    least, largest = extremes.acceleration_range(trajectory)
    size = 1e-9 * np.maximum(np.abs(least), np.abs(largest)) + 1e-300
    assert (np.abs(low - least) <= size).all() and (np.abs(high - largest) <= size).all()
    np.testing.assert_allclose(speed, extremes.speed_peaks(trajectory), rtol=1e-6, atol=1e-300)


@needs_native
def test_coefficients_that_are_not_quintic_are_refused() -> None:
    from trajopt.native.reachability import motion_extremes

    with pytest.raises(ValueError, match="coefficients"):
        motion_extremes(np.ones((4, 3, 2)), np.ones(3))
    with pytest.raises(ValueError, match="coefficients"):
        motion_extremes(np.ones((6, 3, 2)), np.ones(2))


def test_plain_python_takes_over_where_there_is_no_core(monkeypatch: pytest.MonkeyPatch) -> None:
    limits = make_limits(7)
    path = make_path(np.random.default_rng(2).uniform(-1.0, 1.0, (6, 7)))
    fast = retime(path, limits)
    monkeypatch.setattr(cores, "NATIVE", False)
    plain = retime(path, limits)
    assert isinstance(fast, Retimed) and isinstance(plain, Retimed)
    np.testing.assert_allclose(fast.trajectory.duration, plain.trajectory.duration, rtol=1e-6)
