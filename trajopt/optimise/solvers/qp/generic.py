"""Any QP solver that qpsolvers knows and finds installed."""

import warnings
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
import qpsolvers
from scipy.sparse import csc_matrix, eye, vstack

from trajopt.optimise.solvers.qp.backend import BACKENDS, GENERAL, GPL, Qp, QpSolution, QpStatus
from trajopt.values.arrays import Floats
from trajopt.values.errors import BackendFailed, MissingExtra, SolverNotFound, shown

OPTIONS: Mapping[str, Mapping[str, float]] = {
    "scs": {"eps_abs": 1e-6, "eps_rel": 1e-6},
    "highs": {"qp_iteration_limit": 20_000, "simplex_iteration_limit": 20_000},
}
"""Options of solvers whose defaults are too inaccurate for a step, or have no limit of time."""
STRICT = {"quadprog"}
"""Solvers of positive definite Hessians only: the proximal point method is run for them."""
PROXIMAL_WEIGHT = 1e-3
"""Weight of the squared distance from the last point."""
PROXIMAL_STEPS = 100
"""Its steps at most."""
PROXIMAL_TOLERANCE = 1e-5
"""It has converged when no variable moves farther."""


@dataclass(frozen=True)
class Generic:
    """A backend of qpsolvers by name.

    Raises:
        MissingExtra: If it is known and not installed.
        SolverNotFound: If it is unknown.
    """

    solver: str

    def __post_init__(self) -> None:
        if self.solver not in qpsolvers.available_solvers:
            if self.solver in GENERAL:
                raise MissingExtra(GENERAL[self.solver], "qp-gpl" if self.solver in GPL else "qp")
            raise SolverNotFound("QP solver", self.solver, {*BACKENDS, *qpsolvers.available_solvers})

    def solve(self, qp: Qp) -> QpSolution:
        return self._proximal(qp) if self.solver in STRICT else self._once(qp)

    def _proximal(self, qp: Qp) -> QpSolution:
        """Iterate x+ = argmin f(x) + w/2 |x - x-|^2 (Rockafellar, SIAM J. Control 14, 1976)."""
        size = len(qp.q)
        hessian = csc_matrix(qp.P + PROXIMAL_WEIGHT * eye(size, format="csc"))
        at: Floats = np.zeros(size)
        count = 0
        while True:
            found, count = self._once(replace(qp, P=hessian, q=qp.q - PROXIMAL_WEIGHT * at)), count + 1
            moved = float(np.abs(found.x - at).max(initial=0.0))
            at = found.x
            if found.status is not QpStatus.SOLVED or moved <= PROXIMAL_TOLERANCE:
                return replace(found, iterations=count)
            if count == PROXIMAL_STEPS:
                return replace(found, status=QpStatus.INACCURATE, iterations=count)

    def _once(self, qp: Qp) -> QpSolution:
        above, below = np.isfinite(qp.u), np.isfinite(qp.l)
        rows = csc_matrix(vstack((qp.A[above], -qp.A[below]), format="csc"))
        bounds = np.concatenate((qp.u[above], -qp.l[below]))
        dense = self.solver not in qpsolvers.sparse_solvers
        hessian, matrix = (qp.P.toarray(), rows.toarray()) if dense else (qp.P, rows)
        problem = qpsolvers.Problem(hessian, qp.q, matrix, bounds, lb=qp.lower, ub=qp.upper)
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # a failure is in the solution, and told from there
                solution = qpsolvers.solve_problem(
                    problem, solver=self.solver, **OPTIONS.get(self.solver, {})
                )
        except Exception as error:  # any backend may raise anything; it is wrapped, never hidden
            raise BackendFailed(f"QP solver {shown(self.solver)} raised: {error}") from error
        if not solution.found or solution.x is None:
            return QpSolution(QpStatus.FAILED, np.zeros(len(qp.q)), np.full(len(qp.u), np.nan), 0)
        multipliers = np.zeros(len(qp.u))
        if solution.z is None:
            multipliers[:] = np.nan
        else:
            split = int(above.sum())
            multipliers[above] += solution.z[:split]
            multipliers[below] -= solution.z[split:]
        return QpSolution(QpStatus.SOLVED, np.array(solution.x), multipliers, 0)
