"""CHOMP: covariant Hamiltonian optimisation for motion planning.

Source: Zucker et al., IJRR 32 (2013), 1164-1193, with the defaults of MoveIt. Differences:
docs/decisions/chomp-and-stomp.md.

The obstacle functional is F(x) = sum over rows of c(d) |x_{t+1} - x_t| / samples, with the potential (eq. 21)
c(d) = -d + e/2 below 0, (d - e)^2 / 2e up to e, and 0 beyond: d is the distance of a row inside its bound, e
the reach to which rows are listed. Lengths are in configuration space, in ordinary steps. The gradient
is exact for the sum (eq. 24).
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from trajopt.optimise.nlp import ConstraintRows, Linearisation, Nlp
from trajopt.optimise.solvers.covariant import (
    LinearRows,
    SmoothMetric,
    always_listed,
    into_bounds,
    smooth_metric,
)
from trajopt.optimise.solvers.solver import Incumbent, Progress, SolveResult, improved
from trajopt.values.arrays import Floats, Loss, above_zero, at_least
from trajopt.values.errors.arguments import check_arguments, checked

MOTION_SECONDS = 3.0
"""Duration that the published weights refer to [s]."""
STILL = 1e-5
"""Smaller steps change nothing [ordinary steps]."""
SHORTEST = 1e-9
"""Shorter segments have no direction [ordinary steps]."""


@checked
@dataclass(frozen=True)
class Chomp:
    """The solver; its fields are its options.

    Constraints that list all their rows (poses, tilts, your own) are held by projection; those that list rows
    near their bounds only (clearances) by the obstacle functional.

    Attributes:
        after_feasible: Steps after the constraints hold, which may still lower the cost.
        learning_rate: Step along the covariant gradient.
        weight_growth: Factor on it after each step to a point that is not feasible.
        step_limit: Largest change of a knot in a step, in units of `Nlp.scale`.
    """

    max_iterations: int = 200
    after_feasible: int = 5
    learning_rate: float = 0.01
    smoothness_weight: float = 0.1
    obstacle_weight: float = 1.0
    weight_growth: float = 1.05
    step_limit: float = 0.1

    def __post_init__(self) -> None:
        at_least(self, 1, "max_iterations", "weight_growth")
        at_least(self, 0, "after_feasible", "smoothness_weight", "obstacle_weight")
        above_zero(self, "learning_rate", "step_limit")

    @property
    def name(self) -> str:
        return "chomp"

    def solve(self, nlp: Nlp, x0: Floats, *, progress: Progress | None = None) -> SolveResult:
        check_arguments(Chomp.solve, locals())
        metric = smooth_metric(nlp.lower < nlp.upper, nlp.scale)
        descent = _Descent(self, nlp, metric, self.obstacle_weight)
        return improved(nlp, x0, descent.update, self.max_iterations, self.after_feasible, progress)


@dataclass(eq=False)
class _Descent:
    options: Chomp
    nlp: Nlp
    metric: SmoothMetric
    weight: float

    def update(self, at: Linearisation, incumbent: Incumbent, _: bool) -> tuple[Linearisation, bool] | None:
        step = self._step(at)
        if np.abs(step / self.nlp.scale).max(initial=0.0) < STILL:
            return None
        at = self.nlp.linearise(at.x + step, at.sampling)
        incumbent.offer(at)
        self.weight *= 1.0 if at.feasible else self.options.weight_growth
        return at, True

    def _step(self, at: Linearisation) -> Floats:
        options, nlp, metric = self.options, self.nlp, self.metric
        obstacles = obstacle_functional(at, nlp.scale).gradient * max(len(at.x) - 1, 1) / MOTION_SECONDS
        smoothness = 0.5 * metric.largest * cost_gradient(at)
        slope = options.smoothness_weight * smoothness + self.weight * obstacles
        step = self._limited(-options.learning_rate * metric.smooth(slope))
        step = self._limited(LinearRows.around(at, metric).project(step))
        return into_bounds(at.x + step, nlp.lower, nlp.upper, metric) - at.x

    def _limited(self, step: Floats) -> Floats:
        longest = float(np.abs(step / self.nlp.scale).max(initial=0.0))
        return step * min(1.0, self.options.step_limit / max(longest, STILL))


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


@dataclass(frozen=True, eq=False)
class ObstacleFunctional:
    """Value, in the rows' unit times ordinary steps, and gradient by the knots, shape (N, n)."""

    value: float
    gradient: Floats


def obstacle_functional(at: Linearisation, scale: Floats) -> ObstacleFunctional:
    """Integrate the potential of all rows listed near their bounds only."""
    value, gradient = 0.0, np.zeros_like(at.x)
    moves = np.diff(at.x, axis=0) / scale
    lengths = np.linalg.norm(moves, axis=1)
    directions = moves / np.maximum(lengths, SHORTEST)[:, None] / scale
    segments = len(lengths)
    for block in at.constraints:
        if always_listed(block) or not len(block.lower) or not segments:
            continue
        rows = block.rows
        segment = np.clip(np.floor(rows.place + 1e-9).astype(np.int64), 0, segments - 1)
        share = 1.0 / at.sampling[segment]
        length = lengths[segment]
        for inside, sign in _sides(block):
            potential, slope = obstacle_potential(inside, block.reach)
            value += float((potential * share) @ length)
            rate = (sign * slope * share * length)[:, None, None] * rows.jacobian
            np.add.at(gradient, rows.knots, rate)
            pull = (potential * share)[:, None] * directions[segment]
            np.add.at(gradient, segment + 1, pull)
            np.add.at(gradient, segment, -pull)
    return ObstacleFunctional(value, gradient)


def obstacle_potential(inside: Floats, reach: float) -> tuple[Floats, Floats]:
    """Return the potential and its derivative at distances inside the bound (m,), negative outside."""
    near = np.clip(inside, 0.0, reach)
    potential = np.where(inside < 0.0, -inside + reach / 2.0, (near - reach) ** 2 / (2.0 * reach))
    return potential, np.where(inside < 0.0, -1.0, (near - reach) / reach)


def _sides(block: ConstraintRows) -> Iterator[tuple[Floats, float]]:
    for inside, sign in ((block.rows.value - block.lower, 1.0), (block.upper - block.rows.value, -1.0)):
        if np.isfinite(inside).any():
            yield inside, sign
