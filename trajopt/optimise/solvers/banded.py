"""The QP of a step in its own structure: a band of blocks, slacks eliminated, interior point, in C++.

Every row touches few neighbouring knots, so the system of every iteration is a band whose pattern does not
depend on how many rows there are. The algebra is in docs/decisions/banded-qp.md.
"""

from dataclasses import dataclass

import numpy as np

from trajopt.native import banded
from trajopt.optimise.nlp import Linearisation
from trajopt.optimise.solvers.step import REGULARISATION, QpStep, softened_rows
from trajopt.values.arrays import Bools, Floats, Loss, Rows

NAME = "banded"
"""Its name in `Sqp.qp`."""
SOLVED = (0, 1)
"""Codes of the core: solved, and stopped at the limit of iterations, inaccurate but usable."""


@dataclass(frozen=True)
class BandedSteps:
    """Steps by the native interior point method.

    Attributes:
        max_iterations: Limit of interior-point iterations.
    """

    max_iterations: int = 60

    def program(self, moves: Bools, at: Linearisation, penalty: float) -> "BandedStep":
        """Build the QP around a point; see `StepSolver`."""
        core = banded.Program(moves.shape[1], np.ascontiguousarray(moves).ravel())
        for block in at.costs:
            if block.loss is Loss.SQUARED:
                core.add_squared(*_arrays(block.rows), block.weight)
        for soft in softened_rows(at, penalty):
            core.add_excess(*_arrays(soft.rows), soft.lower, soft.upper, soft.penalty)
        return BandedStep(self, core)


@dataclass(frozen=True, eq=False)
class BandedStep:
    """The QP around one point; see `StepProgram`.

    Attributes:
        solver: Its options.
        core: The native program.
    """

    solver: BandedSteps
    core: banded.Program

    @property
    def rows(self) -> int:
        """Penalised rows."""
        return self.core.rows

    @property
    def backend(self) -> str:
        """Name of the backend."""
        return NAME

    def solve(self, lower: Floats, upper: Floats, accuracy: float) -> QpStep | None:
        """Return the best step between bounds of shape (N, n); see `StepProgram`."""
        dx, predicted_reduction, code, iterations = self.core.solve(
            lower.ravel(), upper.ravel(), REGULARISATION, accuracy, self.solver.max_iterations
        )
        return QpStep(dx.reshape(lower.shape), predicted_reduction, iterations) if code in SOLVED else None


def _arrays(rows: Rows) -> tuple[Floats, Floats, np.ndarray]:
    return rows.value, np.ascontiguousarray(rows.jacobian), np.ascontiguousarray(rows.knots)
