"""The native core against the same in plain Python."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize as scipy_minimize

from tests.oracles import barrier, extremes, reachability
from tests.oracles.barrier import at, duration
from tests.oracles.reachability import constraint_rhs, stages
from tests.oracles.retiming.constraints import Rows
from tests.oracles.retiming.jerk_program import NothingFits, Program
from tests.oracles.retiming.profile import stations
from trajopt.native import timing
from trajopt.values.arrays import Floats
from trajopt.values.trajectory import Trajectory


def largest_control(s: Floats, rows: Rows, limit: Floats, bound: Floats) -> Floats:
    return timing.fastest(np.diff(stations(s)), rows.a, rows.b, rows.c, limit, bound)


def minimise(program: Program, z: Floats, *, first_gap: float, gap: float) -> tuple[Floats, int]:
    rows, above, below, jerk, speed = (
        np.ascontiguousarray(table)
        for table in (program.rows, program.above, program.below, program.jerk, program.speed)
    )
    return timing.minimise(program.weight, program.bound, rows, above, below, jerk, speed, z, first_gap, gap)


def compare(s: Floats, rows: Rows, limit: Floats, bound: Floats) -> Floats:
    """Return what the core finds, after comparing it with the oracle."""
    found = largest_control(s, rows, limit, bound)
    expected = reachability.fastest(stages(s, rows), constraint_rhs(rows, limit), bound)
    assert found.shape == bound.shape and found[0] == found[-1] == 0.0
    table, room = stages(s, rows), constraint_rhs(rows, limit)
    used = table.coeff_next * found[1:, None] + table.coeff_prev * found[:-1, None]
    reach = np.abs(table.coeff_next) * found[1:, None] + np.abs(table.coeff_prev) * found[:-1, None]
    assert (used <= room + 1e-7 * reach + 1e-12).all()
    np.testing.assert_allclose(found, expected, rtol=1e-5, atol=1e-12 * float(expected.max()))
    return found


def random_rows(rng: np.random.Generator, count: int, columns: int) -> tuple[Floats, Rows]:
    s = np.concatenate(((0.0,), np.cumsum(10.0 ** rng.uniform(-3.0, -1.0, count - 1))))
    waves = rng.normal(size=(2, 3, columns)) * 10.0 ** rng.uniform(-1.0, 1.0, columns)
    phase = np.arange(1, 4)[None, :] * s[:, None]
    return s, Rows(np.cos(phase) @ waves[0], np.sin(phase) @ waves[1], 0.3 * np.sin(phase) @ waves[0])


@settings(max_examples=150, deadline=None)
@given(st.integers(0, 10**6), st.sampled_from(("smooth", "rough", "still", "noise", "equal", "weak", "stop")))
def test_it_equals_plain_python(seed: int, kind: str) -> None:
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
        case "weak":  # limits below what rest needs: `constraint_rhs` leaves a trifle
            limit = 0.5 * limit * rng.random(limit.shape)
        case "stop":  # stations at which the path must nearly stand
            bound[rng.random(count + 1) < 0.3] = 1e-12
        case _:
            pass
    compare(s, rows, limit, bound)


def test_nothing_moves_where_nothing_may() -> None:
    s, rows = random_rows(np.random.default_rng(1), 20, 3)
    found = compare(s, rows, np.abs(rows.c) + 1.0, np.zeros(21))
    assert (found == 0.0).all()


def test_no_row_leaves_the_bound() -> None:
    empty = np.zeros((4, 0))
    found = largest_control(np.arange(4.0), Rows(empty, empty, empty), empty, np.arange(1.0, 6.0))
    np.testing.assert_array_equal(found, [0.0, 2.0, 3.0, 4.0, 0.0])


def test_shapes_that_do_not_match_are_refused() -> None:
    s, table = np.arange(4.0), np.ones((4, 2))
    rows = Rows(table, table, table)
    with pytest.raises(ValueError, match="one shape"):
        largest_control(s, rows, np.ones((4, 3)), np.ones(5))
    with pytest.raises(ValueError, match="bound"):
        largest_control(s, rows, table, np.ones(4))


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
    speed, low, high = timing.motion_extremes(trajectory.coefficients, np.diff(trajectory.times))
    least, largest = extremes.acceleration_range(trajectory)
    size = 1e-9 * np.maximum(np.abs(least), np.abs(largest)) + 1e-300
    assert (np.abs(low - least) <= size).all() and (np.abs(high - largest) <= size).all()
    np.testing.assert_allclose(speed, extremes.speed_peaks(trajectory), rtol=1e-6, atol=1e-300)


def test_coefficients_that_are_not_quintic_are_refused() -> None:
    with pytest.raises(ValueError, match="coefficients"):
        timing.motion_extremes(np.ones((4, 3, 2)), np.ones(3))
    with pytest.raises(ValueError, match="coefficients"):
        timing.motion_extremes(np.ones((6, 3, 2)), np.ones(2))


def random_program(rng: np.random.Generator, *, blocks: int, linear: int, half: int) -> Program:
    rows = rng.normal(size=(blocks, linear + 2 * half, 3)) * 10.0 ** rng.uniform(-1.0, 1.0)
    part = rng.uniform(0.2, 0.8, (blocks, 2))
    speed = np.zeros((blocks, 2, 3))
    speed[:, 0, :2] = np.stack((1.0 - part[:, 0], part[:, 0]), axis=1)
    speed[:, 1, 1:] = np.stack((1.0 - part[:, 1], part[:, 1]), axis=1)
    above, below = rng.uniform(0.1, 2.0, (2, blocks, linear))
    jerk = rng.uniform(0.1, 2.0, (blocks, 2 * half))
    bound = np.where(rng.random(blocks + 2) < 0.5, 1e4, rng.uniform(0.1, 2.0, blocks + 2))
    return Program(rng.uniform(0.5, 1.5, blocks + 2), bound, rows, above, below, jerk, speed)


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 10**6), st.integers(0, 5), st.integers(1, 4))
def test_the_barrier_goes_where_plain_python_goes(seed: int, linear: int, half: int) -> None:
    rng = np.random.default_rng(seed)
    program = random_program(rng, blocks=int(rng.integers(3, 40)), linear=linear, half=half)
    z = np.full(len(program.weight), rng.uniform(0.5, 2.0))
    found, steps = minimise(program, z, first_gap=0.3, gap=3e-3)
    expected = barrier.minimise(program, z, first_gap=0.3, gap=3e-3)
    assert found[0] == found[1] and found[-1] == found[-2]
    assert at(program, found).inside and (found < program.bound).all()
    assert duration(program, found) == pytest.approx(duration(program, expected.z), rel=1e-4)
    assert steps <= 60


@pytest.mark.parametrize("limit", [-0.1, 0.0, np.nan])
def test_the_barrier_ends_where_no_speed_is_within_the_limits(limit: float) -> None:
    """Standing still is outside, too: halving the speed for ever would find nothing."""
    program = random_program(np.random.default_rng(3), blocks=6, linear=2, half=1)
    program.above[2, 1] = limit
    program.rows[2, 1] = np.abs(program.rows[2, 1])
    found, steps = minimise(program, np.ones(8), first_gap=0.3, gap=3e-3)
    assert (len(found), steps) == (0, 0)
    with pytest.raises(NothingFits):
        barrier.minimise(program, np.ones(8), first_gap=0.3, gap=3e-3)


@pytest.mark.parametrize("seed", range(5))
def test_the_barrier_ends_near_the_least(seed: int) -> None:
    rng = np.random.default_rng(seed)
    program = random_program(rng, blocks=12, linear=3, half=0)  # convex: any other solver finds the same
    gap = 1e-3
    found = barrier.minimise(program, np.ones(14), first_gap=0.3, gap=gap)

    def cost(inner: Floats) -> float:
        return duration(program, np.concatenate((inner[:1], inner, inner[-1:])))

    def room(inner: Floats) -> Floats:
        z = np.concatenate((inner[:1], inner, inner[-1:]))
        state = at(program, z)
        return np.concatenate((state.above.ravel(), state.below.ravel(), program.bound - z))

    least = scipy_minimize(
        cost,
        found.z[1:-1],
        method="SLSQP",
        bounds=[(1e-6, None)] * 12,
        constraints={"type": "ineq", "fun": room},
        options={"maxiter": 500, "ftol": 1e-12},
    )
    assert (1.0 - 1e-6) * least.fun <= duration(program, found.z) <= (1.0 + 2.0 * gap) * least.fun


def test_programs_that_do_not_fit_together_are_refused() -> None:
    program = random_program(np.random.default_rng(0), blocks=5, linear=2, half=1)
    tables = [program.rows, program.above, program.below, program.jerk, program.speed]
    columns = [program.weight, program.bound]
    timing.minimise(*columns, *tables, np.ones(7), 0.3, 0.1)
    with pytest.raises(ValueError, match="two rows more"):
        timing.minimise(*columns, *tables, np.ones(6), 0.3, 0.1)
    with pytest.raises(ValueError, match="rows must be"):
        timing.minimise(*columns, program.rows, program.above[:, :1], *tables[2:], np.ones(7), 0.3, 0.1)
    with pytest.raises(ValueError, match="a row for each block"):
        timing.minimise(*columns, program.rows, program.above[:3], *tables[2:], np.ones(7), 0.3, 0.1)
