"""Sequential quadratic programming with an L1 merit, a box trust region and penalty rounds.

Source: Nocedal and Wright, Numerical Optimization (2006), algorithm 18.5 and section 17.2; in
motion planning Schulman et al., IJRR 2014, algorithm 1. Costs are Gauss-Newton.
"""

from dataclasses import dataclass, field, replace
from functools import cached_property
from math import ceil

import numpy as np

from trajopt.arrays import Bools, Floats
from trajopt.nlp import Linearisation, Nlp
from trajopt.solvers.choice import AUTO, step_solver
from trajopt.solvers.result import SolveResult, SolverStatus, SqpStep
from trajopt.solvers.solver import Progress
from trajopt.solvers.step import Step, StepProgram, StepSolver
from trajopt.solvers.trust_region import TrustRegion

WIDENED = 0.1
"""After a round, or on finer samples, the trust region is at least this wide."""
FINAL = {SolverStatus.MAX_ITERATIONS, SolverStatus.QP_FAILED, SolverStatus.NON_FINITE}
"""After these no other penalty weight is tried."""
ACCURACY = 0.2
"""How well a step's QP is solved, as a share of the gain that is worth a step."""
QP_FAILURES = 3
"""Failures of the QP backend that smaller steps are tried after."""


def merit(at: Linearisation, penalty: float) -> float:
    """Return cost plus penalty times the L1 norm of the violations."""
    return at.cost + penalty * at.violation


@dataclass(frozen=True)
class Sqp:
    """The solver; its fields are its options.

    Attributes:
        qp: Name of the QP backend; "auto" chooses by the structure of the program.
        penalty: First weight of constraint violations.
        penalty_growth: Factor when constraints do not hold at convergence.
        penalty_rounds: Rounds of growth at most.
        max_iterations: QPs at most; what is not feasible by then rarely will be, and another first
            guess is the better use of the time.
        relative_gain: Converged when a step promises less than this share of the merit.
        absolute_gain: Or less than this.
        trust_region: First trust region, and its rule.
    """

    qp: str = AUTO
    penalty: float = 5.0
    penalty_growth: float = 10.0
    penalty_rounds: int = 4
    max_iterations: int = 30
    relative_gain: float = 5e-3
    absolute_gain: float = 1e-5
    trust_region: TrustRegion = field(default_factory=TrustRegion)

    @property
    def name(self) -> str:
        """What it is called in reports."""
        return "sqp" if self.qp == AUTO else f"sqp-{self.qp}"

    def brief(self) -> "Sqp":
        """Return the solver with a quarter of the steps: by then promising first guesses stand out."""
        return replace(self, max_iterations=ceil(self.max_iterations / 4))

    def solve(self, nlp: Nlp, x0: Floats, *, progress: Progress | None = None) -> SolveResult:
        """Minimise from a first guess.

        Works on coarse samples until the constraints hold there, then on fine ones.

        Args:
            nlp: The program.
            x0: First guess, shape (N, n); clipped to the bounds.
            progress: Called after every step.

        Returns:
            The last point; `feasible` says whether it holds all constraints.

        Raises:
            SolverNotFound: If the QP backend is unknown.
        """
        run = _Run(self, nlp, step_solver(self.qp), progress)
        return run.solve(np.clip(x0, nlp.lower, nlp.upper))


@dataclass(eq=False)
class _Run:
    """One call of the solver: where it is and what it did."""

    options: Sqp
    nlp: Nlp
    steps: StepSolver
    progress: Progress | None
    log: list[SqpStep] = field(default_factory=list[SqpStep])
    failures: int = 0

    @cached_property
    def moves(self) -> Bools:
        """Which variables may change."""
        return self.nlp.lower < self.nlp.upper

    def solve(self, x: Floats) -> SolveResult:
        region, penalty, rounds, fine = self.options.trust_region, self.options.penalty, 0, False
        at = self.nlp.linearise(x, self.nlp.sampling(x, fine=False))
        while True:
            ended, at, region = self._descend(at, region, penalty, fine)
            if at.feasible:
                # Steps are compared on equal samples; whether these are enough is asked where they ended.
                needed = np.maximum(at.sampling, self.nlp.sampling(at.x, fine=True))
                enough = fine and bool((needed == at.sampling).all())
                if (needed > at.sampling).any():
                    at = self.nlp.linearise(at.x, needed)
                if enough or ended in FINAL:
                    status = ended if ended in FINAL else SolverStatus.CONVERGED
                    return SolveResult(status, at.x, at, tuple(self.log))
                fine = True
            elif ended in FINAL:
                return SolveResult(ended, at.x, at, tuple(self.log))
            elif rounds == self.options.penalty_rounds:
                status = (
                    SolverStatus.TRUST_REGION_COLLAPSED
                    if region.collapsed
                    else SolverStatus.INFEASIBLE_STATIONARY
                )
                return SolveResult(status, at.x, at, tuple(self.log))
            else:
                rounds += 1
                penalty *= self.options.penalty_growth
            region = replace(region, radius=max(region.radius, WIDENED))

    def _descend(
        self, at: Linearisation, region: TrustRegion, penalty: float, fine: bool
    ) -> tuple[SolverStatus, Linearisation, TrustRegion]:
        """Reduce the merit with one penalty weight until no step promises enough."""
        program = self.steps.program(self.moves, at, penalty)
        while len(self.log) < self.options.max_iterations:
            now = merit(at, penalty)
            if not np.isfinite(now):
                return SolverStatus.NON_FINITE, at, region
            enough = max(self.options.relative_gain * now, self.options.absolute_gain)
            step = self._step(program, at, region, ACCURACY * enough)
            if step is None:
                self.failures += 1
                if self.failures > QP_FAILURES:
                    return SolverStatus.QP_FAILED, at, region
                region = replace(region, radius=region.radius * region.shrink)
                continue
            if step.promise < enough:
                return SolverStatus.CONVERGED, at, region
            trial = self.nlp.linearise(at.x + step.dx, at.sampling)
            ratio = (now - merit(trial, penalty)) / step.promise
            accepted = region.accepts(ratio)
            region = region.after(ratio)
            at = trial if accepted else at
            self._note(at, penalty, region, accepted, program, step)
            if accepted and at.feasible and not fine:
                return SolverStatus.CONVERGED, at, region
            if region.collapsed:
                return SolverStatus.TRUST_REGION_COLLAPSED, at, region
            if accepted:
                program = self.steps.program(self.moves, at, penalty)
        return SolverStatus.MAX_ITERATIONS, at, region

    def _step(
        self, program: StepProgram, at: Linearisation, region: TrustRegion, accuracy: float
    ) -> Step | None:
        """Return the best step within the trust region and the bounds."""
        box = region.radius * self.nlp.scale
        return program.solve(
            np.maximum(-box, self.nlp.lower - at.x), np.minimum(box, self.nlp.upper - at.x), accuracy
        )

    def _note(
        self,
        at: Linearisation,
        penalty: float,
        region: TrustRegion,
        accepted: bool,
        program: StepProgram,
        step: Step,
    ) -> None:
        entry = SqpStep(
            cost=at.cost,
            violation=at.violation,
            merit=merit(at, penalty),
            penalty=penalty,
            radius=region.radius,
            accepted=accepted,
            rows=program.rows,
            backend=program.backend,
            qp_iterations=step.iterations,
        )
        self.log.append(entry)
        if self.progress is not None:
            self.progress(entry)
