"""A proof that every configuration of a box is in collision: smaller boxes cover it, and each is closed.

At the middle of a box some pair of convex bodies is in penetration by a depth p; no point of either moves
farther than delta while the joints stay in the box; and bodies whose Minkowski difference holds a ball of
radius p around the origin still meet after their points have moved by less than p, and are nearer than a
required clearance c after less than p + c. So delta < p + c closes a box, where p is minus the distance of
bodies apart; else it is halved, and a middle that is free opens the whole. Nothing else counts as a
proof: a box that stays undecided proves nothing.
Related: Schwarzer, Saha, Latombe, IEEE T-RO 2005 (the same bound, for clearance).
"""

from dataclasses import dataclass

import numpy as np

from trajopt.arrays import Bools, Floats
from trajopt.infeasibility.chain import Chain
from trajopt.model.meshes.mesh_file import Mesh
from trajopt.model.reduced import ReducedModel
from trajopt.query import Query

ACCURACY = 1e-4
"""By how much measured depths may be wrong [m]."""


@dataclass(frozen=True)
class Closed:
    """A box of configurations that are all in collision, or nearer to something than is required.

    Attributes:
        pairs: Links and objects whose contact, or required clearance, closes it, most frequent first.
        boxes: Boxes that were examined.
    """

    pairs: tuple[tuple[str, str], ...]
    boxes: int


class Cover:
    """Covers boxes with smaller ones, until all are used up."""

    def __init__(self, reduced: ReducedModel, most: int) -> None:
        """Bound how far bodies move.

        Args:
            reduced: The robot and its surroundings.
            most: Boxes that are examined, in all calls together, before a question is left undecided.
        """
        self._reduced, self._query = reduced, Query(reduced)
        self._levers = _pair_levers(reduced)
        self._required = reduced.pairs.required
        self._reach = np.where(np.isfinite(self._levers).all(axis=1), self._required, -np.inf)
        self._left = most

    def close(self, middle: Floats, half: Floats) -> Closed | None:
        """Halve a box until all parts are closed; None once one is open, or there are too many.

        Args:
            middle: Shape (n,) [rad | m].
            half: Half its widths, shape (n,) [rad | m].
        """
        middle, half = middle[None], half[None]
        closing: dict[tuple[str, str], int] = {}
        seen = 0
        while len(middle) <= self._left:
            if len(middle) == 0:
                return Closed(tuple(sorted(closing, key=lambda names: -closing[names])), seen)
            seen += len(middle)
            self._left -= len(middle)
            contacts = self._query.close_pairs(middle, self._reach)
            travel = np.einsum("mn,mn->m", self._levers[contacts.pair], half[contacts.sample])
            spare = self._required[contacts.pair] - contacts.distance - ACCURACY - travel
            order = np.argsort(-spare, kind="stable")
            samples, first = np.unique(contacts.sample[order], return_index=True)
            if len(samples) < len(middle):
                return None
            best = order[first]
            for row in best[spare[best] > 0.0].tolist():
                names = self._reduced.owners(int(contacts.pair[row]))
                closing[names] = closing.get(names, 0) + 1
            undecided: Bools = spare[best] <= 0.0
            share = (self._levers[contacts.pair[best]] * half)[undecided]
            middle, half = _halved(middle[undecided], half[undecided], share.argmax(axis=1))
        return None


def _pair_levers(reduced: ReducedModel) -> Floats:
    """Bound how far the bodies of each pair move towards each other by joint, (p, n); inf for no proof."""
    chain, pairs = Chain(reduced), reduced.pairs
    levers = np.array([chain.levers(body) for body in range(len(reduced.bodies))])
    total = levers[pairs.first] + levers[pairs.second]
    meant = [pair for pair, _ in pairs.allowances]
    hollow = np.array([isinstance(body.shape, Mesh) for body in reduced.bodies], dtype=np.bool_)
    total[hollow[pairs.first] | hollow[pairs.second]] = np.inf
    total[meant] = np.inf
    return total


def _halved(middle: Floats, half: Floats, axis: np.ndarray) -> tuple[Floats, Floats]:
    """Halve each box along an axis of its own."""
    rows = np.arange(len(middle))
    narrow = half.copy()
    narrow[rows, axis] /= 2.0
    step = np.zeros_like(half)
    step[rows, axis] = narrow[rows, axis]
    return np.concatenate((middle - step, middle + step)), np.concatenate((narrow, narrow))
