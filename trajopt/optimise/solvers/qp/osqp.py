"""OSQP: operator splitting (Stellato et al., Math. Prog. Comp. 2020). Rough solves, warm starts."""

from dataclasses import dataclass, field

import numpy as np
import osqp
from scipy.sparse import csc_matrix, triu

from trajopt.optimise.solvers.qp.backend import Qp, QpSolution, QpStatus, stacked


@dataclass(eq=False)
class Osqp:
    """OSQP; bounds of variables become rows."""

    tolerance: float = 1e-5
    max_iterations: int = 20_000
    _solver: osqp.OSQP = field(default_factory=osqp.OSQP, init=False, repr=False)
    _taken: Qp | None = field(default=None, init=False, repr=False)

    def solve(self, qp: Qp) -> QpSolution:
        matrix, lower, upper = stacked(qp)
        hessian = csc_matrix(triu(qp.P))
        if qp.same_pattern(self._taken):
            self._solver.update(q=qp.q, l=lower, u=upper, Px=hessian.data, Ax=matrix.data)
        else:
            self._solver = osqp.OSQP()
            self._solver.setup(
                P=hessian, q=qp.q, A=matrix, l=lower, u=upper, eps_abs=self.tolerance,
                eps_rel=self.tolerance, max_iter=self.max_iterations, verbose=False,
            )  # fmt: skip
        self._taken = qp
        result = self._solver.solve(raise_error=False)
        known: dict[int, QpStatus] = {
            osqp.SolverStatus.OSQP_SOLVED: QpStatus.SOLVED,
            osqp.SolverStatus.OSQP_SOLVED_INACCURATE: QpStatus.INACCURATE,
            osqp.SolverStatus.OSQP_MAX_ITER_REACHED: QpStatus.INACCURATE,
        }
        status = known.get(result.info.status_val, QpStatus.FAILED)
        return QpSolution(status, np.array(result.x), np.array(result.y)[: len(qp.l)], int(result.info.iter))
