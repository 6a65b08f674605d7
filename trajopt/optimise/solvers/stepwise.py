"""A descent step by step in Python, of any program and with any backend of the QP."""

from dataclasses import dataclass, field

import numpy as np

from trajopt.optimise.nlp import Linearisation
from trajopt.optimise.solvers.descent import ACCURACY, QP_FAILURES, Descent
from trajopt.optimise.solvers.solver import SolverStatus, SqpStep
from trajopt.optimise.solvers.step import Step, StepProgram, StepSolver
from trajopt.values.arrays import Floats, Ints


def merit(at: Linearisation, penalty: float) -> float:
    """Return cost plus penalty times the L1 norm of the violations."""
    return at.cost + penalty * at.violation


@dataclass(eq=False, kw_only=True)
class StepwiseDescent(Descent):
    """See `Descent`.

    Attributes:
        steps: Solves the QPs.
        at: Everything at the current point.
    """

    steps: StepSolver
    at: Linearisation = field(init=False)

    @property
    def x(self) -> Floats:
        """The point, shape (N, n)."""
        return self.at.x

    @property
    def sampling(self) -> Ints:
        """Samples per segment, shape (N - 1,)."""
        return self.at.sampling

    @property
    def feasible(self) -> bool:
        """Whether every constraint holds within its tolerance."""
        return self.at.feasible

    def begin(self, x: Floats, sampling: Ints) -> None:
        """Go to a point, on given samples."""
        self.at = self.nlp.linearise(x, sampling)

    def linearised(self) -> Linearisation:
        """Return everything at the point."""
        return self.at

    def descend(self) -> SolverStatus:
        """Take steps until none is predicted to reduce the merit enough."""
        nlp, moves = self.nlp, self.nlp.lower < self.nlp.upper
        program = self.steps.program(moves, self.at, self.penalty)
        while len(self.log) < self.limits.steps:
            at, region = self.at, self.region
            now = merit(at, self.penalty)
            if not np.isfinite(now):
                return SolverStatus.NON_FINITE
            enough = self.limits.enough(now)
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
            if self.region.collapsed:
                return SolverStatus.TRUST_REGION_COLLAPSED
            if accepted:
                program = self.steps.program(moves, self.at, self.penalty)
        return SolverStatus.MAX_ITERATIONS

    def _entry(self, accepted: bool, program: StepProgram, step: Step) -> SqpStep:
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
