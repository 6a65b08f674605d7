"""The interface of all QP backends: setup once a pattern, update values, solve."""

from dataclasses import dataclass
from enum import Enum
from typing import TYPE_CHECKING, Protocol

import numpy as np

from trajopt.arrays import Floats

if TYPE_CHECKING:
    from scipy.sparse import csc_matrix

UNBOUNDED = 1e20
"""What backends that know no infinity are given in its place."""


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

    def same_pattern(self, other: "Qp") -> bool:
        """Say whether the other has non-zeros at the same places."""
        return all(
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
        """Return how far a point and its multipliers are from optimal, >= 0; 0 only at an optimum.

        The natural residual of the KKT conditions, with the gradient g = Px + q + A'y and the projection
        onto bounds: max(|x - clip(x - g)|, |Ax - clip(Ax + y)|) (Facchinei and Pang, Finite-Dimensional
        Variational Inequalities, 2003, section 1.5).

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
    INACCURATE = "stopped at its iteration limit, or its answer is not as good as it says"
    FAILED = "failed or found the program infeasible"


@dataclass(frozen=True, eq=False)
class QpSolution:
    """What a backend returned.

    Attributes:
        status: How it ended.
        x: The minimiser, shape (n,).
        row_multipliers: Of the rows, positive at the upper bound, shape (m,); NaN where the backend
            states none.
        iterations: Iterations used.
    """

    status: QpStatus
    x: Floats
    row_multipliers: Floats
    iterations: int


class QpBackend(Protocol):
    """A QP solver that may keep what depends on the pattern only."""

    def setup(self, qp: Qp) -> None:
        """Take a program and analyse its pattern."""
        ...

    def update(self, qp: Qp) -> None:
        """Take new values of a program with the same pattern."""
        ...

    def solve(self) -> QpSolution:
        """Solve the program taken last."""
        ...


def finite(bound: Floats) -> Floats:
    """Return bounds with infinities replaced by `UNBOUNDED`."""
    return np.clip(bound, -UNBOUNDED, UNBOUNDED)
