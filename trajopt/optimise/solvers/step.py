"""The QP of one step behind one interface: written around a point, solved for any trust region."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

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
        iterations: Iterations of the backend.
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
        """Return the best step between bounds.

        Args:
            lower: Of the knots' change, shape (N, n).
            upper: Likewise.
            accuracy: Largest excess of the model's value over its minimum. General backends
                solve to their own tolerance instead.

        Returns:
            The step, or None if the backend failed.
        """
        ...


class StepSolver(Protocol):
    """Builds the QPs of the steps; data that depend on the pattern only may be kept between them."""

    def program(self, moves: Bools, at: Linearisation, penalty: float) -> StepProgram:
        """Build the QP around a point.

        Args:
            moves: Which variables may change, shape (N, n).
            at: The point.
            penalty: Weight of constraint violations.
        """
        ...


@dataclass(frozen=True, eq=False)
class SoftenedRows:
    """Constraints and costs with a kink: penalty * max(0, lower - r) + penalty * max(0, r - upper).

    Attributes:
        rows: The linearised rows.
        lower: Shape (m,); -inf for none.
        upper: Shape (m,); inf for none.
        penalty: Shape (m,).
    """

    rows: Rows
    lower: Floats
    upper: Floats
    penalty: Floats


def softened_rows(at: Linearisation, penalty: float) -> list[SoftenedRows]:
    """List constraints and non-smooth costs as softened rows.

    Args:
        at: The point.
        penalty: Weight of constraint violations.
    """
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
