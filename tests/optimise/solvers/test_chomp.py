"""CHOMP on programs without a robot."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.optimise.solvers.plane import REACH, PlaneNlp, straight
from trajopt.optimise.solvers import Chomp, Iteration, SolverStatus, Stomp
from trajopt.optimise.solvers.chomp import cost_gradient, obstacle_functional, obstacle_potential
from trajopt.optimise.solvers.solver import improves
from trajopt.values.arrays import Floats


def bent(seed: int, size: float = 0.1) -> Floats:
    x = straight()
    x[1:-1] += size * np.random.default_rng(seed).normal(size=(len(x) - 2, 2))
    return x


def slope_by_differences(value, x: Floats) -> Floats:
    slope, step = np.zeros_like(x), 1e-6
    for index in np.ndindex(x.shape):
        away = np.zeros_like(x)
        away[index] = step
        slope[index] = (value(x + away) - value(x - away)) / (2.0 * step)
    return slope


@pytest.mark.parametrize("seed", range(3))
def test_the_functionals_gradient(seed: int) -> None:
    nlp, x, scale = PlaneNlp(), bent(seed), np.array([1.0, 0.5])
    sampling = nlp.sampling(x, fine=True)

    def value(at: Floats) -> float:
        return obstacle_functional(nlp.linearise(at, sampling), scale).value

    found = obstacle_functional(nlp.linearise(x, sampling), scale)
    assert found.value > 0.0
    assert found.gradient == pytest.approx(slope_by_differences(value, x), abs=1e-6)


def test_the_functional_measures_length_and_not_knots() -> None:
    """The same way at another speed costs the same, up to the error of the sum."""
    nlp = PlaneNlp()
    even = straight()
    uneven = even.copy()
    uneven[:, 0] = np.linspace(0.0, 1.0, len(even)) ** 1.3
    values = [
        obstacle_functional(nlp.linearise(x, np.full(len(x) - 1, 60)), nlp.scale).value
        for x in (even, uneven)
    ]
    assert values[0] == pytest.approx(values[1], rel=1e-2)


def test_the_potential_is_smooth() -> None:
    inside = np.array([-0.1, -1e-9, 1e-9, 0.05, REACH - 1e-9, REACH, 1.0])
    potential, slope = obstacle_potential(inside, REACH)
    assert potential == pytest.approx([0.15, 0.05, 0.05, 0.0125, 0.0, 0.0, 0.0])
    assert slope == pytest.approx([-1.0, -1.0, -1.0, -0.5, 0.0, 0.0, 0.0], abs=1e-6)


def test_the_costs_gradient() -> None:
    nlp, x = PlaneNlp(), bent(5)
    sampling = nlp.sampling(x, fine=False)
    found = cost_gradient(nlp.linearise(x, sampling))
    expected = slope_by_differences(lambda at: nlp.linearise(at, sampling).cost, x)
    assert found == pytest.approx(expected, abs=1e-6)


@pytest.mark.parametrize("nlp", [PlaneNlp(), PlaneNlp(goal_free=True), PlaneNlp(band=0.25)])
def test_passes_the_disc(nlp: PlaneNlp) -> None:
    seen: list[Iteration] = []
    result = Chomp().solve(nlp, straight(), progress=seen.append)
    assert result.feasible and result.status is SolverStatus.CONVERGED
    assert (result.at.sampling == 6).all()
    assert result.x[-1] == pytest.approx([1.0, 0.0], abs=1e-3)
    assert tuple(seen) == result.log


def test_keeps_below_a_ceiling() -> None:
    result = Chomp().solve(PlaneNlp(ceiling=0.14, radius=0.08), straight() + np.array([0.0, 0.03]))
    assert result.feasible and 0.1 < result.x[:, 1].max() <= 0.14


def test_a_local_minimum_is_reported() -> None:
    result = Chomp().solve(PlaneNlp(ceiling=0.1), straight() + np.array([0.0, 0.03]))
    assert not result.feasible and result.status is not SolverStatus.CONVERGED


def test_an_infeasible_problem_is_reported() -> None:
    result = Chomp(max_iterations=50).solve(PlaneNlp(band=0.05), straight())
    assert not result.feasible and result.status is not SolverStatus.CONVERGED
    assert result.violations()["clearance"] > 0.01


@settings(max_examples=15, deadline=None)
@given(st.integers(0, 1000), st.floats(0.0, 0.4))
def test_never_worse_than_the_first_guess(seed: int, size: float) -> None:
    nlp, x = PlaneNlp(band=0.22), bent(seed, size)
    result = Chomp(max_iterations=15).solve(nlp, x)
    first = nlp.linearise(np.clip(x, nlp.lower, nlp.upper), result.at.sampling)
    assert not improves(first, result.at)


@pytest.mark.parametrize("solver", [Chomp(), Stomp()])
def test_not_a_number_is_a_result(solver: Chomp | Stomp) -> None:
    result = solver.solve(PlaneNlp(), np.nan * straight())
    assert result.status is SolverStatus.NON_FINITE and not result.log
