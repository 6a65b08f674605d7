"""Smooth projection of a step: onto linearised constraint rows, and between bounds.

Source: Zucker et al., CHOMP, IJRR 2013, section 4 (constraints) and section 3.3 (joint limits).
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from trajopt.optimise.nlp import ConstraintRows, Linearisation
from trajopt.optimise.solvers.smooth_metric import SmoothMetric
from trajopt.values.arrays import Bools, Floats

ROUNDS = 6
"""Number of checks of a corrected step for newly violated rows and bounds."""
DAMPING = 1e-6
"""Added to the diagonal, relative to its mean: rows may be dependent."""


def always_listed(block: ConstraintRows) -> bool:
    """Return whether a constraint has all its rows at every point; others are fields, known near bounds."""
    return not np.isfinite(block.reach)


@dataclass(frozen=True, eq=False)
class LinearRows:
    """Constraint rows around a point, as one dense matrix: lower <= value + matrix . step <= upper.

    Attributes:
        matrix: By the flattened knots, shape (m, N n).
        smoothed: The metric's inverse times every row, shape (m, N n).
        value: Shape (m,).
        lower: Shape (m,).
        upper: Shape (m,).
    """

    matrix: Floats
    smoothed: Floats
    value: Floats
    lower: Floats
    upper: Floats

    @staticmethod
    def around(at: Linearisation, metric: SmoothMetric) -> "LinearRows":
        """Collect the rows of every constraint that lists all of them."""
        blocks = [block for block in at.constraints if always_listed(block) and len(block.rows.value)]
        matrix = np.zeros((sum(len(block.lower) for block in blocks), *at.x.shape))
        first = 0
        for block in blocks:
            rows = block.rows
            index = first + np.arange(len(rows.value))[:, None]
            np.add.at(matrix, (index, rows.knots), rows.jacobian)
            first += len(rows.value)
        value, lower, upper = (
            np.concatenate([np.zeros(0), *parts])
            for parts in (
                [block.rows.value for block in blocks],
                [block.lower for block in blocks],
                [block.upper for block in blocks],
            )
        )
        smoothed = np.einsum("nts,msn->mtn", metric.inverse, matrix)
        flat = (len(value), at.x.size)
        return LinearRows(matrix.reshape(flat), smoothed.reshape(flat), value, lower, upper)

    def project(self, step: Floats) -> Floats:
        """Return the step nearest in the metric that holds the rows it would break, shape (N, n).

        step + M C' (C M C')^-1 (b - C step) with M the inverse of the metric, C the rows that the step
        breaks and b the change they need. A row within its bounds is left alone.
        """
        held: Bools = np.zeros(len(self.value), dtype=np.bool_)
        moved = step.ravel()
        for _ in range(ROUNDS):
            lack = self._lack(moved)
            broken = np.abs(lack) > 1e-9
            if not (broken & ~held).any():
                break
            held |= broken
            moved = moved + self._correction(held, lack)
        return moved.reshape(step.shape)

    def _lack(self, step: Floats) -> Floats:
        """Return the distance of each row outside its bounds after a step of shape (N n,), shape (m,)."""
        predicted = self.value + self.matrix @ step
        return np.clip(predicted, self.lower, self.upper) - predicted

    def _correction(self, held: Bools, lack: Floats) -> Floats:
        """Return the smallest change in the metric that closes the lack of the held rows, shape (N n,)."""
        product = self._product[np.ix_(held, held)]
        damping = DAMPING * float(np.diagonal(product).mean()) + 1e-12
        multipliers = np.linalg.solve(product + damping * np.eye(len(product)), lack[held])
        return multipliers @ self.smoothed[held]

    @cached_property
    def _product(self) -> Floats:
        """Every row times the metric's inverse times every row, shape (m, m)."""
        return self.matrix @ self.smoothed.T


def into_bounds(x: Floats, lower: Floats, upper: Floats, metric: SmoothMetric) -> Floats:
    """Bend knots back between their bounds, smoothly, then clip the small rest.

    In every joint the excess is smoothed by the metric and scaled to remove the largest excess.

    Args:
        x: Knots, shape (N, n).
        lower: Lower bounds, shape (N, n).
        upper: Upper bounds, shape (N, n).
        metric: Defines smoothness.
    """
    joints = np.arange(x.shape[1], dtype=np.int64)
    bent: Floats = x
    for _ in range(ROUNDS):
        excess = np.clip(bent, lower, upper) - bent
        worst = np.abs(excess).argmax(axis=0)
        bend = metric.smooth(excess)
        most, there = excess[worst, joints], bend[worst, joints]
        usable = np.abs(there) > 1e-12
        if not (usable & (np.abs(most) > 1e-9)).any():
            break
        bent = bent + bend * np.where(usable, most / np.where(usable, there, 1.0), 0.0)
    return np.clip(bent, lower, upper)
