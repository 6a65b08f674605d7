"""A descent of the SQP: steps that reduce cost plus penalty times violation, and what is kept between two.

There are two ways to take the same steps: `StepwiseDescent` for any program and any backend, and
`NativeDescent` in one call of the core, for programs that need no Python.
"""

from abc import ABC, abstractmethod
from dataclasses import dataclass, field

import numpy as np

from trajopt.optimise.nlp import Linearisation, Nlp
from trajopt.optimise.solvers.solver import Progress, SolveResult, SolverStatus, SqpStep
from trajopt.optimise.solvers.trust_region import TrustRegion
from trajopt.values.arrays import Floats, Ints

ACCURACY = 0.2
"""How well a step's QP is solved, as a share of the gain that is worth a step."""
QP_FAILURES = 3
"""Failures of the QP backend that smaller steps are tried after."""


@dataclass(frozen=True)
class Limits:
    """When a descent ends.

    Attributes:
        steps: Steps at most, over all descents of a run.
        relative_gain: A step must be predicted to reduce the merit by this share of it.
        absolute_gain: And by this much.
    """

    steps: int
    relative_gain: float
    absolute_gain: float

    def enough(self, merit: float) -> float:
        """Return the least reduction of a merit that is worth a step."""
        return max(self.relative_gain * merit, self.absolute_gain)


@dataclass(eq=False)
class Descent(ABC):
    """Where one run of the solver is, and what it has done.

    Attributes:
        nlp: The program.
        limits: When a descent ends.
        progress: Called after every step.
        region: The trust region now.
        penalty: Weight of violations now.
        fine: Whether samples are as fine as they must be in the end; until then a descent ends where all
            constraints hold.
        failures: Of the QP backend, so far.
        log: Every step.
    """

    nlp: Nlp
    limits: Limits
    progress: Progress | None
    region: TrustRegion
    penalty: float
    fine: bool = False
    failures: int = 0
    log: list[SqpStep] = field(default_factory=list[SqpStep])

    @property
    @abstractmethod
    def x(self) -> Floats:
        """The point, shape (N, n)."""

    @property
    @abstractmethod
    def sampling(self) -> Ints:
        """Samples per segment, shape (N - 1,)."""

    @property
    @abstractmethod
    def feasible(self) -> bool:
        """Whether every constraint holds within its tolerance."""

    @abstractmethod
    def begin(self, x: Floats, sampling: Ints) -> None:
        """Go to a point, on given samples."""

    @abstractmethod
    def descend(self) -> SolverStatus:
        """Take steps until none is predicted to reduce the merit enough."""

    @abstractmethod
    def linearised(self) -> Linearisation:
        """Return everything at the point."""

    def refine(self) -> bool:
        """Evaluate the point on as many samples as it needs; return whether these are more than before."""
        needed = np.maximum(self.sampling, self.nlp.sampling(self.x, fine=True))
        if (needed == self.sampling).all():
            return False
        self.begin(self.x, needed)
        return True

    def note(self, entry: SqpStep) -> None:
        """Log a step and tell of it."""
        self.log.append(entry)
        if self.progress is not None:
            self.progress(entry)

    def result(self, status: SolverStatus) -> SolveResult:
        """Return what the solver came to."""
        at = self.linearised()
        return SolveResult(status, at.x, at, tuple(self.log))
