"""STOMP on programs without a robot."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.optimise.solvers.plane import PlaneNlp, straight
from trajopt.optimise.solvers import Iteration, SolverStatus, Stomp
from trajopt.optimise.solvers.solver import improves
from trajopt.optimise.solvers.stomp import knot_costs, rollout_weights


@pytest.mark.parametrize("nlp", [PlaneNlp(), PlaneNlp(goal_free=True), PlaneNlp(band=0.25)])
def test_passes_the_disc(nlp: PlaneNlp) -> None:
    seen: list[Iteration] = []
    result = Stomp().solve(nlp, straight(), progress=seen.append)
    assert result.feasible and result.status is SolverStatus.CONVERGED
    assert (result.at.sampling == 6).all()
    assert result.x[-1] == pytest.approx([1.0, 0.0], abs=1e-3)
    assert tuple(seen) == result.log


def test_the_same_seed_gives_the_same_answer() -> None:
    first, again, other = (Stomp(seed=seed).solve(PlaneNlp(), straight()).x for seed in (1, 1, 2))
    assert (first == again).all() and (first != other).any()


def test_weights_are_a_probability_at_every_knot() -> None:
    costs = np.array([[0.0, 5.0, 1.0], [1.0, 5.0, 0.5], [3.0, 5.0, 0.0]])
    weights = rollout_weights(costs, 10.0)
    assert weights.sum(axis=0) == pytest.approx(np.ones(3))
    assert weights[:, 1] == pytest.approx(np.full(3, 1 / 3))
    assert weights[0, 0] / weights[2, 0] == pytest.approx(np.exp(10.0))


def test_tolerances_are_tolerances() -> None:
    """What is within its band costs nothing, however far from the middle of it."""
    nlp = PlaneNlp(band=0.3, radius=0.0)
    x = straight()
    x[:, 1] = 0.29 * np.sin(np.linspace(0.0, np.pi, len(x)))
    at = nlp.linearise(x, nlp.sampling(x, fine=False))
    assert not knot_costs(at, 0.0).any()
    x[:, 1] *= 2.0
    beyond = nlp.linearise(x, at.sampling)
    assert knot_costs(beyond, 0.0).sum() == pytest.approx(beyond.violation / 1e-3)
    assert knot_costs(at, 1.0).sum() == pytest.approx(at.cost)


def test_an_infeasible_problem_is_reported() -> None:
    result = Stomp(max_iterations=15).solve(PlaneNlp(band=0.05), straight())
    assert not result.feasible and result.status is SolverStatus.MAX_ITERATIONS


@settings(max_examples=8, deadline=None)
@given(st.integers(0, 1000), st.floats(0.0, 0.4))
def test_never_worse_than_the_first_guess(seed: int, size: float) -> None:
    nlp, x = PlaneNlp(band=0.22), straight()
    x[1:-1] += size * np.random.default_rng(seed).normal(size=(len(x) - 2, 2))
    result = Stomp(max_iterations=5, seed=seed).solve(nlp, x)
    first = nlp.linearise(np.clip(x, nlp.lower, nlp.upper), result.at.sampling)
    assert not improves(first, result.at)
