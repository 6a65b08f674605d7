"""A QP backend whose answers are checked: some report success where there is none."""

from dataclasses import dataclass, field, replace

import numpy as np

from trajopt.errors import SolverError
from trajopt.solvers.qp.backend import Qp, QpBackend, QpSolution, QpStatus

VIOLATION = 1e-3
"""Largest violation of rows and bounds that a solution may have."""
RESIDUAL = 1e-2
"""Largest residual of the optimality conditions that a solution may have."""
USELESS = 1.0
"""From this violation on an answer is none."""


@dataclass(eq=False)
class Checked:
    """A backend, and a second look at what it returns.

    Attributes:
        backend: Solves.
    """

    backend: QpBackend
    _qp: Qp | None = field(default=None, init=False, repr=False)

    def setup(self, qp: Qp) -> None:
        """Take a program and analyse its pattern."""
        self.backend.setup(qp)
        self._qp = qp

    def update(self, qp: Qp) -> None:
        """Take new values of a program with the same pattern."""
        self.backend.update(qp)
        self._qp = qp

    def solve(self) -> QpSolution:
        """Solve; a solution that does not hold what it says is called inaccurate, or failed."""
        if self._qp is None:
            raise SolverError("solve before setup")
        solution = self.backend.solve()
        return replace(solution, status=judged(self._qp, solution))


def judged(qp: Qp, solution: QpSolution) -> QpStatus:
    """Return the status that a solution deserves: never better than its backend's own."""
    if solution.status is QpStatus.FAILED or not np.isfinite(solution.x).all():
        return QpStatus.FAILED
    violation = qp.violation(solution.x)
    if violation > USELESS:
        return QpStatus.FAILED
    stated = bool(np.isfinite(solution.row_multipliers).all())
    good = violation <= VIOLATION and not (
        stated and qp.residual(solution.x, solution.row_multipliers) > RESIDUAL
    )
    return solution.status if good else QpStatus.INACCURATE
