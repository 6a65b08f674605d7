"""When contact of a pair is accepted: the first or last seconds of a motion."""

import numpy as np

from trajopt.arrays import Bools, Floats, Ints
from trajopt.model.reduced import BodyPairs


class Windows:
    """The allowances of meant contact, laid out by pair.

    Where several allowances name one pair the longest window counts, with the smallest depth.

    Attributes:
        required: Clearance that pairs must keep outside of them, shape (p,) [m].
        edges: Times at which a window opens or closes, inside the motion [s].
    """

    def __init__(self, pairs: BodyPairs, duration: float) -> None:
        """Lay the allowances out for a motion of a duration [s]."""
        count = len(pairs.first)
        self.required = pairs.required
        self._until: Floats = np.full(count, -np.inf)
        self._from: Floats = np.full(count, np.inf)
        self._first_depth: Floats = np.full(count, np.inf)
        self._last_depth: Floats = np.full(count, np.inf)
        for pair, allowance in pairs.allowances:
            if allowance.first > 0.0:
                self._until[pair] = max(self._until[pair], allowance.first)
                self._first_depth[pair] = min(self._first_depth[pair], allowance.depth)
            if allowance.last > 0.0:
                self._from[pair] = min(self._from[pair], duration - allowance.last)
                self._last_depth[pair] = min(self._last_depth[pair], allowance.depth)
        edges = np.concatenate((self._until, self._from))
        self.edges: Floats = np.unique(edges[(edges > 0.0) & (edges < duration)])

    def rows(self, pair: Ints) -> Floats:
        """Return when windows of pairs end and begin, and the depths accepted in them.

        Args:
            pair: Shape (i,).

        Returns:
            End of the first window, start of the last, depth in the first and in the last, shape (i, 4).
        """
        columns = (self._until, self._from, self._first_depth, self._last_depth)
        return np.stack([column[pair] for column in columns], axis=1)

    def accept(self, time: Floats, pair: Ints) -> Bools:
        """Say whether contact of pairs is accepted at times, both of shape (i,)."""
        return (time <= self._until[pair]) | (time >= self._from[pair])
