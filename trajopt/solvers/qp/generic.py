"""Any QP solver that qpsolvers knows and finds installed."""

import warnings
from dataclasses import dataclass, field

import numpy as np
import qpsolvers
from scipy.sparse import csc_matrix, vstack

from trajopt.errors import BackendFailed, SolverError, SolverNotFound
from trajopt.solvers.qp.backend import Qp, QpSolution, QpStatus


@dataclass(eq=False)
class Generic:
    """A backend of qpsolvers by name; rebuilt at every solve.

    Attributes:
        solver: Its name there.

    Raises:
        SolverNotFound: If it is not installed.
    """

    solver: str
    _qp: Qp | None = field(default=None, init=False, repr=False)

    def __post_init__(self) -> None:
        """Look the solver up."""
        if self.solver not in qpsolvers.available_solvers:
            raise SolverNotFound("installed QP solver", self.solver, qpsolvers.available_solvers)

    def setup(self, qp: Qp) -> None:
        """Take a program."""
        self._qp = qp

    def update(self, qp: Qp) -> None:
        """Take a program anew."""
        self._qp = qp

    def solve(self) -> QpSolution:
        """Hand the program to qpsolvers as one-sided rows."""
        qp = self._qp
        if qp is None:
            raise SolverError("Generic.solve before setup")
        above, below = np.isfinite(qp.u), np.isfinite(qp.l)
        rows = csc_matrix(vstack((qp.A[above], -qp.A[below]), format="csc"))
        bounds = np.concatenate((qp.u[above], -qp.l[below]))
        dense = self.solver not in qpsolvers.sparse_solvers
        hessian, matrix = (qp.P.toarray(), rows.toarray()) if dense else (qp.P, rows)
        problem = qpsolvers.Problem(hessian, qp.q, matrix, bounds, lb=qp.lower, ub=qp.upper)
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # a failure is in the solution, and told from there
                solution = qpsolvers.solve_problem(problem, solver=self.solver)
        except Exception as error:  # any backend may raise anything; it is wrapped, never hidden
            raise BackendFailed(f"QP solver {self.solver!r} raised: {error}") from error
        multipliers = np.zeros(len(qp.u))
        if not solution.found or solution.x is None:
            return QpSolution(QpStatus.FAILED, np.zeros(len(qp.q)), multipliers, 0)
        if solution.z is not None:
            split = int(above.sum())
            multipliers[above] += solution.z[:split]
            multipliers[below] -= solution.z[split:]
        return QpSolution(QpStatus.SOLVED, np.array(solution.x), multipliers, 0)
