"""Interface and result of solvers of an `Nlp`, and the incumbent."""

from collections.abc import Callable
from dataclasses import dataclass, field
from enum import Enum
from typing import Protocol, runtime_checkable

import numpy as np

from trajopt.optimise.nlp import Linearisation, Nlp
from trajopt.values.arrays import Floats, Value


class SolverStatus(Enum):
    """How a solver ended."""

    CONVERGED = "constraints hold and no step improves the cost enough"
    MAX_ITERATIONS = "reached its limit of iterations"
    INFEASIBLE_STATIONARY = "no step reduces the violation of constraints: a local minimum of it"
    TRUST_REGION_COLLAPSED = "the trust region shrank to nothing before constraints held"
    QP_FAILED = "the QP backend failed at every step size"
    NON_FINITE = "a residual or its derivative was not a finite number"
    GIVEN_UP = "at the rate of the last steps the constraints would not hold in time"


class Effort(Enum):
    """Work that a solver does for one seed; each value is a description."""

    FULL = "until no step is worth taking"
    TENTATIVE = "given up if the constraints would not hold in time at the rate of the last steps"
    BRIEF = "enough steps to recognise a promising seed"
    NEAR = "less polishing, because the seed solved a similar problem"


@dataclass(frozen=True)
class Iteration:
    """One step of the log.

    Attributes:
        cost: Sum of costs at the current point after the step.
        violation: L1 norm of the violations there.
    """

    cost: float
    violation: float
    accepted: bool


@dataclass(frozen=True)
class SqpStep(Iteration):
    """One step of sequential quadratic programming.

    Attributes:
        merit: Cost plus penalty weight times violation.
        radius: Trust region radius, in units of the program's scale.
        rows: Penalised rows of the QP.
    """

    merit: float
    penalty: float
    radius: float
    rows: int
    backend: str
    qp_iterations: int


@dataclass(frozen=True, eq=False)
class SolveResult(Value):
    """Result of a solver.

    Attributes:
        x: Knots, shape (N, n).
        at: All costs and constraints, linearised there.
    """

    status: SolverStatus
    x: Floats
    at: Linearisation
    log: tuple[Iteration, ...]

    def __repr__(self) -> str:
        at = f"cost {self.at.cost:.4g}, violation {self.at.violation:.2g}"
        return f"{type(self).__name__}({self.status.name}, {len(self.log)} steps, {at})"

    def __str__(self) -> str:
        steps = f"{len(self.log)} steps"
        lines = [f"{self.status.name} after {steps}, cost {self.at.cost:.4g}: {self.status.value}"]
        lines += [f"  {name}: violated by {worst:.2g}" for name, worst in self.violations().items() if worst]
        return "\n".join(lines)

    @property
    def feasible(self) -> bool:
        """Whether every constraint holds within its tolerance."""
        return self.at.feasible

    @property
    def qp_solves(self) -> int:
        """QPs solved."""
        return len(self._steps)

    @property
    def qp_backends(self) -> tuple[str, ...]:
        """Names of the QP backends that were used."""
        return tuple(dict.fromkeys(step.backend for step in self._steps))

    @property
    def qp_iterations(self) -> int:
        """Iterations of the QP backend in total."""
        return sum(step.qp_iterations for step in self._steps)

    @property
    def _steps(self) -> tuple[SqpStep, ...]:
        return tuple(step for step in self.log if isinstance(step, SqpStep))

    def violations(self) -> dict[str, float]:
        """Return the worst violation of each constraint by name."""
        worst: dict[str, float] = {}
        for block in self.at.constraints:
            worst[block.name] = max(worst.get(block.name, 0.0), block.worst)
        return worst


Progress = Callable[[Iteration], None]
"""Called after every step."""


@runtime_checkable
class Patient(Protocol):
    """A `Progress` that accepts a small delay: it may be called for several steps in turn."""

    @property
    def patience(self) -> int | None:
        """Configurations that may be evaluated before it must be called; any number when None."""
        ...

    def __call__(self, iteration: Iteration, /) -> None: ...


class Solver(Protocol):
    """A solver of an `Nlp`: a frozen value whose fields are its options."""

    @property
    def name(self) -> str:
        """Name in reports."""
        ...

    def solve(self, nlp: Nlp, x0: Floats, *, progress: Progress | None = None) -> SolveResult:
        """Minimise from a seed; the last point's `feasible` states whether it holds all constraints.

        Args:
            x0: Seed, shape (N, n); clipped to the bounds.
        """
        ...


@runtime_checkable
class HasEfforts(Protocol):
    """A solver that can do less for a seed."""

    def with_effort(self, effort: Effort) -> Solver:
        """Return the solver with the options for this effort."""
        ...


def improves(at: Linearisation, on: Linearisation) -> bool:
    if not finite(at) or not finite(on):
        return finite(at)
    if at.feasible != on.feasible:
        return at.feasible
    if at.feasible:
        return at.cost < on.cost
    return at.violation < on.violation


def finite(at: Linearisation) -> bool:
    return bool(np.isfinite(at.cost + at.violation))


@dataclass(eq=False)
class Incumbent:
    """The best of the offered points; all on the same samples."""

    nlp: Nlp
    seed: Floats
    best: Linearisation = field(init=False)

    def __post_init__(self) -> None:
        self.best = self.nlp.linearise(self.seed, self.nlp.sampling(self.seed, fine=False))

    def offer(self, at: Linearisation) -> None:
        if improves(at, self.best):
            self.best = at

    def refine(self) -> bool:
        needed = np.maximum(self.best.sampling, self.nlp.sampling(self.best.x, fine=True))
        if (needed == self.best.sampling).all():
            return False
        self.best = self.nlp.linearise(self.best.x, needed)
        return True

    def settle(self) -> Linearisation:
        while True:
            self.refine()
            self.offer(self.nlp.linearise(self.seed, self.best.sampling))
            if not self.refine():
                return self.best


Update = Callable[[Linearisation, Incumbent, bool], tuple[Linearisation, bool] | None]
"""Returns the next point and whether it differs from the current one, given whether the point was sampled
more finely since the last call; offers points to the incumbent. None ends the search.
"""


def improved(
    nlp: Nlp,
    x0: Floats,
    update: Update,
    max_iterations: int,
    after_feasible: int,
    progress: Progress | None,
) -> SolveResult:
    """Improve a seed step by step, and return the best point on samples fine enough.

    Args:
        x0: The seed, shape (N, n); clipped to the bounds.
        after_feasible: Steps after the constraints hold, which may still lower the cost.
    """
    incumbent = Incumbent(nlp, np.clip(x0, nlp.lower, nlp.upper))
    at, log = incumbent.best, list[Iteration]()
    status, spare = SolverStatus.MAX_ITERATIONS, after_feasible
    for _ in range(max_iterations):
        if not finite(at):
            status = SolverStatus.NON_FINITE
            break
        refined = incumbent.best.feasible and incumbent.refine()
        step = update(incumbent.best if refined else at, incumbent, refined)
        if step is None:
            status = SolverStatus.INFEASIBLE_STATIONARY
            break
        at, accepted = step
        log.append(Iteration(at.cost, at.violation, accepted))
        if progress is not None:
            progress(log[-1])
        if incumbent.best.feasible:
            spare -= 1
            if spare < 0 and not incumbent.refine():
                break
    best = incumbent.settle()
    if best.feasible and finite(best):
        status = SolverStatus.CONVERGED
    return SolveResult(status, best.x, best, tuple(log))
