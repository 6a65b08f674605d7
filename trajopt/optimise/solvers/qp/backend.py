"""The interface of all QP backends."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from enum import Enum
from typing import TYPE_CHECKING, Protocol

import numpy as np

from trajopt.values.arrays import Floats

if TYPE_CHECKING:
    from scipy.sparse import csc_matrix

UNBOUNDED = 1e20
"""Replaces infinity in backends without it."""
VIOLATION = 1e-3
"""Largest violation of rows and bounds that a solution may have."""
RESIDUAL = 1e-2
"""Largest residual of the optimality conditions that a solution may have."""
USELESS = 1.0
"""An answer with a larger violation is none."""

NATIVE: Mapping[str, tuple[str, str]] = {
    "piqp": ("trajopt.optimise.solvers.qp.piqp", "Piqp"),
    "osqp": ("trajopt.optimise.solvers.qp.osqp", "Osqp"),
    "proxqp": ("trajopt.optimise.solvers.qp.proxqp", "Proxqp"),
    "proxqp-dense": ("trajopt.optimise.solvers.qp.proxqp", "DenseProxqp"),
}
"""Module and class of the backends that are called directly; their packages come with trajopt."""

GENERAL: Mapping[str, str] = {
    "clarabel": "clarabel",
    "daqp": "daqp",
    "highs": "highspy",
    "qpalm": "qpalm",
    "quadprog": "quadprog",
    "scs": "scs",
}
"""Backends driven through qpsolvers, and the package of each; in the extra `qp` but for `GPL`."""
GPL = ("quadprog",)
"""Backends under the GPL, in the extra `qp-gpl`: whoever distributes an environment has to know."""

BACKENDS = (*NATIVE, *GENERAL)
"""Names of the known backends; any other that qpsolvers finds installed works too."""


@dataclass(frozen=True, eq=False)
class Qp:
    """Minimise 1/2 x'Px + q'x subject to l <= Ax <= u and lower <= x <= upper.

    Attributes:
        P: Symmetric, positive semidefinite, both triangles stored, shape (n, n).
        q: Shape (n,).
        A: Shape (m, n).
        l: Shape (m,); -inf for none.
        u: Shape (m,); inf for none.
        lower: Shape (n,); -inf for none.
        upper: Shape (n,); inf for none.
    """

    P: "csc_matrix"
    q: Floats
    A: "csc_matrix"
    l: Floats  # noqa: E741 (the field's letter)
    u: Floats
    lower: Floats
    upper: Floats

    def same_pattern(self, other: "Qp | None") -> bool:
        """Return whether another program has its non-zeros in the same places."""
        return other is not None and all(
            a.shape == b.shape and np.array_equal(a.indptr, b.indptr) and np.array_equal(a.indices, b.indices)
            for a, b in ((self.P, other.P), (self.A, other.A))
        )

    def objective(self, x: Floats) -> float:
        """Return 1/2 x'Px + q'x."""
        return float(0.5 * x @ (self.P @ x) + self.q @ x)

    def violation(self, x: Floats) -> float:
        """Return the largest violation of rows and bounds at x, >= 0."""
        rows = self.A @ x
        parts = (self.l - rows, rows - self.u, self.lower - x, x - self.upper)
        return float(max((part.max(initial=0.0) for part in parts), default=0.0))

    def residual(self, x: Floats, row_multipliers: Floats) -> float:
        """Return the distance of a point and its multipliers from optimality, >= 0; 0 only at an optimum.

        The natural residual of the KKT conditions, with g = Px + q + A'y: max(|x - clip(x - g)|, |Ax -
        clip(Ax + y)|) (Facchinei and Pang, Finite-Dimensional Variational Inequalities, 2003, section 1.5).

        Args:
            x: Shape (n,).
            row_multipliers: Positive at the upper bound, shape (m,).
        """
        gradient = self.P @ x + self.q + self.A.T @ row_multipliers
        rows = self.A @ x
        stationarity = x - np.clip(x - gradient, self.lower, self.upper)
        complementarity = rows - np.clip(rows + row_multipliers, self.l, self.u)
        return float(max(np.abs(stationarity).max(initial=0.0), np.abs(complementarity).max(initial=0.0)))


class QpStatus(Enum):
    """How a backend ended."""

    SOLVED = "solved to its tolerance"
    INACCURATE = "stopped at its iteration limit, or its answer is not as good as it claims"
    FAILED = "failed or found the program infeasible"


@dataclass(frozen=True, eq=False)
class QpSolution:
    """Result of a backend.

    Attributes:
        x: The minimiser, shape (n,).
        row_multipliers: Positive at the upper bound, shape (m,); NaN if the backend states none.
    """

    status: QpStatus
    x: Floats
    row_multipliers: Floats
    iterations: int


class QpBackend(Protocol):
    """A QP solver that may keep data that depend on the pattern only."""

    def solve(self, qp: Qp) -> QpSolution:
        """Solve a program."""
        ...


def stacked(qp: Qp) -> "tuple[csc_matrix, Floats, Floats]":
    """Return the rows of a program with its bounds of variables below them, for backends without these."""
    from scipy.sparse import eye, vstack

    matrix = vstack((qp.A, eye(len(qp.q), format="csc")), format="csc")
    lower, upper = np.concatenate((qp.l, qp.lower)), np.concatenate((qp.u, qp.upper))
    return matrix, np.clip(lower, -UNBOUNDED, UNBOUNDED), np.clip(upper, -UNBOUNDED, UNBOUNDED)


def checked(qp: Qp, solution: QpSolution) -> QpSolution:
    """Return a solution with the status that it deserves, never better than its backend's."""
    return replace(solution, status=_status(qp, solution))


def _status(qp: Qp, solution: QpSolution) -> QpStatus:
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
