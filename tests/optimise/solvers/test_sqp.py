"""The SQP on small programs with known answers."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from tests.optimise.solvers.analytic import AnalyticNlp
from trajopt.optimise.solvers import Effort, SolverStatus, Sqp, SqpStep
from trajopt.optimise.solvers.descent import DescentLimits
from trajopt.optimise.solvers.flat import subproblem
from trajopt.values.arrays import Floats, Ints, Loss

SHARP = Sqp(relative_gain=1e-10, absolute_gain=1e-12, max_iterations=300)
WIDE = (np.full((1, 2), -10.0), np.full((1, 2), 10.0))


def rosenbrock(x: Floats) -> tuple[Floats, Floats]:
    return np.array([1 - x[0], 10 * (x[1] - x[0] ** 2)]), np.array([[-1.0, 0.0], [-20 * x[0], 10.0]])


def disc(x: Floats) -> tuple[Floats, Floats]:
    return np.array([x @ x]), 2 * x[None, :]


def nothing(x: Floats) -> tuple[Floats, Floats]:
    return np.zeros(0), np.zeros((0, 2))


def program(residual=rosenbrock, constraint=disc, lower=-np.inf, upper=2.0, loss=Loss.SQUARED, box=WIDE):
    rows = len(constraint(np.zeros(2))[0])
    bounds = (np.full(rows, lower), np.full(rows, upper))
    return AnalyticNlp(*box, residual, 1.0, loss, constraint, bounds)


def test_rosenbrock_in_a_disc_that_holds_its_minimum() -> None:
    result = SHARP.solve(program(), np.array([[-1.2, 1.0]]))
    assert result.status is SolverStatus.CONVERGED
    assert result.x[0] == pytest.approx([1.0, 1.0], abs=1e-3)


def test_rosenbrock_in_a_disc_that_cuts_it_off() -> None:
    result = SHARP.solve(program(upper=1.0), np.array([[-1.2, 1.0]]))
    assert result.feasible
    # Known minimiser on the unit disc: (0.7864, 0.6177).
    assert result.x[0] == pytest.approx([0.7864, 0.6177], abs=1e-3)


def test_any_feasible_point_ends_it_where_it_will_do() -> None:
    begin = np.array([[-1.5, 1.5]])
    best, any_point = (
        replace(SHARP, until_feasible=anyone).solve(program(upper=1.0), begin) for anyone in (False, True)
    )
    assert any_point.status is SolverStatus.CONVERGED and any_point.feasible
    assert len(any_point.log) < len(best.log)


class Finer(AnalyticNlp):
    """Asks for ever more samples of a point where these are to be as many as it needs in the end."""

    asked = 1

    def sampling(self, x: Floats, *, fine: bool) -> Ints:
        self.asked = min(self.asked + fine, 4)
        return np.full(1, self.asked)


def test_a_point_that_is_feasible_on_the_samples_that_it_needs_is_not_moved() -> None:
    nlp = Finer(*WIDE, rosenbrock, 1.0, Loss.SQUARED, disc, (np.full(1, -np.inf), np.full(1, 1.0)))
    result = replace(SHARP, until_feasible=True).solve(nlp, np.array([[-1.5, 1.5]]))
    assert result.feasible
    assert nlp.asked == 2


def test_where_others_look_between_few_samples_they_are_enough() -> None:
    nlp = Finer(*WIDE, rosenbrock, 1.0, Loss.SQUARED, disc, (np.full(1, -np.inf), np.full(1, 1.0)))
    result = replace(SHARP, until_feasible=True, refines=False).solve(nlp, np.array([[-1.5, 1.5]]))
    assert result.feasible
    assert nlp.asked == 1


def test_equality() -> None:
    def centre(x: Floats) -> tuple[Floats, Floats]:
        return x.copy(), np.eye(2)

    result = SHARP.solve(program(centre, disc, 4.0, 4.0), np.array([[3.0, 0.1]]))
    assert result.feasible
    assert np.linalg.norm(result.x) == pytest.approx(2.0, abs=1e-4)


def test_infeasible_ends_stationary() -> None:
    result = SHARP.solve(program(upper=-1.0), np.array([[2.0, 1.0]]))
    assert not result.feasible
    assert result.status in {SolverStatus.INFEASIBLE_STATIONARY, SolverStatus.TRUST_REGION_COLLAPSED}
    assert result.x[0] == pytest.approx([0.0, 0.0], abs=1e-2)
    assert result.violations()["constraint"] == pytest.approx(1.0, abs=1e-3)


def test_a_seed_is_given_up_if_its_constraints_would_not_hold_in_time() -> None:
    seed, full = np.array([[2.0, 1.0]]), replace(SHARP, max_iterations=100)
    tentative = full.with_effort(Effort.TENTATIVE)
    given_up = tentative.solve(program(upper=-1.0), seed)
    assert given_up.status is SolverStatus.GIVEN_UP
    assert len(given_up.log) < len(full.solve(program(upper=-1.0), seed).log)
    assert tentative.solve(program(upper=1.0), seed).log == full.solve(program(upper=1.0), seed).log


@given(
    first=st.floats(1e-2, 10.0),
    rate=st.floats(0.01, 0.99),
    window=st.integers(1, 9),
    steps=st.integers(10, 60),
)
def test_a_violation_that_falls_at_a_constant_rate_is_extrapolated(
    first: float, rate: float, window: int, steps: int
) -> None:
    limits, tolerance = DescentLimits(steps, 0.0, 0.0, window), 1e-3
    violations = [first * rate**step for step in range(window + 1)]
    last = first * rate ** (steps - 1)
    assume(abs(np.log(last / tolerance)) > 1e-6 and violations[-1] > tolerance)
    left = steps - len(violations)
    assert limits.hopeless(violations, tolerance, left) == (last > tolerance)
    assert not limits.hopeless(violations[1:], tolerance, left)
    assert limits.hopeless([first] * (window + 1), tolerance, left)
    assert limits.hopeless([0.0] * window + [first], tolerance, left)


def test_without_rounds_the_penalty_stays() -> None:
    result = replace(SHARP, penalty_rounds=0).solve(program(upper=-1.0), np.array([[2.0, 1.0]]))
    assert not result.feasible
    assert {entry.penalty for entry in result.log if isinstance(entry, SqpStep)} == {SHARP.penalty}


@pytest.mark.parametrize("loss", [Loss.ABSOLUTE, Loss.HINGE])
def test_losses(loss: Loss) -> None:
    def offsets(x: Floats) -> tuple[Floats, Floats]:
        return np.array([x[0] - 0.5, x[1] + 0.25]), np.eye(2)

    result = SHARP.solve(program(offsets, nothing, loss=loss), np.array([[2.0, 2.0]]))
    if loss is Loss.ABSOLUTE:
        assert result.x[0] == pytest.approx([0.5, -0.25], abs=1e-5)
    assert result.at.cost == pytest.approx(0.0, abs=1e-6)


def test_fixed_variables_stay() -> None:
    box = (np.array([[0.3, -9.0]]), np.array([[0.3, 9.0]]))
    result = SHARP.solve(program(constraint=nothing, box=box), np.array([[5.0, 5.0]]))
    assert result.x[0] == pytest.approx([0.3, 0.09], abs=1e-5)


def test_not_a_number_is_a_result() -> None:
    def broken(x: Floats) -> tuple[Floats, Floats]:
        return np.array([np.nan]), np.ones((1, 2))

    result = Sqp().solve(program(broken), np.array([[0.0, 0.0]]))
    assert result.status is SolverStatus.NON_FINITE


def test_merit_never_rises_within_a_penalty() -> None:
    result = SHARP.solve(program(upper=1.0), np.array([[-1.2, 1.0]]))
    for before, after in zip(result.log, result.log[1:], strict=False):
        if before.penalty == after.penalty:
            assert after.merit <= before.merit + 1e-9


def test_the_model_is_the_merit_to_first_order() -> None:
    nlp = program(upper=1.0)
    x = np.array([[1.3, 0.4]])
    at = nlp.linearise(x, np.ones(1, dtype=np.int64))
    model = subproblem(nlp.lower < nlp.upper, at, 7.0)
    assert model.model(np.zeros(2)) == pytest.approx(7.0 * at.violation)
    step = 1e-6 * np.array([0.3, -0.8])
    moved = nlp.linearise(x + step, at.sampling)
    actual = moved.cost + 7.0 * moved.violation - at.cost - 7.0 * at.violation
    assert model.model(step) - model.model(np.zeros(2)) == pytest.approx(actual, rel=1e-4)


@pytest.mark.parametrize("name", ["banded", "piqp", "osqp", "proxqp"])
def test_backends_agree(name: str) -> None:
    result = Sqp(qp=name, relative_gain=1e-6).solve(program(upper=1.0), np.array([[-1.2, 1.0]]))
    assert result.x[0] == pytest.approx([0.7864, 0.6177], abs=5e-3)
