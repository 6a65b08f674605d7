"""A proof that there is no way from the start to the goal: a cut that no configuration can cross.

A joint that starts on one side of a value and must end on the other has to pass it. If every
configuration with the joint at that value is in collision, whatever all other joints do, nothing passes.
A pair that must keep a clearance c collides, in this sense, where it is nearer than c.
The cut is covered by boxes of configurations. At the middle of each some pair of convex bodies is in
penetration by a depth p; no point of either moves farther than delta while the joints stay in the box; and
bodies whose Minkowski difference holds a ball of radius p around the origin still meet after their points
have moved by less than p, and are nearer than c after less than p + c. So delta < p + c closes a box, where p
is minus the distance of bodies apart; else it is halved, and a middle that is free opens the cut.
Nothing but this is taken for a proof: a cut that stays undecided proves nothing.
Related: Schwarzer, Saha, Latombe, IEEE T-RO 2005 (the same bound, for clearance).
"""

from dataclasses import dataclass

import numpy as np

from trajopt.arrays import Bools, Floats
from trajopt.model.mesh_file import Mesh
from trajopt.model.reduced import ReducedModel
from trajopt.model.requirements import JointPositions
from trajopt.problem import Problem
from trajopt.proofs.chain import Chain
from trajopt.query import query_of

SHARES = (0.5, 0.25, 0.75, 0.125, 0.375, 0.625, 0.875)
"""Where between start and goal each joint is cut."""
MOST_BOXES = 30000
"""Boxes that are looked at, of all cuts together, before the question is left undecided."""
ACCURACY = 1e-4
"""Depth that measurements may be wrong by [m]."""


@dataclass(frozen=True, kw_only=True)
class ClosedCut:
    """A value of a joint that every motion to the goal has to pass, and none can.

    Attributes:
        joint: The joint.
        position: The value [rad | m].
        pairs: Links and objects whose contact, or required clearance, closes the cut, most frequent first.
        boxes: Boxes of configurations that were looked at.
    """

    joint: str
    position: float
    pairs: tuple[tuple[str, str], ...]
    boxes: int


def closed_cut(problem: Problem) -> ClosedCut | None:
    """Look for a cut between the start and a goal of joints that no configuration can cross.

    Returns:
        The first that is proven; None if none is, which says nothing.
    """
    if _endless(problem.reduced).any():
        return None
    cover = _Cover(problem.reduced)
    for joint, (start, goal) in _must_move(problem).items():
        for share in SHARES:
            found = cover.close(joint, start + share * (goal - start))
            if found is not None:
                return found
    return None


def _must_move(problem: Problem) -> dict[int, tuple[float, float]]:
    """Return where joints with a goal of their own begin and where they must come to at least."""
    reduced, found = problem.reduced, dict[int, tuple[float, float]]()
    for goal in problem.goals:
        if isinstance(goal, JointPositions):
            for joint, wanted in goal.positions.items():
                if joint in reduced.joint_names:
                    place = reduced.joint_names.index(joint)
                    begin = float(reduced.start_positions[place])
                    end = float(np.clip(begin, wanted - goal.below[joint], wanted + goal.above[joint]))
                    if end != begin:
                        found[place] = (begin, end)
    return dict(sorted(found.items()))


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


class _Cover:
    """Covers cuts with boxes of configurations, until all are used up."""

    def __init__(self, reduced: ReducedModel) -> None:
        self._reduced, self._query = reduced, query_of(reduced)
        self._levers = _pair_levers(reduced)
        self._required = reduced.pairs.required
        self._reach = np.where(np.isfinite(self._levers).all(axis=1), self._required, -np.inf)
        self._left = MOST_BOXES

    def close(self, joint: int, value: float) -> ClosedCut | None:
        """Halve boxes until all are closed; None once one is open, or there are too many."""
        middle, half = _whole(self._reduced, joint, value)
        closing: dict[tuple[str, str], int] = {}
        seen = 0
        while len(middle) <= self._left:
            if len(middle) == 0:
                ranked = tuple(sorted(closing, key=lambda names: -closing[names]))
                name = self._reduced.joint_names[joint]
                return ClosedCut(joint=name, position=value, pairs=ranked, boxes=seen)
            seen += len(middle)
            self._left -= len(middle)
            contacts = self._query.near(middle, self._reach)
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


def _whole(reduced: ReducedModel, joint: int, value: float) -> tuple[Floats, Floats]:
    """Return middle and half width of the box of all configurations on a cut, shape (1, n) each.

    Joints that turn need no more than one turn.
    """
    limits = reduced.limits
    lower = np.where(np.isfinite(limits.lower), limits.lower, -np.pi)
    upper = np.where(np.isfinite(limits.upper), limits.upper, np.pi)
    middle, half = (lower + upper) / 2.0, (upper - lower) / 2.0
    half = np.where(_periodic(reduced), np.minimum(half, np.pi), half)
    middle[joint], half[joint] = value, 0.0
    return middle[None], half[None]


def _periodic(reduced: ReducedModel) -> Bools:
    """Return which joints of the group have everything where it was after one turn, shape (n,)."""
    names = [reduced.model.joints[reduced.model.getJointId(name)].shortname() for name in reduced.joint_names]
    turns = np.array(["JointModelR" in name for name in names], dtype=np.bool_)
    mimicked = (reduced.mimic_matrix != 0.0).sum(axis=0) > 1
    return turns & ~mimicked


def _endless(reduced: ReducedModel) -> Bools:
    """Return which joints no box of finite size can cover, shape (n,)."""
    limited = np.isfinite(reduced.limits.lower) & np.isfinite(reduced.limits.upper)
    return ~limited & ~_periodic(reduced)


def _halved(middle: Floats, half: Floats, axis: np.ndarray) -> tuple[Floats, Floats]:
    """Halve each box along an axis of its own."""
    rows = np.arange(len(middle))
    narrow = half.copy()
    narrow[rows, axis] /= 2.0
    step = np.zeros_like(half)
    step[rows, axis] = narrow[rows, axis]
    return np.concatenate((middle - step, middle + step)), np.concatenate((narrow, narrow))
