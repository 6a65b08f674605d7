"""The QP of one SQP step: its interface, and the banded solver in C++."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from trajopt.native import banded
from trajopt.optimise.nlp import Linearisation
from trajopt.values.arrays import Bools, Floats, Loss, Rows

REGULARISATION = 1e-9
"""Added to the Hessian's diagonal, so that variables without cost do not move."""


@dataclass(frozen=True, eq=False)
class QpStep:
    """The minimiser of a step's QP.

    Attributes:
        dx: Change of the knots, shape (N, n).
        predicted_reduction: Reduction of the merit predicted by the linearisation.
    """

    dx: Floats
    predicted_reduction: float
    iterations: int


class StepProgram(Protocol):
    """The QP around one point: squared costs, and penalised excess over bounds of linear rows."""

    @property
    def rows(self) -> int:
        """Penalised rows."""
        ...

    @property
    def backend(self) -> str:
        """Name of the backend that solves it."""
        ...

    def solve(self, lower: Floats, upper: Floats, accuracy: float) -> QpStep | None:
        """Return the best step between bounds; None if the backend failed.

        Args:
            lower: Of the knots' change, shape (N, n).
            upper: Shape (N, n).
            accuracy: Largest excess of the model's value over its minimum. General backends use their own
                tolerance instead.
        """
        ...


class StepSolver(Protocol):
    """Builds the QPs of the steps; data that depend on the pattern only may be kept between them."""

    def program(self, moves: Bools, at: Linearisation, penalty: float) -> StepProgram:
        """Build the QP around a point.

        Args:
            moves: Which variables may change, shape (N, n).
        """
        ...


@dataclass(frozen=True, eq=False)
class SoftenedRows:
    """Constraints and costs with a kink: penalty * max(0, lower - r) + penalty * max(0, r - upper).

    Attributes:
        lower: Shape (m,); -inf for none.
        upper: Shape (m,); inf for none.
        penalty: Shape (m,).
    """

    rows: Rows
    lower: Floats
    upper: Floats
    penalty: Floats


def softened_rows(at: Linearisation, penalty: float) -> list[SoftenedRows]:
    softened = [
        SoftenedRows(block.rows, block.lower, block.upper, np.full(len(block.lower), penalty))
        for block in at.constraints
    ]
    for block in at.costs:
        if block.loss is not Loss.SQUARED:
            size = len(block.weight)
            lower = np.zeros(size) if block.loss is Loss.ABSOLUTE else np.full(size, -np.inf)
            softened.append(SoftenedRows(block.rows, lower, np.zeros(size), block.weight))
    return softened


NAME = "banded"
"""Its name in `Sqp.qp`."""
SOLVED = (0, 1)
"""Codes of the core: solved, and stopped at the limit of iterations, inaccurate but usable."""


@dataclass(frozen=True)
class BandedSteps:
    """Steps by the native interior point method.

    Every row touches few neighbouring knots, so the system of every iteration is a band whose pattern does
    not depend on the number of rows: docs/decisions/banded-qp.md.
    """

    max_iterations: int = 60

    def program(self, moves: Bools, at: Linearisation, penalty: float) -> "BandedStep":
        core = banded.Program(moves.shape[1], np.ascontiguousarray(moves).ravel())
        for block in at.costs:
            if block.loss is Loss.SQUARED:
                core.add_squared(*_arrays(block.rows), block.weight)
        for soft in softened_rows(at, penalty):
            core.add_excess(*_arrays(soft.rows), soft.lower, soft.upper, soft.penalty)
        return BandedStep(self, core)


@dataclass(frozen=True, eq=False)
class BandedStep:
    """The QP around one point; see `StepProgram`."""

    solver: BandedSteps
    core: banded.Program

    @property
    def rows(self) -> int:
        return self.core.rows

    @property
    def backend(self) -> str:
        return NAME

    def solve(self, lower: Floats, upper: Floats, accuracy: float) -> QpStep | None:
        dx, predicted_reduction, code, iterations = self.core.solve(
            lower.ravel(), upper.ravel(), REGULARISATION, accuracy, self.solver.max_iterations
        )
        return QpStep(dx.reshape(lower.shape), predicted_reduction, iterations) if code in SOLVED else None


def _arrays(rows: Rows) -> tuple[Floats, Floats, np.ndarray]:
    return rows.value, np.ascontiguousarray(rows.jacobian), np.ascontiguousarray(rows.knots)
