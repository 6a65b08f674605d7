"""OSQP: operator splitting (Stellato et al., Math. Prog. Comp. 2020). Rough solves, warm starts."""

from dataclasses import dataclass, field

import numpy as np
import osqp
from scipy.sparse import csc_matrix, eye, triu, vstack

from trajopt.optimise.solvers.qp.backend import Qp, QpSolution, QpStatus, finite
from trajopt.values.arrays import Floats
from trajopt.values.errors import SolverError


@dataclass(eq=False)
class Osqp:
    """OSQP; bounds of variables become rows."""

    tolerance: float = 1e-5
    max_iterations: int = 20_000
    _solver: osqp.OSQP | None = field(default=None, init=False, repr=False)
    _rows: int = field(default=0, init=False, repr=False)

    def setup(self, qp: Qp) -> None:
        matrix, lower, upper = self._stacked(qp)
        self._rows = qp.A.shape[0]
        self._solver = osqp.OSQP()
        self._solver.setup(
            P=csc_matrix(triu(qp.P)), q=qp.q, A=matrix, l=lower, u=upper,
            eps_abs=self.tolerance, eps_rel=self.tolerance, max_iter=self.max_iterations,
            verbose=False,
        )  # fmt: skip

    def update(self, qp: Qp) -> None:
        if self._solver is None:
            raise SolverError("Osqp.update before setup")
        matrix, lower, upper = self._stacked(qp)
        self._solver.update(q=qp.q, l=lower, u=upper, Px=csc_matrix(triu(qp.P)).data, Ax=matrix.data)

    def solve(self) -> QpSolution:
        if self._solver is None:
            raise SolverError("Osqp.solve before setup")
        result = self._solver.solve(raise_error=False)
        known: dict[int, QpStatus] = {
            osqp.SolverStatus.OSQP_SOLVED: QpStatus.SOLVED,
            osqp.SolverStatus.OSQP_SOLVED_INACCURATE: QpStatus.INACCURATE,
            osqp.SolverStatus.OSQP_MAX_ITER_REACHED: QpStatus.INACCURATE,
        }
        status = known.get(result.info.status_val, QpStatus.FAILED)
        return QpSolution(status, np.array(result.x), np.array(result.y)[: self._rows], int(result.info.iter))

    @staticmethod
    def _stacked(qp: Qp) -> tuple[csc_matrix, Floats, Floats]:
        matrix = vstack((qp.A, eye(len(qp.q), format="csc")), format="csc")
        lower = finite(np.concatenate((qp.l, qp.lower)))
        upper = finite(np.concatenate((qp.u, qp.upper)))
        return matrix, lower, upper
