"""The QP of one step behind one interface: written around a point, solved for any trust region."""

from dataclasses import dataclass
from typing import Protocol

from trajopt.arrays import Bools, Floats
from trajopt.nlp import Linearisation


@dataclass(frozen=True, eq=False)
class Step:
    """The minimiser of a step's QP.

    Attributes:
        dx: Change of the knots, shape (N, n).
        predicted_reduction: By how much the merit falls, if the linearisation is right.
        iterations: Iterations that the backend used.
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

    def solve(self, lower: Floats, upper: Floats, accuracy: float) -> Step | None:
        """Return the best step between bounds.

        Args:
            lower: Of the knots' change, shape (N, n).
            upper: Likewise.
            accuracy: By how much the model's value may exceed its least one. General backends
                solve to their own tolerance instead.

        Returns:
            The step, or None where the backend failed.
        """
        ...


class StepSolver(Protocol):
    """Writes the QPs of the steps; what depends on their pattern only may be kept between them."""

    def program(self, moves: Bools, at: Linearisation, penalty: float) -> StepProgram:
        """Write the QP around a point.

        Args:
            moves: Which variables may change, shape (N, n).
            at: The point.
            penalty: Weight of constraint violations.
        """
        ...
