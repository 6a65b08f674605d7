"""PIQP: proximal interior point method (Schwan et al., CDC 2023). The default."""

from dataclasses import dataclass, field

import piqp

from trajopt.optimise.solvers.qp.backend import Qp, QpSolution, QpStatus
from trajopt.values.errors import SolverError


@dataclass(eq=False)
class Piqp:
    """PIQP's sparse backend."""

    tolerance: float = 1e-6
    max_iterations: int = 100
    _solver: piqp.SparseSolver | None = field(default=None, init=False, repr=False)

    def setup(self, qp: Qp) -> None:
        solver = piqp.SparseSolver()
        solver.settings.eps_abs = self.tolerance
        solver.settings.eps_rel = self.tolerance
        solver.settings.max_iter = self.max_iterations
        solver.settings.check_duality_gap = True
        solver.settings.eps_duality_gap_abs = self.tolerance
        solver.settings.eps_duality_gap_rel = self.tolerance
        solver.setup(P=qp.P, c=qp.q, G=qp.A, h_l=qp.l, h_u=qp.u, x_l=qp.lower, x_u=qp.upper)
        self._solver = solver

    def update(self, qp: Qp) -> None:
        if self._solver is None:
            raise SolverError("Piqp.update before setup")
        self._solver.update(P=qp.P, c=qp.q, G=qp.A, h_l=qp.l, h_u=qp.u, x_l=qp.lower, x_u=qp.upper)

    def solve(self) -> QpSolution:
        if self._solver is None:
            raise SolverError("Piqp.solve before setup")
        outcome = self._solver.solve()
        result = self._solver.result
        status = {
            piqp.PIQP_SOLVED: QpStatus.SOLVED,
            piqp.PIQP_MAX_ITER_REACHED: QpStatus.INACCURATE,
        }.get(outcome, QpStatus.FAILED)
        return QpSolution(status, result.x.copy(), (result.z_u - result.z_l).copy(), result.info.iter)
