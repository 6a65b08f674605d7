"""The clearance that the program demands along the motion: never less than the requirement.

Near a fixed start or goal that violates the margin, the margin tapers to the actual
distance: otherwise no motion could hold it. At a goal that leaves a choice, a requested margin
tapers to the distance at the end of the seed. Intended contact is allowed for a time.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from trajopt.geometry import Evaluator
from trajopt.scene.clearances import ROOM
from trajopt.scene.reduced import BodyPairs
from trajopt.scene.scene import DEFAULT_MARGIN
from trajopt.values.arrays import Bools, Floats, Ints, Printed

TAPER_KNOTS = 3.0
"""Knots over which a margin grows from its value at a fixed end to its full size."""
LONG_TAPER = 0.25
"""Part of the motion over which requested margins grow: these may be many times larger than the
travel of a body between two knots. In the middle half of the motion they have their full size.
"""


@dataclass(frozen=True, eq=False)
class TaperedMargins(Printed):
    """A `MarginRule`.

    Attributes:
        pairs: The pairs, with their full margins.
        last: Index of the last knot.
        at_start: Margin of each pair at the start, shape (p,) [m].
        at_end: Margin of each pair at the end, shape (p,) [m].
        contact_until: Knot up to which contact is allowed, shape (p,); -1 for none.
        contact_from: Knot from which contact is allowed, shape (p,); inf for none.
        depth: Penetration accepted there, shape (p,) [m].
    """

    pairs: BodyPairs
    last: float
    at_start: Floats
    at_end: Floats
    contact_until: Floats
    contact_from: Floats
    depth: Floats

    @cached_property
    def taper(self) -> float:
        """Number of knots over which margins grow from their values at a fixed end to their full size."""
        asked_for = bool((~shrinkable(self.pairs)).any())
        return max(TAPER_KNOTS, LONG_TAPER * self.last) if asked_for else TAPER_KNOTS

    def __call__(self, pair: Ints, place: Floats) -> Floats:
        """Return the margin of each pair at each location, in knots, shape (m,) [m]."""
        full = self.pairs.margin[pair]
        since = np.clip((place - np.maximum(self.contact_until[pair], 0.0)) / self.taper, 0.0, 1.0)
        until = np.clip((np.minimum(self.contact_from[pair], self.last) - place) / self.taper, 0.0, 1.0)
        margin = np.minimum(
            self.at_start[pair] + (full - self.at_start[pair]) * since,
            self.at_end[pair] + (full - self.at_end[pair]) * until,
        )
        # After an intended contact the margin grows, but the required clearance holds at once.
        required = self.pairs.required[pair]
        margin = np.where(required > 0.0, np.maximum(margin, required), margin)
        contact = (place <= self.contact_until[pair]) | (place >= self.contact_from[pair])
        return np.where(contact, -self.depth[pair], margin)


@dataclass(frozen=True, eq=False)
class ShrunkMargins(Printed):
    """A `MarginRule` with a share of another rule's margins beyond the requirement.

    Margins that are larger than the default were requested, and stay.

    Attributes:
        margins: The other.
        share: The share, in (0, 1].
    """

    margins: TaperedMargins
    share: float

    def __call__(self, pair: Ints, place: Floats) -> Floats:
        """Return the margin of each pair at each place, shape (m,) [m]."""
        full, required = self.margins(pair, place), self.margins.pairs.required[pair]
        gives = (full > required) & shrinkable(self.margins.pairs)[pair]
        return np.where(gives, required + self.share * (full - required), full)


def shrinkable(pairs: BodyPairs) -> Bools:
    """Return which pairs have the default margin, shape (p,)."""
    return pairs.margin <= np.maximum(DEFAULT_MARGIN, pairs.required + ROOM) * (1.0 + 1e-12)


def tapered_margins(
    query: Evaluator,
    knots: int,
    goal: Floats | None,
    duration: float,
    *,
    end: Floats | None = None,
) -> TaperedMargins:
    """Measure the fixed ends and lay the margins along the motion.

    Args:
        query: Measures them.
        knots: Number of knots.
        goal: The group's positions at a fixed goal, shape (n,); None if the goal is not fixed.
        duration: A cautious (long) estimate of the motion's duration, for contact windows [s].
        end: A possible end of the motion, if the goal is not fixed, shape (n,).
    """
    pairs, last = query.reduced.pairs, float(knots - 1)
    asked_for = ~shrinkable(pairs)

    def available(positions: Floats, reach: Floats = pairs.margin) -> Floats:
        contacts = query.close_pairs(positions[None, :], reach)
        margin = pairs.margin.copy()
        np.minimum.at(margin, contacts.pair, contacts.distance)  # a cloud has several of one pair
        return margin

    if goal is not None:
        at_end = available(goal)
    elif end is not None and asked_for.any():
        at_end = available(end, np.where(asked_for, pairs.margin, -np.inf))
    else:
        at_end = pairs.margin
    count = len(pairs.margin)
    until, since = np.full(count, -1.0), np.full(count, np.inf)
    depth = np.zeros(count)
    for pair, allowance in pairs.allowances:
        # From rest at constant acceleration, a share s = 2 (t/T)^2 of the way is done at time t.
        if allowance.first > 0.0:
            until[pair] = max(until[pair], last * min(2.0 * (allowance.first / duration) ** 2, 1.0))
        if allowance.last > 0.0:
            share = 1.0 - min(2.0 * (allowance.last / duration) ** 2, 1.0)
            since[pair] = min(since[pair], last * share)
        depth[pair] = max(depth[pair], allowance.depth)
    return TaperedMargins(
        pairs,
        last,
        available(query.reduced.start_positions),
        at_end,
        until,
        since,
        depth,
    )
