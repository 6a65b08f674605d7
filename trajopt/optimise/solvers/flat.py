"""The QP of a step as one sparse matrix, for general backends."""

from dataclasses import dataclass, field

import numpy as np
from scipy.sparse import coo_matrix, csc_matrix, csr_matrix, vstack

from trajopt.optimise.nlp import Linearisation
from trajopt.optimise.solvers.qp import Qp, QpBackend, QpSolution, QpStatus, checked, qp_backend
from trajopt.optimise.solvers.subproblem import REGULARISATION, QpStep, softened_rows
from trajopt.values.arrays import Bools, Floats, Ints, Loss, Rows
from trajopt.values.errors import BackendFailed


def _matrix(rows: Rows, column: Ints, count: int) -> csc_matrix:
    """Scatter block rows; -1 marks fixed variables."""
    m, _, n = rows.jacobian.shape
    columns = column.reshape(-1, n)[rows.knots]
    index = np.broadcast_to(np.arange(m, dtype=np.int64)[:, None, None], columns.shape)
    keep = (columns >= 0) & (rows.jacobian != 0.0)
    return csc_matrix(coo_matrix((rows.jacobian[keep], (index[keep], columns[keep])), shape=(m, count)))


@dataclass(frozen=True, eq=False)
class Subproblem:
    """The QP around one point, for any trust region: the free variables' step, then a slack for every bound.

    Attributes:
        hessian: Of the squared costs, shape (f, f).
        gradient: Shape (f,).
        rows: Softened rows, one-sided: matrix @ dx - slack <= bound, shape (m, f).
        bound: Shape (m,).
        penalty: Weight of each slack, shape (m,).
        free: Index of the free variables in the flattened knots, shape (f,).
    """

    hessian: csc_matrix
    gradient: Floats
    rows: csc_matrix
    bound: Floats
    penalty: Floats
    free: Ints

    def qp(self, lower: Floats, upper: Floats) -> Qp:
        """Return the QP with the step between bounds, each of shape (f,)."""
        f, m = len(self.free), len(self.bound)
        identity = -csc_matrix((np.ones(m), np.arange(m), np.arange(m + 1)), shape=(m, m), dtype=np.float64)
        return Qp(
            P=_grow(self.hessian, f + m),
            q=np.concatenate((self.gradient, self.penalty)),
            A=_beside(self.rows, identity),
            l=np.full(m, -np.inf),
            u=self.bound,
            lower=np.concatenate((lower, np.zeros(m))),
            upper=np.concatenate((upper, np.full(m, np.inf))),
        )

    def model(self, step: Floats) -> float:
        excess = np.maximum(0.0, self.rows @ step - self.bound)
        return float(0.5 * step @ (self.hessian @ step) + self.gradient @ step + self.penalty @ excess)


def _grow(matrix: csc_matrix, size: int) -> csc_matrix:
    pointers = np.concatenate(
        (matrix.indptr, np.full(size - matrix.shape[1], matrix.indptr[-1], matrix.indptr.dtype))
    )
    return csc_matrix((matrix.data, matrix.indices, pointers), shape=(size, size))


def _beside(left: csc_matrix, right: csc_matrix) -> csc_matrix:
    return csc_matrix(
        (
            np.concatenate((left.data, right.data)),
            np.concatenate((left.indices, right.indices)),
            np.concatenate((left.indptr[:-1], left.indptr[-1] + right.indptr)),
        ),
        shape=(left.shape[0], left.shape[1] + right.shape[1]),
    )


def subproblem(moves: Bools, at: Linearisation, penalty: float) -> Subproblem:
    """Build the QP of a step around a point; `moves` marks the variables that may change, shape (N, n)."""
    free = np.flatnonzero(moves)
    column = np.full(moves.size, -1, dtype=np.int64)
    column[free] = np.arange(len(free))
    hessian = csc_matrix((len(free), len(free)))
    gradient = np.zeros(len(free))
    for block in at.costs:
        if block.loss is Loss.SQUARED:
            jacobian = _matrix(block.rows, column, len(free))
            weighted = csc_matrix(jacobian.multiply(2.0 * block.weight[:, None]))
            hessian = hessian + weighted.T @ jacobian
            gradient += weighted.T @ block.rows.value
    diagonal = np.arange(len(free))
    hessian = csc_matrix(hessian) + csc_matrix(
        (np.full(len(free), REGULARISATION), (diagonal, diagonal)), shape=hessian.shape
    )
    matrices: list[csc_matrix | csr_matrix] = [csc_matrix((0, len(free)))]
    bounds: list[Floats] = []
    penalties: list[Floats] = []
    for block in softened_rows(at, penalty):
        matrix = _matrix(block.rows, column, len(free)).tocsr()
        for sign, side in ((1.0, block.upper), (-1.0, block.lower)):
            used = np.flatnonzero(np.isfinite(side))
            if len(used):
                matrices.append(sign * matrix[used])
                bounds.append(sign * (side[used] - block.rows.value[used]))
                penalties.append(block.penalty[used])
    rows = csc_matrix(vstack(matrices, format="csc"))
    rows.sort_indices()
    return Subproblem(
        csc_matrix(hessian),
        gradient,
        rows,
        np.concatenate(bounds) if bounds else np.zeros(0),
        np.concatenate(penalties) if penalties else np.zeros(0),
        free,
    )


@dataclass(eq=False)
class FlatSteps:
    """Steps by a general backend."""

    name: str
    _backend: QpBackend = field(init=False)

    def __post_init__(self) -> None:
        self._backend = qp_backend(self.name)

    def program(self, moves: Bools, at: Linearisation, penalty: float) -> "FlatStep":
        return FlatStep(self, subproblem(moves, at, penalty), at.x.shape)

    def solve(self, qp: Qp) -> QpSolution | None:
        try:
            solution = checked(qp, self._backend.solve(qp))
        except BackendFailed:
            return None
        return None if solution.status is QpStatus.FAILED else solution


@dataclass(frozen=True, eq=False)
class FlatStep:
    """The QP around one point; see `StepProgram`."""

    solver: FlatSteps
    model: Subproblem
    shape: tuple[int, ...]

    @property
    def rows(self) -> int:
        return len(self.model.bound)

    @property
    def backend(self) -> str:
        return self.solver.name

    def solve(self, lower: Floats, upper: Floats, accuracy: float) -> QpStep | None:
        free = self.model.free
        low, high = lower.ravel()[free], upper.ravel()[free]
        solution = self.solver.solve(self.model.qp(low, high))
        if solution is None:
            return None
        reduced = np.clip(solution.x[: len(free)], low, high)
        predicted_reduction = self.model.model(np.zeros_like(reduced)) - self.model.model(reduced)
        if predicted_reduction <= 0.0 and solution.status is QpStatus.INACCURATE:
            return None  # an inaccurate solution without gain does not show that there is none
        step = np.zeros(lower.size)
        step[free] = reduced
        return QpStep(step.reshape(self.shape), predicted_reduction, solution.iterations)
