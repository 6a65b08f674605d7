"""CHOMP: covariant Hamiltonian optimisation for motion planning.

Source: Zucker et al., IJRR 32 (2013), 1164-1193; defaults are those of MoveIt's implementation, whose
fixed motion of 3 s and whose metric with a largest inverse entry of 1 are what their sizes refer to.
Where this differs from what is published, and why, is in docs/decisions/chomp-and-stomp.md.
"""

from dataclasses import dataclass

import numpy as np

from trajopt.arrays import Floats
from trajopt.nlp import Linearisation, Loss, Nlp
from trajopt.solvers.incumbent import Incumbent, finite
from trajopt.solvers.obstacle_functional import obstacle_functional
from trajopt.solvers.projection import LinearRows, into_bounds
from trajopt.solvers.result import Iteration, SolveResult, SolverStatus
from trajopt.solvers.smooth_metric import SmoothMetric, smooth_metric
from trajopt.solvers.solver import Progress

MOTION_SECONDS = 3.0
"""Duration that the published weights refer to [s]."""
STILL = 1e-5
"""A step shorter than this, in ordinary steps, changes nothing."""


@dataclass(frozen=True)
class Chomp:
    """The solver; its fields are its options.

    Constraints that list all their rows (poses, tilts, your own) are held by projection; those that are
    listed near their bounds only (clearances) by the obstacle functional.

    Attributes:
        max_iterations: Steps at most.
        after_feasible: Steps after the constraints hold, which may still lower the cost.
        learning_rate: Step along the covariant gradient.
        smoothness_weight: Weight of the costs.
        obstacle_weight: First weight of the obstacle functional.
        weight_growth: Factor on it at every step from a point where something is too near.
        step_limit: Largest change of a knot in a step, in ordinary steps.
    """

    max_iterations: int = 200
    after_feasible: int = 5
    learning_rate: float = 0.01
    smoothness_weight: float = 0.1
    obstacle_weight: float = 1.0
    weight_growth: float = 1.05
    step_limit: float = 0.1

    @property
    def name(self) -> str:
        """What it is called in reports."""
        return "chomp"

    def solve(self, nlp: Nlp, x0: Floats, *, progress: Progress | None = None) -> SolveResult:
        """Minimise from a first guess; see `Solver.solve`.

        Returns:
            The best point met, never worse than the first guess: feasible before infeasible, then by
            cost, or by violation where none was feasible.
        """
        metric = smooth_metric(nlp.lower < nlp.upper, nlp.scale)
        incumbent = Incumbent(nlp, np.clip(x0, nlp.lower, nlp.upper))
        at, log = incumbent.best, list[Iteration]()
        status, weight, spare = SolverStatus.MAX_ITERATIONS, self.obstacle_weight, self.after_feasible
        for _ in range(self.max_iterations):
            if not finite(at):
                status = SolverStatus.NON_FINITE
                break
            if incumbent.best.feasible and incumbent.refine():
                at = incumbent.best
            step = self._step(nlp, at, metric, weight)
            if np.abs(step / nlp.scale).max(initial=0.0) < STILL:
                status = SolverStatus.INFEASIBLE_STATIONARY
                break
            at = nlp.linearise(at.x + step, at.sampling)
            incumbent.offer(at)
            weight *= 1.0 if at.feasible else self.weight_growth
            log.append(Iteration(at.cost, at.violation, accepted=True))
            if progress is not None:
                progress(log[-1])
            if incumbent.best.feasible:
                spare -= 1
                if spare < 0 and not incumbent.refine():
                    break
        found = incumbent.settle()
        if found.feasible and finite(found):
            status = SolverStatus.CONVERGED
        return SolveResult(status, found.x, found, tuple(log))

    def _step(self, nlp: Nlp, at: Linearisation, metric: SmoothMetric, weight: float) -> Floats:
        """Return a covariant step, projected onto constraint rows and between bounds."""
        obstacles = obstacle_functional(at, nlp.scale).gradient * max(len(at.x) - 1, 1) / MOTION_SECONDS
        smoothness = 0.5 * metric.largest * cost_gradient(at)
        slope = self.smoothness_weight * smoothness + weight * obstacles
        step = self._limited(-self.learning_rate * metric.smooth(slope), nlp.scale)
        step = self._limited(LinearRows.around(at, metric).project(step), nlp.scale)
        return into_bounds(at.x + step, nlp.lower, nlp.upper, metric) - at.x

    def _limited(self, step: Floats, scale: Floats) -> Floats:
        longest = float(np.abs(step / scale).max(initial=0.0))
        return step * min(1.0, self.step_limit / max(longest, STILL))


def cost_gradient(at: Linearisation) -> Floats:
    """Return the derivative of the sum of all costs by the knots, shape (N, n)."""
    gradient = np.zeros_like(at.x)
    for block in at.costs:
        value = block.rows.value
        if block.loss is Loss.SQUARED:
            slope = 2.0 * block.weight * value
        elif block.loss is Loss.ABSOLUTE:
            slope = block.weight * np.sign(value)
        else:
            slope = block.weight * (value > 0.0)
        np.add.at(gradient, block.rows.knots, slope[:, None, None] * block.rows.jacobian)
    return gradient
