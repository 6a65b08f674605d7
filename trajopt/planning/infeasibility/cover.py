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

from trajopt.geometry import Counts, Query
from trajopt.planning.infeasibility.chain import Chain
from trajopt.scene.reduced import ReducedModel
from trajopt.values.arrays import Bools, Floats
from trajopt.values.shapes.mesh_file import Mesh

ACCURACY = 1e-4
"""By how much measured depths may be wrong [m]."""


@dataclass(frozen=True)
class Closed:
    """A box of configurations that are all in collision, or nearer to something than is required.

    Attributes:
        pairs: Links and objects whose contact, or required clearance, closes it, most frequent first.
        boxes: Boxes that were examined.
        farthest: At the middles of these the nearest of the pairs were apart by no more than this [m].
    """

    pairs: tuple[tuple[str, str], ...]
    boxes: int
    farthest: float


class Cover:
    """Covers boxes with smaller ones, until all are used up.

    Attributes:
        left: Boxes that may still be examined.
    """

    def __init__(
        self, reduced: ReducedModel, most: int, apart: Floats | None = None, counts: Counts | None = None
    ) -> None:
        """Bound how far bodies move.

        Args:
            reduced: The robot and its surroundings.
            most: Boxes that are examined, in all calls together, before a question is left undecided.
            apart: Distance below which pairs count as in collision, shape (p,) [m], -inf for those that
                never do; what is required of them when None.
            counts: Takes the work done.
        """
        self._reduced, self._query = reduced, Query(reduced, counts)
        self._levers = pair_levers(reduced)
        self._required = reduced.pairs.required if apart is None else apart
        self._reach = np.where(np.isfinite(self._levers).all(axis=1), self._required, -np.inf)
        self.left = most

    def close(self, middle: Floats, half: Floats) -> Closed | None:
        """Halve a box until all parts are closed; None once one is open, or there are too many.

        Args:
            middle: Shape (n,) [rad | m].
            half: Half its widths, shape (n,) [rad | m].
        """
        middle, half = middle[None], half[None]
        closing: dict[tuple[str, str], int] = {}
        seen, farthest = 0, -np.inf
        while len(middle) <= self.left:
            if len(middle) == 0:
                return Closed(tuple(sorted(closing, key=lambda names: -closing[names])), seen, farthest)
            seen += len(middle)
            self.left -= len(middle)
            contacts = self._query.close_pairs(middle, self._reach)
            nearest = np.full(len(middle), np.inf)
            np.minimum.at(nearest, contacts.sample, contacts.distance)
            farthest = max(farthest, float(nearest.max()))
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


def pair_levers(reduced: ReducedModel) -> Floats:
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


def whole_range(reduced: ReducedModel) -> tuple[Floats, Floats]:
    """Return middle and half width of the box of all configurations, shape (n,) each.

    Joints that turn need no more than one turn; others without limits are in no box (`endless`).
    """
    limits = reduced.limits
    lower = np.where(np.isfinite(limits.lower), limits.lower, -np.pi)
    upper = np.where(np.isfinite(limits.upper), limits.upper, np.pi)
    middle, half = (lower + upper) / 2.0, (upper - lower) / 2.0
    return middle, np.where(_periodic(reduced), np.minimum(half, np.pi), half)


def endless(reduced: ReducedModel) -> Bools:
    """Return which joints no box of finite size can cover, shape (n,)."""
    limited = np.isfinite(reduced.limits.lower) & np.isfinite(reduced.limits.upper)
    return ~limited & ~_periodic(reduced)


def _periodic(reduced: ReducedModel) -> Bools:
    """Return which joints of the group have everything where it was after one turn, shape (n,)."""
    names = [reduced.model.joints[reduced.model.getJointId(name)].shortname() for name in reduced.joint_names]
    turns = np.array(["JointModelR" in name for name in names], dtype=np.bool_)
    mimicked = (reduced.mimic_matrix != 0.0).sum(axis=0) > 1
    return turns & ~mimicked
