"""Sequential quadratic programming with an L1 merit, a box trust region and penalty rounds.

Source: Nocedal and Wright, Numerical Optimization (2006), algorithm 18.5 and section 17.2; in
motion planning Schulman et al., IJRR 2014, algorithm 1. Costs are Gauss-Newton.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from trajopt.arrays import Floats
from trajopt.errors import BackendFailed
from trajopt.nlp import Linearisation, Nlp
from trajopt.solvers.qp import QpBackend, QpStatus, qp_backend
from trajopt.solvers.result import Iteration, SolveResult, SolverStatus
from trajopt.solvers.subproblem import Subproblem, subproblem
from trajopt.solvers.trust_region import TrustRegion

WIDENED = 0.1
"""After a round, or on finer samples, the trust region is at least this wide."""
Progress = Callable[[Iteration], None]


def merit(at: Linearisation, penalty: float) -> float:
    """Return cost plus penalty times the L1 norm of the violations."""
    return at.cost + penalty * at.violation


@dataclass(frozen=True)
class Sqp:
    """The solver; its fields are its options.

    Attributes:
        qp: Name of the QP backend.
        penalty: First weight of constraint violations.
        penalty_growth: Factor when constraints do not hold at convergence.
        penalty_rounds: Rounds of growth at most.
        max_iterations: QPs at most.
        relative_gain: Converged when a step promises less than this share of the merit.
        absolute_gain: Or less than this.
        trust_region: First trust region, and its rule.
    """

    qp: str = "piqp"
    penalty: float = 5.0
    penalty_growth: float = 10.0
    penalty_rounds: int = 4
    max_iterations: int = 100
    relative_gain: float = 2e-3
    absolute_gain: float = 1e-5
    trust_region: TrustRegion = field(default_factory=TrustRegion)

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
        run = _Run(self, nlp, qp_backend(self.qp), progress)
        return run.solve(np.clip(x0, nlp.lower, nlp.upper))


@dataclass(eq=False)
class _Run:
    """One call of the solver: where it is and what it did."""

    options: Sqp
    nlp: Nlp
    backend: QpBackend
    progress: Progress | None
    log: list[Iteration] = field(default_factory=list[Iteration])
    failures: int = 0

    def solve(self, x: Floats) -> SolveResult:
        fine = False
        at = self.nlp.linearise(x, self.nlp.sampling(x, fine=False))
        region, penalty, rounds = self.options.trust_region, self.options.penalty, 0
        while True:
            status, at, region = self._descend(at, region, penalty, fine)
            if status is SolverStatus.NON_FINITE or status is SolverStatus.QP_FAILED:
                return self._result(status, at)
            if at.feasible and not fine:
                fine = True
                at = self.nlp.linearise(at.x, self.nlp.sampling(at.x, fine=True))
                region = self._widened(region)
                continue
            if status is SolverStatus.MAX_ITERATIONS or at.feasible:
                return self._result(
                    SolverStatus.CONVERGED
                    if at.feasible and status is not SolverStatus.MAX_ITERATIONS
                    else status,
                    at,
                )
            rounds += 1
            if rounds > self.options.penalty_rounds:
                return self._result(
                    SolverStatus.INFEASIBLE_STATIONARY if not region.collapsed else status, at
                )
            penalty *= self.options.penalty_growth
            region = self._widened(region)

    def _descend(
        self, at: Linearisation, region: TrustRegion, penalty: float, fine: bool
    ) -> tuple[SolverStatus, Linearisation, TrustRegion]:
        """Reduce the merit with one penalty weight until no step promises enough."""
        model = subproblem(self.nlp, at, penalty)
        while len(self.log) < self.options.max_iterations:
            now = merit(at, penalty)
            if not np.isfinite(now):
                return SolverStatus.NON_FINITE, at, region
            step, promise, iterations = self._step(model, at, region)
            if step is None:
                self.failures += 1
                if self.failures > 3:
                    return SolverStatus.QP_FAILED, at, region
                region = replace(region, radius=region.radius * region.shrink)
                continue
            enough = max(self.options.relative_gain * now, self.options.absolute_gain)
            if promise < enough:
                return SolverStatus.CONVERGED, at, region
            trial = self.nlp.linearise(at.x + step, at.sampling)
            ratio = (now - merit(trial, penalty)) / promise
            accepted = region.accepts(ratio)
            region = region.after(ratio)
            if accepted:
                at = self._resampled(trial, fine)
                model = subproblem(self.nlp, at, penalty)
            self._note(at, penalty, region, accepted, len(model.bound), iterations)
            if accepted and at.feasible and not fine:
                return SolverStatus.CONVERGED, at, region
            if region.collapsed:
                return SolverStatus.TRUST_REGION_COLLAPSED, at, region
        return SolverStatus.MAX_ITERATIONS, at, region

    def _step(
        self, model: Subproblem, at: Linearisation, region: TrustRegion
    ) -> tuple[Floats | None, float, int]:
        """Solve the QP; return the step, the improvement it promises, and iterations used."""
        box = (region.radius * np.broadcast_to(self.nlp.scale, at.x.shape)).ravel()[model.free]
        x = at.x.ravel()[model.free]
        lower = np.maximum(-box, self.nlp.lower.ravel()[model.free] - x)
        upper = np.minimum(box, self.nlp.upper.ravel()[model.free] - x)
        try:
            self.backend.setup(model.qp(lower, upper))
            solution = self.backend.solve()
        except BackendFailed:
            return None, 0.0, 0
        if solution.status is QpStatus.FAILED or not np.isfinite(solution.x).all():
            return None, 0.0, solution.iterations
        reduced = np.clip(solution.x[: len(model.free)], lower, upper)
        promise = model.model(np.zeros_like(reduced)) - model.model(reduced)
        step = np.zeros(at.x.size)
        step[model.free] = reduced
        return step.reshape(at.x.shape), promise, solution.iterations

    def _resampled(self, at: Linearisation, fine: bool) -> Linearisation:
        """Sample anew where the motion now needs more samples than it was compared on."""
        needed = self.nlp.sampling(at.x, fine=fine)
        if (needed <= at.sampling).all():
            return at
        return self.nlp.linearise(at.x, np.maximum(needed, at.sampling))

    def _widened(self, region: TrustRegion) -> TrustRegion:
        return replace(region, radius=max(region.radius, WIDENED))

    def _note(
        self,
        at: Linearisation,
        penalty: float,
        region: TrustRegion,
        accepted: bool,
        rows: int,
        iterations: int,
    ) -> None:
        step = Iteration(
            at.cost, at.violation, merit(at, penalty), penalty, region.radius, accepted, rows, iterations
        )
        self.log.append(step)
        if self.progress is not None:
            self.progress(step)

    def _result(self, status: SolverStatus, at: Linearisation) -> SolveResult:
        return SolveResult(status, at.x, at, tuple(self.log))
