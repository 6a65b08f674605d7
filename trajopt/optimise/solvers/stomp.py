"""STOMP: stochastic trajectory optimisation for motion planning; it needs no gradient.

Source: Kalakrishnan et al., ICRA 2011, 4569-4574, table I. Roll-outs, noise and cost weight are the defaults
of MoveIt's implementation, the sensitivity is the paper's. Differences: docs/decisions/chomp-and-stomp.md.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from trajopt.optimise.nlp import Linearisation, Nlp
from trajopt.optimise.solvers.covariant import LinearRows, SmoothMetric, into_bounds, smooth_metric
from trajopt.optimise.solvers.solver import Incumbent, Progress, SolveResult, finite, improved, improves
from trajopt.values.arrays import Floats, above_zero, at_least
from trajopt.values.errors.arguments import check_arguments, checked

FINEST_TOLERANCE = 1e-4
"""Violations are counted in tolerances, of this size at least."""


@checked
@dataclass(frozen=True)
class Stomp:
    """The solver; its fields are its options.

    Attributes:
        seed: Of the noise: the same seed gives the same answer.
        after_feasible: Updates after the constraints hold, which may still lower the cost.
        kept: Best roll-outs of the last update that take part in the next.
        noise: Standard deviation at the knot that varies most, in ordinary steps.
        sensitivity: Preference for better roll-outs: h of the paper's eq. 11.
        cost_weight: Weight of the costs relative to violations.
    """

    seed: int = 0
    max_iterations: int = 100
    after_feasible: int = 5
    rollouts: int = 15
    kept: int = 10
    noise: float = 0.1
    sensitivity: float = 10.0
    cost_weight: float = 0.1

    def __post_init__(self) -> None:
        at_least(self, 1, "max_iterations", "rollouts")
        at_least(self, 0, "seed", "after_feasible", "kept", "cost_weight")
        above_zero(self, "noise", "sensitivity")

    @property
    def name(self) -> str:
        return "stomp"

    def solve(self, nlp: Nlp, x0: Floats, *, progress: Progress | None = None) -> SolveResult:
        check_arguments(Stomp.solve, locals())
        metric = smooth_metric(nlp.lower < nlp.upper, nlp.scale)
        run = _Run(self, nlp, metric, np.random.default_rng(self.seed))
        return improved(nlp, x0, run.update, self.max_iterations, self.after_feasible, progress)


@dataclass(eq=False)
class _Run:
    options: Stomp
    nlp: Nlp
    metric: SmoothMetric
    rng: np.random.Generator
    kept: Sequence[Linearisation] = ()

    def update(self, at: Linearisation, incumbent: Incumbent, refined: bool) -> tuple[Linearisation, bool]:
        kept, self.kept = () if refined else self.kept, ()
        options, rows = self.options, LinearRows.around(at, self.metric)
        drawn = [
            self._linearised(at, rows, options.noise * self.metric.draw(self.rng))
            for _ in range(options.rollouts)
        ]
        paths = [path for path in (*kept, *drawn) if finite(path)]
        if not paths:
            return at, False
        costs = np.stack([knot_costs(path, options.cost_weight) for path in paths])
        changes = np.stack([path.x - at.x for path in paths])
        change = np.einsum("kt,ktn->tn", rollout_weights(costs, options.sensitivity), changes)
        moved = self._linearised(at, rows, self.metric.average(change))
        order = np.argsort(costs.sum(axis=1), kind="stable")[: options.kept]
        self.kept = [paths[index] for index in order]
        for path in (*drawn, moved):
            incumbent.offer(path)
        accepted = improves(moved, at)
        return moved if accepted else at, accepted

    def _linearised(self, at: Linearisation, rows: LinearRows, change: Floats) -> Linearisation:
        x = at.x + rows.project(change)
        return self.nlp.linearise(into_bounds(x, self.nlp.lower, self.nlp.upper, self.metric), at.sampling)


def rollout_weights(costs: Floats, sensitivity: float) -> Floats:
    """Return the probability of each roll-out at each knot (eq. 11), shape (K, N); columns sum to 1."""
    least = costs.min(axis=0)
    spread = np.maximum(costs.max(axis=0) - least, 1e-12)
    weights = np.exp(-sensitivity * (costs - least) / spread)
    return weights / weights.sum(axis=0)


def knot_costs(at: Linearisation, cost_weight: float) -> Floats:
    """Return the cost of each knot, shape (N,): violations in tolerances, and weighted costs.

    A row between two knots is shared by both.
    """
    found = np.zeros(len(at.x))
    for block in at.constraints:
        _share(found, block.rows.place, block.violation / max(block.tolerance, FINEST_TOLERANCE))
    for block in at.costs:
        _share(found, block.rows.place, cost_weight * block.each)
    return found


def _share(found: Floats, place: Floats, cost: Floats) -> None:
    first = np.clip(np.floor(place).astype(np.int64), 0, len(found) - 1)
    fraction = np.clip(place - first, 0.0, 1.0)
    np.add.at(found, first, (1.0 - fraction) * cost)
    np.add.at(found, np.minimum(first + 1, len(found) - 1), fraction * cost)
