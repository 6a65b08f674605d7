"""The metric of smooth changes: the preconditioner of covariant descent and the precision of noise.

A = K'K with K the second differences of the knots, at rest before the first and after the last. Its inverse
spreads a change of one knot smoothly over its neighbours (Zucker et al., CHOMP, IJRR 2013, section 3.1;
Kalakrishnan et al., STOMP, ICRA 2011, section II).
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from trajopt.values.arrays import Bools, Floats

ORDER = 2
"""Of the differences: acceleration, as published."""
RIDGE = 1e-6
"""Added to the diagonal: without any fixed knot, A alone would not be invertible."""


@dataclass(frozen=True, eq=False)
class SmoothMetric:
    """The inverse of A over the free knots, for each joint, with its largest entry scaled to 1.

    Attributes:
        inverse: Shape (n, N, N); zero for fixed knots; in squares of ordinary steps.
        largest: The largest entry of A's inverse before scaling.
    """

    inverse: Floats
    largest: float

    def smooth(self, change: Floats) -> Floats:
        """Return the inverse times a change or gradient of the knots, shape (N, n)."""
        return np.einsum("nts,sn->tn", self.inverse, change)

    def average(self, change: Floats) -> Floats:
        """Return a change smoothed: every column of the inverse scaled to a largest entry of 1/N.

        Source: Kalakrishnan et al., ICRA 2011, table I (the matrix M).

        Args:
            change: Shape (N, n).
        """
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
    """Build the metric of a program.

    Args:
        moves: Which variables may change, shape (N, n).
        scale: A step of ordinary size, shape (n,).
    """
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
