"""Which backend solves the QPs of the steps: named by the user, or chosen by structure."""

from dataclasses import dataclass, field

import numpy as np

from trajopt.optimise.nlp import Linearisation
from trajopt.optimise.solvers.step import StepProgram, StepSolver
from trajopt.values.arrays import Bools

AUTO = "auto"
"""The banded solver if rows couple neighbouring knots only, else PIQP."""
GENERAL = "piqp"
"""The backend of programs without the structure."""
WIDEST = 5
"""Knots that a row may span for the banded solver to be worthwhile."""


def step_solver(name: str) -> StepSolver:
    """Return a step solver.

    Args:
        name: "auto", "banded", "piqp", "osqp", "proxqp", or any solver that qpsolvers knows.

    Raises:
        SolverNotFound: If there is no such backend.
    """
    if name == AUTO:
        return ByStructure()
    if name == "banded":
        from trajopt.optimise.solvers.banded import BandedSteps

        return BandedSteps()
    return _general(name)


def _general(name: str) -> StepSolver:
    from trajopt.optimise.solvers.flat import FlatSteps

    return FlatSteps(name)


@dataclass(eq=False)
class ByStructure:
    """Chooses for each program; `StepProgram.backend` says which."""

    _band: StepSolver = field(default_factory=lambda: step_solver("banded"))
    _wide: StepSolver | None = None

    def program(self, moves: Bools, at: Linearisation, penalty: float) -> StepProgram:
        """Write the QP around a point for the backend that suits its rows; see `StepSolver`."""
        if _span(at) <= WIDEST:
            return self._band.program(moves, at, penalty)
        if self._wide is None:
            self._wide = _general(GENERAL)
        return self._wide.program(moves, at, penalty)


def _span(at: Linearisation) -> int:
    """Return the largest number of knots that a row spans."""
    blocks = [block.rows.knots for block in (*at.costs, *at.constraints)]
    return max((int(np.ptp(knots, axis=1).max()) for knots in blocks if knots.size), default=0)
