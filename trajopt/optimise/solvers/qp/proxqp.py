"""ProxQP: proximal augmented Lagrangian (Bambade et al., RSS 2022), its sparse and its dense backend."""

from dataclasses import dataclass

import proxsuite
from scipy.sparse import csc_matrix

from trajopt.optimise.solvers.qp.backend import Qp, QpSolution, QpStatus, stacked
from trajopt.values.arrays import Floats


@dataclass(frozen=True)
class Proxqp:
    """ProxQP on sparse matrices; bounds of variables become rows.

    Every solve starts afresh: warm starts with updated matrices report success at points that are not
    optimal (version 0.8.0).
    """

    tolerance: float = 1e-7
    max_iterations: int = 1_000

    def solve(self, qp: Qp) -> QpSolution:
        solver = self._of(qp, *stacked(qp))
        solver.solve()
        result = solver.results
        codes = proxsuite.proxqp.QPSolverOutput
        status = {
            codes.PROXQP_SOLVED: QpStatus.SOLVED,
            codes.PROXQP_MAX_ITER_REACHED: QpStatus.INACCURATE,
        }.get(result.info.status, QpStatus.FAILED)
        return QpSolution(status, result.x.copy(), result.z[: len(qp.l)].copy(), int(result.info.iter))

    def _of(
        self, qp: Qp, matrix: csc_matrix, lower: Floats, upper: Floats
    ) -> proxsuite.proxqp.sparse.QP | proxsuite.proxqp.dense.QP:
        solver = proxsuite.proxqp.sparse.QP(len(qp.q), 0, matrix.shape[0])
        self._set(solver.settings)
        solver.init(qp.P, qp.q, None, None, matrix, lower, upper)
        return solver

    def _set(self, settings: proxsuite.proxqp.Settings) -> None:
        settings.eps_abs = self.tolerance
        settings.eps_rel = 0.0
        settings.max_iter = self.max_iterations
        # Its tests of infeasibility at 1e-4 mistake large slacks for a proof.
        settings.eps_primal_inf = settings.eps_dual_inf = 1e-12
        # Residuals alone let it stop with an objective that is off by some per cent.
        settings.check_duality_gap = True
        settings.eps_duality_gap_abs = self.tolerance
        settings.eps_duality_gap_rel = 0.0


@dataclass(frozen=True)
class DenseProxqp(Proxqp):
    """ProxQP on dense matrices."""

    def _of(
        self, qp: Qp, matrix: csc_matrix, lower: Floats, upper: Floats
    ) -> proxsuite.proxqp.sparse.QP | proxsuite.proxqp.dense.QP:
        solver = proxsuite.proxqp.dense.QP(len(qp.q), 0, matrix.shape[0])
        self._set(solver.settings)
        solver.init(qp.P.toarray(), qp.q, None, None, matrix.toarray(), lower, upper)
        return solver
