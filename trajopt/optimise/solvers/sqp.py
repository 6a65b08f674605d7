"""Sequential quadratic programming with an L1 merit, a box trust region and penalty rounds.

Source: Nocedal and Wright, Numerical Optimization (2006), algorithm 18.5 and section 17.2; in
motion planning Schulman et al., IJRR 2014, algorithm 1. Costs are Gauss-Newton.
"""

from dataclasses import dataclass, field, replace
from math import ceil

import numpy as np

from trajopt.optimise.nlp import Nlp
from trajopt.optimise.solvers.choice import AUTO, step_solver
from trajopt.optimise.solvers.descent import Descent, DescentLimits, StepwiseDescent, TrustRegion
from trajopt.optimise.solvers.native_descent import native_descent
from trajopt.optimise.solvers.solver import Progress, SolveResult, SolverStatus
from trajopt.values.arrays import Floats, Ints, above_zero, at_least
from trajopt.values.errors.arguments import check_arguments, checked

WIDENED = 0.1
"""After a round, or on finer samples, the trust region is at least this wide."""
NEAR_GAIN = 0.03
"""Relative gain below which a seed that is nearly a solution is left unchanged. Costs are squares of travel:
this share of the cost is half this share, one or two hundredths, of the travel.
"""
FINAL = {SolverStatus.MAX_ITERATIONS, SolverStatus.QP_FAILED, SolverStatus.NON_FINITE}
"""After these no other penalty weight is tried."""


@checked
@dataclass(frozen=True)
class Sqp:
    """The solver; its fields are its options.

    Attributes:
        qp: Name of the QP backend; "auto" chooses by the structure of the program.
        penalty: First weight of constraint violations.
        penalty_growth: Factor when constraints do not hold at convergence.
        penalty_rounds: Largest number of rounds of growth; 0 if the caller has other ways to try.
        max_iterations: Largest number of QPs; a later success is rare, and another seed is the better use
            of the time.
        relative_gain: Converged when the predicted reduction is below this share of the merit.
        absolute_gain: Or below this value.
        until_feasible: Whether any point that holds all constraints suffices, regardless of its cost.
        refines: Whether a point that holds all constraints on few samples has to hold them on many as well;
            if not, the caller checks between the samples.
        fine_first: Whether the first samples have the final density: from a seed that is nearly
            a solution, coarse samples before only cost time.
        trust_region: First trust region, and its rule.
    """

    qp: str = AUTO
    penalty: float = 5.0
    penalty_growth: float = 10.0
    penalty_rounds: int = 4
    max_iterations: int = 30
    relative_gain: float = 5e-3
    absolute_gain: float = 1e-5
    until_feasible: bool = False
    refines: bool = True
    fine_first: bool = False
    trust_region: TrustRegion = field(default_factory=TrustRegion)

    def __post_init__(self) -> None:
        """Check the ranges."""
        above_zero(self, "penalty")
        at_least(self, 1, "penalty_growth", "max_iterations")
        at_least(self, 0, "penalty_rounds", "relative_gain", "absolute_gain")

    @property
    def name(self) -> str:
        """Name in reports."""
        return "sqp" if self.qp == AUTO else f"sqp-{self.qp}"

    def brief(self) -> "Sqp":
        """Return the solver with a quarter of the steps: promising seeds are recognised by then."""
        return replace(self, max_iterations=ceil(self.max_iterations / 4))

    def near(self) -> "Sqp":
        """Return the solver for seeds that are nearly solutions: they are not polished for long."""
        return replace(self, fine_first=True, relative_gain=max(self.relative_gain, NEAR_GAIN))

    def solve(self, nlp: Nlp, x0: Floats, *, progress: Progress | None = None) -> SolveResult:
        """Minimise from a seed.

        Uses coarse samples until the constraints hold there, then fine ones.

        Args:
            nlp: The program.
            x0: Seed, shape (N, n); clipped to the bounds.
            progress: Called after every step.

        Returns:
            The last point; `feasible` tells whether it holds all constraints.

        Raises:
            SolverNotFound: If the QP backend is unknown.
        """
        check_arguments(Sqp.solve, locals())
        x = np.clip(x0, nlp.lower, nlp.upper)
        run = self._begun(nlp, x, nlp.sampling(x, fine=self.fine_first), progress)
        run.fine = self.fine_first and not self.until_feasible
        rounds = 0
        while True:
            status = run.descend()
            if run.feasible:
                # Steps are compared on equal samples; whether these are enough is checked at the end.
                refined = self.refines and run.refine()
                enough = run.feasible if self.until_feasible else run.fine and not refined
                if status in FINAL:
                    return run.result(status)
                if enough:
                    return run.result(SolverStatus.CONVERGED)
                run.fine = not self.until_feasible
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

    def _begun(self, nlp: Nlp, x: Floats, sampling: Ints, progress: Progress | None) -> Descent:
        """Return the descent at the first point: in the core if possible, else in Python."""
        steps = step_solver(self.qp)
        limits = DescentLimits(self.max_iterations, self.relative_gain, self.absolute_gain)
        run = native_descent(self.qp, nlp, sampling, limits, progress, self.trust_region, self.penalty)
        if run is None:
            run = StepwiseDescent(nlp, limits, progress, self.trust_region, self.penalty, steps=steps)
        run.begin(x, sampling)
        return run
