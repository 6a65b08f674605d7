"""Every QP backend solves the same programs to the same optimum."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import Bounds, LinearConstraint, minimize
from scipy.sparse import csc_matrix

from trajopt.optimise.solvers.qp import (
    BACKENDS,
    GENERAL,
    NATIVE,
    Qp,
    QpSolution,
    QpStatus,
    checked,
    qp_backend,
)
from trajopt.values.errors import MissingExtra, SolverNotFound


def backend(name: str):
    try:
        return qp_backend(name)
    except MissingExtra as missing:
        pytest.skip(str(missing))


def random_qp(seed: int, n: int = 8, m: int = 6) -> Qp:
    rng = np.random.default_rng(seed)
    root = rng.normal(size=(n, n))
    inside = rng.uniform(-0.5, 0.5, n)
    rows = rng.normal(size=(m, n))
    lower = rows @ inside - rng.uniform(0.0, 1.0, m)
    lower[0] = -np.inf
    return Qp(
        csc_matrix(root @ root.T + 0.1 * np.eye(n)),
        rng.normal(size=n),
        csc_matrix(rows),
        lower,
        rows @ inside + rng.uniform(0.0, 1.0, m),
        np.full(n, -1.0),
        np.append(np.full(n - 1, 1.0), np.inf),
    )


def reference(qp: Qp) -> float:
    dense = qp.P.toarray()
    solution = minimize(
        qp.objective, np.zeros(len(qp.q)), jac=lambda x: dense @ x + qp.q, hess=lambda _: dense,
        bounds=Bounds(qp.lower, qp.upper), constraints=LinearConstraint(qp.A.toarray(), qp.l, qp.u),
        method="trust-constr", options={"gtol": 1e-10, "xtol": 1e-12, "maxiter": 2000},
    )  # fmt: skip
    return float(solution.fun)


@pytest.mark.parametrize("name", BACKENDS)
@pytest.mark.parametrize("seed", range(4))
def test_optimum(name: str, seed: int) -> None:
    qp = random_qp(seed)
    solution = checked(qp, backend(name).solve(qp))
    assert solution.status is QpStatus.SOLVED
    assert qp.violation(solution.x) < 1e-4
    assert qp.objective(solution.x) == pytest.approx(reference(qp), abs=2e-3)


@pytest.mark.parametrize("name", NATIVE)
def test_the_solver_of_an_earlier_program_finds_the_same(name: str) -> None:
    first, second, smaller = random_qp(1), random_qp(2), random_qp(3, n=5, m=4)
    solver = backend(name)
    assert first.same_pattern(second)
    assert not second.same_pattern(smaller)
    for qp in (first, second, smaller, second):
        fresh = backend(name).solve(qp)
        assert qp.objective(solver.solve(qp).x) == pytest.approx(qp.objective(fresh.x), abs=1e-3)


@pytest.mark.parametrize("name", ["piqp", "clarabel"])
def test_multipliers_are_the_price_of_a_bound(name: str) -> None:
    one = csc_matrix(np.eye(1))
    qp = Qp(one, np.array([0.0]), one, np.array([2.0]), np.array([np.inf]), np.array([-9.0]), np.array([9.0]))
    assert backend(name).solve(qp).row_multipliers == pytest.approx([-2.0], abs=1e-4)


@pytest.mark.parametrize("name", ["piqp", "osqp", "clarabel"])
def test_an_infeasible_program_is_reported(name: str) -> None:
    one = csc_matrix(np.eye(1))
    qp = Qp(one, np.array([0.0]), one, np.array([2.0]), np.array([3.0]), np.array([-1.0]), np.array([1.0]))
    assert checked(qp, backend(name).solve(qp)).status is not QpStatus.SOLVED


def softened() -> Qp:
    """A step's program as the SQP asks it: slacks without curvature, and x1 that only the row holds.

    Minimise (x0 - 3)^2 + 5 s subject to x0 + x1 - s <= 1, |x| <= 1: x1 = -1, x0 = 1 and s = 0.
    """
    return Qp(
        csc_matrix(np.diag([2.0, 0.0, 0.0])), np.array([-6.0, 0.0, 5.0]),
        csc_matrix(np.array([[1.0, 1.0, -1.0]])), np.array([-np.inf]), np.array([1.0]),
        np.array([-1.0, -1.0, 0.0]), np.array([1.0, 1.0, np.inf]),
    )  # fmt: skip


@pytest.mark.parametrize("name", BACKENDS)
def test_semidefinite_programs(name: str) -> None:
    qp = softened()
    solution = checked(qp, backend(name).solve(qp))
    assert solution.status is QpStatus.SOLVED
    assert solution.x[0] == pytest.approx(1.0, abs=1e-3)
    assert solution.x[2] == pytest.approx(0.0, abs=1e-3)


def test_unknown_backend_names_near_ones() -> None:
    with pytest.raises(SolverNotFound, match="piqp"):
        qp_backend("pipq")


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 10_000))
def test_piqp_against_proxqp(seed: int) -> None:
    qp = random_qp(seed)
    values = [qp.objective(qp_backend(name).solve(qp).x) for name in ("piqp", "proxqp")]
    assert values[0] == pytest.approx(values[1], abs=1e-4)


def test_a_missing_backend_names_the_package_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("qpsolvers.available_solvers", ["piqp"])
    for name, package in GENERAL.items():
        extra = "qp-gpl" if name == "quadprog" else "qp"
        with pytest.raises(MissingExtra, match=rf"{package} is not installed; .*\[{extra}\]"):
            qp_backend(name)


@pytest.mark.parametrize("seed", range(4))
def test_the_residual_is_zero_at_the_optimum_only(seed: int) -> None:
    qp = random_qp(seed)
    best = qp_backend("piqp").solve(qp)
    assert qp.residual(best.x, best.row_multipliers) < 1e-5
    rng = np.random.default_rng(seed)
    for _ in range(20):
        moved = best.x + 0.1 * rng.normal(size=len(best.x))
        assert qp.residual(moved, best.row_multipliers) > 1e-3


@pytest.mark.parametrize(
    ("x", "multiplier", "status"),
    [
        ([1.0, -1.0, 0.0], 0.0, QpStatus.SOLVED),
        ([1.0, -1.0, 0.0], np.nan, QpStatus.SOLVED),
        ([0.5, -1.0, 0.0], 0.0, QpStatus.INACCURATE),
        ([1.0, 0.5, 0.0], np.nan, QpStatus.INACCURATE),
        ([9.0, -1.0, 0.0], 0.0, QpStatus.FAILED),
        ([np.nan, -1.0, 0.0], 0.0, QpStatus.FAILED),
    ],
)
def test_success_is_not_taken_at_its_word(x: list[float], multiplier: float, status: QpStatus) -> None:
    claimed = QpSolution(QpStatus.SOLVED, np.array(x), np.array([multiplier]), 1)
    assert checked(softened(), claimed).status is status
