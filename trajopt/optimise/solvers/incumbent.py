"""The best point so far, so that no solver returns worse than its seed; and the loop that improves it."""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from trajopt.optimise.nlp import Linearisation, Nlp
from trajopt.optimise.solvers.solver import Iteration, Progress, SolveResult, SolverStatus
from trajopt.values.arrays import Floats


def improves(at: Linearisation, on: Linearisation) -> bool:
    """Return whether a point is better than another: feasible first, then by cost, or else by violation."""
    if not finite(at) or not finite(on):
        return finite(at)
    if at.feasible != on.feasible:
        return at.feasible
    if at.feasible:
        return at.cost < on.cost
    return at.violation < on.violation


def finite(at: Linearisation) -> bool:
    """Return whether costs and violations of a point are numbers."""
    return bool(np.isfinite(at.cost + at.violation))


@dataclass(eq=False)
class Incumbent:
    """The best of the offered points; all on the same samples.

    Attributes:
        nlp: The program.
        seed: The seed, within bounds, shape (N, n).
        best: The best point.
    """

    nlp: Nlp
    seed: Floats
    best: Linearisation = field(init=False)

    def __post_init__(self) -> None:
        """Begin with the seed, on coarse samples."""
        self.best = self.nlp.linearise(self.seed, self.nlp.sampling(self.seed, fine=False))

    def offer(self, at: Linearisation) -> None:
        """Take a point if it is better."""
        if improves(at, self.best):
            self.best = at

    def refine(self) -> bool:
        """Evaluate the best point on as many samples as it needs; return whether these are new."""
        needed = np.maximum(self.best.sampling, self.nlp.sampling(self.best.x, fine=True))
        if (needed == self.best.sampling).all():
            return False
        self.best = self.nlp.linearise(self.best.x, needed)
        return True

    def settle(self) -> Linearisation:
        """Return the better of the best point and the seed, compared on equally fine samples."""
        while True:
            self.refine()
            self.offer(self.nlp.linearise(self.seed, self.best.sampling))
            if not self.refine():
                return self.best


Update = Callable[[Linearisation, Incumbent, bool], tuple[Linearisation, bool] | None]
"""Returns the next point and whether it differs from the current one. It offers points to the incumbent, and
receives whether the point was sampled more finely since the last call. None ends the search.
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
        nlp: The program.
        x0: The seed, shape (N, n); clipped to the bounds.
        update: Makes the steps.
        max_iterations: Steps at most.
        after_feasible: Steps after the constraints hold, which may still lower the cost.
        progress: Called after every step.
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
