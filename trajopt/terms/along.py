"""A user's own constraint along a timed motion, for the judge: called as the object it is."""

from dataclasses import dataclass

import numpy as np

from trajopt.arrays import Floats
from trajopt.query import Query
from trajopt.terms.motion import Motion
from trajopt.terms.residual import END, Constraint


@dataclass(frozen=True, eq=False)
class Along:
    """A constraint as something that can be evaluated at sampled times.

    Attributes:
        item: The constraint.
        query: Evaluates kinematics.
    """

    item: Constraint
    query: Query

    @property
    def name(self) -> str:
        """Name of the residual."""
        return self.item.residual.name

    def evaluate(self, times: Floats, positions: Floats) -> tuple[Floats, Floats, Floats]:
        """Return the violation at each time, and its bounds.

        Args:
            times: Shape (s,) [s].
            positions: The group's, shape (s, n) [rad | m].

        Returns:
            Violation beyond the constraint's bounds, shape (s,), in the residual's unit, the lower
            bound -inf, and the upper bound: the constraint's tolerance.
        """
        count = len(times)
        segment = np.minimum(np.arange(count), count - 2)
        fraction = (np.arange(count) - segment).astype(np.float64)
        motion = Motion.between(positions, segment, fraction, self.query)
        if self.item.window == END:
            motion = motion.where(np.arange(count) == count - 1)
        rows = self.item.residual.linearise(motion)
        lower, upper = self.item.bounds(rows)
        worst = np.zeros(count)
        at = np.minimum(np.floor(rows.place + 1e-9).astype(np.int64), count - 1)
        np.maximum.at(worst, at, np.maximum(lower - rows.value, rows.value - upper))
        return worst, np.full(1, -np.inf), np.full(1, self.item.tolerance)


def judged(items: tuple[Constraint, ...], query: Query) -> tuple[Along, ...]:
    """Return the constraints as what the judge samples."""
    return tuple(Along(item, query) for item in items)
