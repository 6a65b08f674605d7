"""Smooth steps of CHOMP and STOMP: their metric, and their projection onto rows and bounds."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from trajopt.optimise.nlp import ConstraintRows, Linearisation
from trajopt.values.arrays import Bools, Floats

ORDER = 2
"""Order of the differences: acceleration, as published."""
RIDGE = 1e-6
"""Added to the diagonal: without any fixed knot, A alone would not be invertible."""


@dataclass(frozen=True, eq=False)
class SmoothMetric:
    """The inverse of A over the free knots, for each joint, with its largest entry scaled to 1.

    A = K'K with K the second differences of the knots, at rest before the first and after the last. Its
    inverse spreads a change of one knot smoothly (Zucker et al., CHOMP, IJRR 2013, section 3.1; Kalakrishnan
    et al., STOMP, ICRA 2011, section II).

    Attributes:
        inverse: Shape (n, N, N); zero for fixed knots; in squares of ordinary steps.
        largest: The largest entry of A's inverse before scaling.
    """

    inverse: Floats
    largest: float

    def smooth(self, change: Floats) -> Floats:
        return np.einsum("nts,sn->tn", self.inverse, change)

    def average(self, change: Floats) -> Floats:
        """Smooth with the matrix M of Kalakrishnan et al., ICRA 2011, table I."""
        peaks = self.inverse.max(axis=1, keepdims=True)
        columns = np.divide(self.inverse, peaks, out=np.zeros_like(self.inverse), where=peaks > 0.0)
        return np.einsum("nts,sn->tn", columns / len(change), change)

    @cached_property
    def root(self) -> Floats:
        """Matrices whose products with their transposes are the inverse, shape (n, N, N)."""
        values, vectors = np.linalg.eigh(self.inverse)
        return vectors * np.sqrt(np.maximum(values, 0.0))[:, None, :]

    def draw(self, rng: np.random.Generator) -> Floats:
        """Return smooth noise of one ordinary step at the knot that varies most, shape (N, n)."""
        count, knots = self.inverse.shape[:2]
        return np.einsum("nts,sn->tn", self.root, rng.standard_normal((knots, count)))


def smooth_metric(moves: Bools, scale: Floats) -> SmoothMetric:
    """Build the metric of a program; `moves` marks the variables that may change, shape (N, n)."""
    knots, joints = moves.shape
    padded = np.eye(knots)[np.clip(np.arange(-1, knots + 1, dtype=np.int64), 0, knots - 1)]
    differences = np.diff(padded, n=ORDER, axis=0)
    product = differences.T @ differences + RIDGE * np.eye(knots)
    inverse = np.zeros((joints, knots, knots))
    for joint in range(joints):
        free = np.flatnonzero(moves[:, joint])
        inverse[joint][np.ix_(free, free)] = np.linalg.inv(product[np.ix_(free, free)])
    largest = float(inverse.max(initial=0.0)) or 1.0
    return SmoothMetric(inverse / largest * (scale**2)[:, None, None], largest)


ROUNDS = 6
"""Checks of a corrected step for newly violated rows and bounds."""
DAMPING = 1e-6
"""Added to the diagonal, relative to its mean: rows may be dependent."""


def always_listed(block: ConstraintRows) -> bool:
    """Return whether a constraint has all its rows at every point; others only near their bounds."""
    return not np.isfinite(block.reach)


@dataclass(frozen=True, eq=False)
class LinearRows:
    """Constraint rows around a point, as one dense matrix: lower <= value + matrix . step <= upper.

    Source: Zucker et al., CHOMP, IJRR 2013, section 4.

    Attributes:
        matrix: By the flattened knots, shape (m, N n).
        smoothed: The metric's inverse times every row, shape (m, N n).
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
            predicted = self.value + self.matrix @ moved
            lack = np.clip(predicted, self.lower, self.upper) - predicted
            broken = np.abs(lack) > 1e-9
            if not (broken & ~held).any():
                break
            held |= broken
            moved = moved + self._correction(held, lack)
        return moved.reshape(step.shape)

    def _correction(self, held: Bools, lack: Floats) -> Floats:
        product = self._product[np.ix_(held, held)]
        damping = DAMPING * float(np.diagonal(product).mean()) + 1e-12
        multipliers = np.linalg.solve(product + damping * np.eye(len(product)), lack[held])
        return multipliers @ self.smoothed[held]

    @cached_property
    def _product(self) -> Floats:
        return self.matrix @ self.smoothed.T


def into_bounds(x: Floats, lower: Floats, upper: Floats, metric: SmoothMetric) -> Floats:
    """Bend knots (N, n) back between their bounds, smoothly, then clip the small rest.

    In every joint the excess is smoothed by the metric and scaled to remove the largest. Source: Zucker et
    al., CHOMP, IJRR 2013, section 3.3.
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
