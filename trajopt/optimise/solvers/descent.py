"""Descents of the SQP: steps that reduce cost plus penalty times violation."""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from trajopt.optimise.nlp import Linearisation, Nlp
from trajopt.optimise.solvers.solver import Progress, SolveResult, SolverStatus, SqpStep
from trajopt.optimise.solvers.subproblem import QpStep, StepProgram, StepSolver
from trajopt.values.arrays import Floats, Ints


@dataclass(frozen=True)
class TrustRegion:
    """A box around the current point, in units of the program's scale, and the rule that sizes it.

    Attributes:
        radius: Half the edge.
        accept: Least share of the predicted improvement with which a step is taken.
        good: The box grows from this share on.
    """

    radius: float = 1.0
    smallest: float = 1e-4
    largest: float = 1.0
    accept: float = 0.1
    good: float = 0.5
    grow: float = 2.0
    shrink: float = 0.3

    def accepts(self, ratio: float) -> bool:
        """Return whether a step with this ratio of actual to predicted improvement is taken."""
        return ratio >= self.accept

    def after(self, ratio: float) -> "TrustRegion":
        """Return the region after a step with this ratio of actual to predicted improvement."""
        if not self.accepts(ratio):
            return self.smaller()
        if ratio >= self.good:
            return replace(self, radius=min(self.radius * self.grow, self.largest))
        return self

    def smaller(self) -> "TrustRegion":
        """Return the region after a step not taken."""
        return replace(self, radius=self.radius * self.shrink)

    @property
    def collapsed(self) -> bool:
        """Whether no step worth taking is left."""
        return self.radius < self.smallest


ACCURACY = 0.2
"""Accuracy of a step's QP, as a share of the gain that is worth a step."""
QP_FAILURES = 3
"""Failures of the QP backend after which smaller steps are tried."""


@dataclass(frozen=True)
class DescentLimits:
    """When a descent ends.

    Attributes:
        steps: Steps at most, over all descents of a run.
        relative_gain: Least predicted reduction of the merit by a step, as a share of it.
        window: Last steps, whose rate must make the constraints hold within the steps that are left; None if
            no seed is given up.
    """

    steps: int
    relative_gain: float
    absolute_gain: float
    window: int | None = None

    def enough(self, merit: float) -> float:
        return max(self.relative_gain * merit, self.absolute_gain)

    def hopeless(self, violations: Sequence[float], tolerance: float, left: int) -> bool:
        """Whether the violation would not fall to the tolerance in time, if it fell at the last steps' rate.

        Args:
            violations: After each step on the same samples.
        """
        if self.window is None or len(violations) <= self.window or violations[-1] <= tolerance:
            return False
        now, before = violations[-1], violations[-1 - self.window]
        return bool(now >= before or now * (now / before) ** (left / self.window) > tolerance)


@dataclass(eq=False)
class Descent(ABC):
    """State of one run of the solver.

    Attributes:
        fine: Whether samples have their final density; on coarser ones a descent ends as soon as all
            constraints hold.
        before: Steps on earlier samples.
    """

    nlp: Nlp
    limits: DescentLimits
    progress: Progress | None
    region: TrustRegion
    penalty: float
    fine: bool = False
    failures: int = 0
    log: list[SqpStep] = field(default_factory=list[SqpStep])
    before: int = 0

    @property
    def violations(self) -> list[float]:
        return [step.violation for step in self.log[self.before :]]

    @property
    def left(self) -> int:
        return self.limits.steps - len(self.log)

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

    def refine(self) -> None:
        needed = np.maximum(self.sampling, self.nlp.sampling(self.x, fine=True))
        if (needed > self.sampling).any():
            self.begin(self.x, needed)
            self.before = len(self.log)

    def note(self, entry: SqpStep) -> None:
        self.log.append(entry)
        if self.progress is not None:
            self.progress(entry)

    def result(self, status: SolverStatus) -> SolveResult:
        at = self.linearised()
        return SolveResult(status, at.x, at, tuple(self.log))


def loosest(at: Linearisation) -> float:
    return max((block.tolerance for block in at.constraints), default=0.0)


def merit(at: Linearisation, penalty: float) -> float:
    return at.cost + penalty * at.violation


@dataclass(eq=False, kw_only=True)
class StepwiseDescent(Descent):
    """Steps for any program and backend; see `Descent`."""

    steps: StepSolver
    at: Linearisation = field(init=False)

    @property
    def x(self) -> Floats:
        return self.at.x

    @property
    def sampling(self) -> Ints:
        return self.at.sampling

    @property
    def feasible(self) -> bool:
        return self.at.feasible

    def begin(self, x: Floats, sampling: Ints) -> None:
        self.at = self.nlp.linearise(x, sampling)

    def linearised(self) -> Linearisation:
        return self.at

    def descend(self) -> SolverStatus:
        nlp, limits, moves = self.nlp, self.limits, self.nlp.lower < self.nlp.upper
        program = self.steps.program(moves, self.at, self.penalty)
        while self.left > 0:
            at, region = self.at, self.region
            now = merit(at, self.penalty)
            if not np.isfinite(now):
                return SolverStatus.NON_FINITE
            enough = limits.enough(now)
            box = region.radius * nlp.scale
            lower, upper = np.maximum(-box, nlp.lower - at.x), np.minimum(box, nlp.upper - at.x)
            step = program.solve(lower, upper, ACCURACY * enough)
            if step is None:
                self.failures += 1
                if self.failures > QP_FAILURES:
                    return SolverStatus.QP_FAILED
                self.region = region.smaller()
                continue
            if step.predicted_reduction < enough:
                return SolverStatus.CONVERGED
            trial = nlp.linearise(at.x + step.dx, at.sampling)
            ratio = (now - merit(trial, self.penalty)) / step.predicted_reduction
            accepted = region.accepts(ratio)
            self.region = region.after(ratio)
            self.at = trial if accepted else at
            self.note(self._entry(accepted, program, step))
            if accepted and self.at.feasible and not self.fine:
                return SolverStatus.CONVERGED
            if not self.at.feasible and limits.hopeless(self.violations, loosest(self.at), self.left):
                return SolverStatus.GIVEN_UP
            if self.region.collapsed:
                return SolverStatus.TRUST_REGION_COLLAPSED
            if accepted:
                program = self.steps.program(moves, self.at, self.penalty)
        return SolverStatus.MAX_ITERATIONS

    def _entry(self, accepted: bool, program: StepProgram, step: QpStep) -> SqpStep:
        return SqpStep(
            cost=self.at.cost,
            violation=self.at.violation,
            merit=merit(self.at, self.penalty),
            penalty=self.penalty,
            radius=self.region.radius,
            accepted=accepted,
            rows=program.rows,
            backend=program.backend,
            qp_iterations=step.iterations,
        )
