"""Sequential quadratic programming with an L1 merit, a box trust region and penalty rounds.

Source: Nocedal and Wright, Numerical Optimization (2006), algorithm 18.5 and section 17.2; in
motion planning Schulman et al., IJRR 2014, algorithm 1. Costs are Gauss-Newton.
"""

from dataclasses import dataclass, field, replace
from math import ceil

import numpy as np

from trajopt.arrays import Floats
from trajopt.nlp import Linearisation, Nlp
from trajopt.solvers.choice import AUTO, step_solver
from trajopt.solvers.solver import Progress, SolveResult, SolverStatus, SqpStep
from trajopt.solvers.step import Step, StepProgram, StepSolver

WIDENED = 0.1
"""After a round, or on finer samples, the trust region is at least this wide."""
FINAL = {SolverStatus.MAX_ITERATIONS, SolverStatus.QP_FAILED, SolverStatus.NON_FINITE}
"""After these no other penalty weight is tried."""
ACCURACY = 0.2
"""How well a step's QP is solved, as a share of the gain that is worth a step."""
QP_FAILURES = 3
"""Failures of the QP backend that smaller steps are tried after."""


@dataclass(frozen=True)
class TrustRegion:
    """A box around the current point, in units of the program's scale, and the rule that sizes it.

    Attributes:
        radius: Half the edge now.
        smallest: Below this it has collapsed.
        largest: It never grows beyond this.
        accept: A step is taken when it brings at least this share of the predicted improvement.
        good: The box grows when it brings at least this share.
        grow: Factor on growth.
        shrink: Factor on rejection.
    """

    radius: float = 1.0
    smallest: float = 1e-4
    largest: float = 1.0
    accept: float = 0.1
    good: float = 0.5
    grow: float = 2.0
    shrink: float = 0.3

    def accepts(self, ratio: float) -> bool:
        """Say whether a step with this ratio of actual to predicted improvement is taken."""
        return ratio >= self.accept

    def after(self, ratio: float) -> "TrustRegion":
        """Return the region after a step with this ratio of actual to predicted improvement."""
        if not self.accepts(ratio):
            return replace(self, radius=self.radius * self.shrink)
        if ratio >= self.good:
            return replace(self, radius=min(self.radius * self.grow, self.largest))
        return self

    @property
    def collapsed(self) -> bool:
        """Whether no step worth taking is left."""
        return self.radius < self.smallest


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
        max_iterations: QPs at most; what is not feasible by then rarely will be, and another
            seed is the better use of the time.
        relative_gain: Converged when the predicted reduction is below this share of the merit.
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
        """Return the solver with a quarter of the steps: by then promising seeds stand out."""
        return replace(self, max_iterations=ceil(self.max_iterations / 4))

    def solve(self, nlp: Nlp, x0: Floats, *, progress: Progress | None = None) -> SolveResult:
        """Minimise from a seed.

        Works on coarse samples until the constraints hold there, then on fine ones.

        Args:
            nlp: The program.
            x0: Seed, shape (N, n); clipped to the bounds.
            progress: Called after every step.

        Returns:
            The last point; `feasible` says whether it holds all constraints.

        Raises:
            SolverNotFound: If the QP backend is unknown.
        """
        steps = step_solver(self.qp)
        x = np.clip(x0, nlp.lower, nlp.upper)
        at = nlp.linearise(x, nlp.sampling(x, fine=False))
        run = _Run(nlp, steps, progress, at, self.trust_region, self.penalty)
        rounds = 0
        while True:
            status = self._descend(run)
            if run.at.feasible:
                # Steps are compared on equal samples; whether these are enough is checked at the end.
                needed = np.maximum(run.at.sampling, nlp.sampling(run.at.x, fine=True))
                enough = run.fine and bool((needed == run.at.sampling).all())
                if (needed > run.at.sampling).any():
                    run.at = nlp.linearise(run.at.x, needed)
                if status in FINAL:
                    return run.result(status)
                if enough:
                    return run.result(SolverStatus.CONVERGED)
                run.fine = True
            elif status in FINAL:
                return run.result(status)
            elif rounds == self.penalty_rounds:
                collapsed = run.region.collapsed
                return run.result(
                    SolverStatus.TRUST_REGION_COLLAPSED if collapsed else SolverStatus.INFEASIBLE_STATIONARY
                )
            else:
                rounds += 1
                run.penalty *= self.penalty_growth
            run.region = replace(run.region, radius=max(run.region.radius, WIDENED))

    def _descend(self, run: "_Run") -> SolverStatus:
        """Reduce the merit with one penalty weight until no step is predicted to reduce it enough."""
        nlp, moves = run.nlp, run.nlp.lower < run.nlp.upper
        program = run.steps.program(moves, run.at, run.penalty)
        while len(run.log) < self.max_iterations:
            at, region = run.at, run.region
            now = merit(at, run.penalty)
            if not np.isfinite(now):
                return SolverStatus.NON_FINITE
            enough = max(self.relative_gain * now, self.absolute_gain)
            box = region.radius * nlp.scale
            lower, upper = np.maximum(-box, nlp.lower - at.x), np.minimum(box, nlp.upper - at.x)
            step = program.solve(lower, upper, ACCURACY * enough)
            if step is None:
                run.failures += 1
                if run.failures > QP_FAILURES:
                    return SolverStatus.QP_FAILED
                run.region = replace(region, radius=region.radius * region.shrink)
                continue
            if step.predicted_reduction < enough:
                return SolverStatus.CONVERGED
            trial = nlp.linearise(at.x + step.dx, at.sampling)
            ratio = (now - merit(trial, run.penalty)) / step.predicted_reduction
            accepted = region.accepts(ratio)
            run.region = region.after(ratio)
            run.at = trial if accepted else at
            run.note(accepted, program, step)
            if accepted and run.at.feasible and not run.fine:
                return SolverStatus.CONVERGED
            if run.region.collapsed:
                return SolverStatus.TRUST_REGION_COLLAPSED
            if accepted:
                program = run.steps.program(moves, run.at, run.penalty)
        return SolverStatus.MAX_ITERATIONS


@dataclass(eq=False)
class _Run:
    """Where one call of the solver is, and what it has done."""

    nlp: Nlp
    steps: StepSolver
    progress: Progress | None
    at: Linearisation
    region: TrustRegion
    penalty: float
    fine: bool = False
    failures: int = 0
    log: list[SqpStep] = field(default_factory=list[SqpStep])

    def result(self, status: SolverStatus) -> SolveResult:
        return SolveResult(status, self.at.x, self.at, tuple(self.log))

    def note(self, accepted: bool, program: StepProgram, step: Step) -> None:
        entry = SqpStep(
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
        self.log.append(entry)
        if self.progress is not None:
            self.progress(entry)
