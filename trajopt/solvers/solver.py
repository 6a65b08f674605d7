"""Solver: what every solver of an `Nlp` offers."""

from collections.abc import Callable
from typing import Protocol, runtime_checkable

from trajopt.arrays import Floats
from trajopt.nlp import Nlp
from trajopt.solvers.result import Iteration, SolveResult

Progress = Callable[[Iteration], None]
"""Called after every step."""


class Solver(Protocol):
    """A solver of an `Nlp`: a frozen value whose fields are its options."""

    @property
    def name(self) -> str:
        """What it is called in reports."""
        ...

    def solve(self, nlp: Nlp, x0: Floats, *, progress: Progress | None = None) -> SolveResult:
        """Minimise from a first guess.

        Args:
            nlp: The program.
            x0: First guess, shape (N, n); clipped to the bounds.
            progress: Called after every step.

        Returns:
            The last point; `feasible` says whether it holds all constraints.
        """
        ...


@runtime_checkable
class HasBriefForm(Protocol):
    """A solver that has a form of few steps."""

    def brief(self) -> Solver:
        """Return the solver with so few steps that they only show whether a first guess is promising."""
        ...
