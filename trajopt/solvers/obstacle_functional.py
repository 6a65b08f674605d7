"""CHOMP's obstacle functional: a potential of the distances, integrated over the length of the path.

F(x) = sum over rows of c(d) |x_{t+1} - x_t| / samples, with the potential (Zucker et al., IJRR 2013, eq. 21)
c(d) = -d + e/2 below 0, (d - e)^2 / 2e up to e, and 0 beyond: d is how far a row is inside its bound, e the
reach to which rows are listed. Lengths are the configurations', in ordinary steps: the solver knows no
workspace. The gradient is that of the sum itself: its second part is what keeps a path from being
stretched or bunched where the potential is high (the projection and curvature terms of eq. 24).
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from trajopt.arrays import Floats
from trajopt.nlp import ConstraintRows, Linearisation
from trajopt.solvers.projection import always_listed

SHORTEST = 1e-9
"""Length of a segment below which it has no direction, in ordinary steps."""


@dataclass(frozen=True, eq=False)
class ObstacleFunctional:
    """Value and gradient of the functional.

    Attributes:
        value: In the rows' unit times ordinary steps.
        gradient: By the knots, shape (N, n).
    """

    value: float
    gradient: Floats


def obstacle_functional(at: Linearisation, scale: Floats) -> ObstacleFunctional:
    """Integrate the potential of all rows that are listed near their bounds only.

    Args:
        at: The point.
        scale: A step of ordinary size, shape (n,).
    """
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
    """Return the potential and its derivative.

    Args:
        inside: How far each row is inside its bound, shape (m,); negative outside.
        reach: From there on the potential is zero, > 0.
    """
    near = np.clip(inside, 0.0, reach)
    potential = np.where(inside < 0.0, -inside + reach / 2.0, (near - reach) ** 2 / (2.0 * reach))
    return potential, np.where(inside < 0.0, -1.0, (near - reach) / reach)


def _sides(block: ConstraintRows) -> Iterator[tuple[Floats, float]]:
    """Yield how far rows are inside each of their bounds, and the sign of its derivative by the row."""
    for inside, sign in ((block.rows.value - block.lower, 1.0), (block.upper - block.rows.value, -1.0)):
        if np.isfinite(inside).any():
            yield inside, sign
