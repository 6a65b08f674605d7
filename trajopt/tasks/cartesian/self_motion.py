"""Look-ahead for an arm with one redundant joint: all that it can reach without a jump, point by point.

At each point of a curve the arm has a self-motion: a line of configurations. All of it that is connected
with the configurations of the point before is walked, to limits and obstacles on both sides, so that no
choice is made too early; then the sequence through them that moves least is taken.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from trajopt.tasks.cartesian.on_curve import OnCurve
from trajopt.tasks.cartesian.tracking import Track
from trajopt.values.arrays import Bools, Floats, Ints

SPACING = 0.12
"""Distance of the configurations that are kept for one point [rad | m]."""
SAME = 0.06
"""Configurations nearer to each other than this in every joint are one [rad | m]."""
STEP = 0.3
"""Farthest that a joint moves from one point to the next without self-motion [rad | m]."""
JOINED = 0.5
"""Farthest that it moves with it [rad | m]."""
MOST = 400
"""Configurations per point at most."""


@dataclass(frozen=True, eq=False)
class SelfMotions:
    """Walks all self-motions along a curve.

    Attributes:
        on_curve: The curve and the arm, with one joint more than the curve fixes.
        margin: Clearance that is kept, of each pair, shape (p,) [m].
    """

    on_curve: OnCurve
    margin: Floats

    def farthest(self, stations: Floats, starts: Floats) -> Track:
        """Return the sequence of least motion to the last point that can be reached.

        Args:
            stations: Lengths along the curve, increasing from 0, shape (m,) [m].
            starts: Configurations to begin in, shape (b, n); they are kept until the second point.
        """
        layers = [starts]
        found = self._spread(starts, float(stations[0]))
        for s in stations[1:].tolist():
            moved = self.on_curve(found, np.full(len(found), s))
            near = np.abs(moved.positions - found).max(axis=1, initial=0.0) <= STEP
            found = self._spread(self._clear(moved.positions[moved.held & near]), s)
            if len(found) == 0:
                break
            layers.append(found)
        return Track(stations[: len(layers)], _least_motion(layers))

    def _clear(self, q: Floats) -> Floats:
        if len(q) == 0:
            return q
        blocked = np.zeros(len(q), dtype=np.bool_)
        blocked[self.on_curve.query.close_pairs(q, self.margin).sample] = True
        return q[~blocked]

    def _spread(self, seeds: Floats, s: float) -> Floats:
        """Walk both ways along the self-motion at a point from all seeds, as far as it is clear."""
        kept = np.empty((0, len(self.on_curve.limits.joint_names)))
        front = _new(seeds, kept)
        while len(front) and len(kept) < MOST:
            kept = np.concatenate((kept, front))
            step = SPACING * self.on_curve.free_direction(front, np.full(len(front), s))
            tried = np.concatenate((front + step, front - step))
            moved = self.on_curve(tried, np.full(len(tried), s))
            near = np.abs(moved.positions - tried).max(axis=1) < 0.5 * SPACING
            front = _new(self._clear(moved.positions[moved.held & near]), kept)
        return kept


def _new(q: Floats, kept: Floats) -> Floats:
    """Return those of q, shape (k, n), that are neither kept already nor twice among them."""
    apart: Bools = ~(np.abs(q[:, None] - kept).max(axis=2, initial=0.0) < SAME).any(axis=1)
    fresh: list[int] = []
    for row in np.flatnonzero(apart):
        if not (np.abs(q[fresh] - q[row]).max(axis=1, initial=0.0) < SAME).any():
            fresh.append(int(row))
    return q[fresh]


def _least_motion(layers: list[Floats]) -> Floats:
    """Choose one configuration of each layer so that the sum of squared steps is least, shape (m, n)."""
    cost, came_from = np.zeros(len(layers[0])), list[Ints]()
    for before, after in pairwise(layers):
        steps = after[None] - before[:, None]
        far = np.abs(steps).max(axis=2) > JOINED
        total = cost[:, None] + (steps**2).sum(axis=2) + np.where(far, 1e6, 0.0)
        came_from.append(total.argmin(axis=0).astype(np.int64))
        cost = total.min(axis=0)
    chosen = [int(cost.argmin())]
    for origins in reversed(came_from):
        chosen.append(int(origins[chosen[-1]]))
    return np.array([layer[row] for layer, row in zip(layers, reversed(chosen), strict=True)])
