"""PIQP: proximal interior point method (Schwan et al., CDC 2023). The default."""

from dataclasses import dataclass, field

import piqp

from trajopt.optimise.solvers.qp.backend import Qp, QpSolution, QpStatus


@dataclass(eq=False)
class Piqp:
    """PIQP's sparse backend."""

    tolerance: float = 1e-6
    max_iterations: int = 100
    _solver: piqp.SparseSolver = field(default_factory=piqp.SparseSolver, init=False, repr=False)
    _taken: Qp | None = field(default=None, init=False, repr=False)

    def solve(self, qp: Qp) -> QpSolution:
        known = qp.same_pattern(self._taken)
        if not known:
            self._solver = self._fresh()
        take = self._solver.update if known else self._solver.setup
        take(P=qp.P, c=qp.q, G=qp.A, h_l=qp.l, h_u=qp.u, x_l=qp.lower, x_u=qp.upper)
        self._taken = qp
        outcome = self._solver.solve()
        result = self._solver.result
        status = {
            piqp.PIQP_SOLVED: QpStatus.SOLVED,
            piqp.PIQP_MAX_ITER_REACHED: QpStatus.INACCURATE,
        }.get(outcome, QpStatus.FAILED)
        return QpSolution(status, result.x.copy(), (result.z_u - result.z_l).copy(), result.info.iter)

    def _fresh(self) -> piqp.SparseSolver:
        solver = piqp.SparseSolver()
        settings = solver.settings
        settings.eps_abs = settings.eps_rel = self.tolerance
        settings.max_iter = self.max_iterations
        settings.check_duality_gap = True
        settings.eps_duality_gap_abs = settings.eps_duality_gap_rel = self.tolerance
        return solver
