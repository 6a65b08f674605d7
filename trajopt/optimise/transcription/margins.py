"""The clearance that the program demands along the motion: never less than the requirement.

Near a fixed start or goal that violates the margin, the margin tapers to the actual distance; at a goal that
leaves a choice, a requested margin tapers to the distance at the end of the seed.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from trajopt.geometry import Evaluator
from trajopt.optimise.terms import Constraint
from trajopt.optimise.terms.requirement import constrain
from trajopt.optimise.transcription.motion_nlp import ROUNDING
from trajopt.problem.motion import Motion
from trajopt.problem.requirements import Requirement
from trajopt.problem.residual import Window
from trajopt.scene.clearances import ROOM
from trajopt.scene.reduced import BodyPairs
from trajopt.scene.scene import DEFAULT_MARGIN
from trajopt.values.arrays import Bools, Floats, Ints, Printed, Rows

TAPER_KNOTS = 3.0
"""Knots over which a margin grows from its value at a fixed end to its full size."""
LONG_TAPER = 0.25
"""Part of the motion over which requested margins grow: full size in its middle half."""


@dataclass(frozen=True, eq=False)
class TaperedMargins(Printed):
    """A `MarginRule`.

    Attributes:
        at_start: Margin of each pair at the start, shape (p,) [m].
        at_end: At the end, shape (p,) [m].
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
        """Number of knots over which margins grow from a fixed end to their full size."""
        asked_for = bool((~shrinkable(self.pairs)).any())
        return max(TAPER_KNOTS, LONG_TAPER * self.last) if asked_for else TAPER_KNOTS

    def __call__(self, pair: Ints, place: Floats) -> Floats:
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

    Margins larger than the default were requested, and stay.
    """

    margins: TaperedMargins
    share: float

    def __call__(self, pair: Ints, place: Floats) -> Floats:
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
        goal: Fixed goal, shape (n,) [rad | m]; None if the goal is not fixed.
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


USABLE = 0.5
"""Part of the tolerance left at a stop that the program may use: the rest is for the error of retiming."""
LEAST = 1e-7
"""Least tolerance: linear programs are solved to a few digits more."""


MOST_KEPT = {"m": 0.01, "rad": 0.05}
"""Largest reserve, by unit: retiming leaves a path by up to 5 mm, which turns a frame by this at a lever
of a decimetre.
"""


@dataclass(frozen=True, eq=False)
class StopExcess:
    """Excess of a stop over the bounds that the program keeps.

    Attributes:
        below: Of the lower bound, by component; 0 if kept, as for components beyond the last one.
    """

    place: int
    below: Floats
    above: Floats


@dataclass(frozen=True, eq=False)
class TaperedConstraint(Constraint):
    """A constraint whose bounds give way near stops.

    The program keeps a part of every tolerance in reserve. Near a start, goal or waypoint that lies in that
    part the bounds widen to its value: no path could hold more there.
    """

    stops: tuple[StopExcess, ...] = ()

    def bounds(self, rows: Rows) -> tuple[Floats, Floats]:
        lower, upper = super().bounds(rows)
        for stop in self.stops:
            near = np.clip(1.0 - np.abs(rows.place - stop.place) / TAPER_KNOTS, 0.0, 1.0)
            lower = np.minimum(lower, lower - near * _of(stop.below, rows.component))
            upper = np.maximum(upper, upper + near * _of(stop.above, rows.component))
        return lower, upper


def tapered(
    required: Requirement, query: Evaluator, window: Window, places: Sequence[int], stops: Floats, last: int
) -> tuple[Constraint, ...]:
    """Return a path constraint as terms that every stop holds if it holds the requirement.

    Args:
        stops: Configurations there, shape (k, n) [rad | m].
    """
    reduced = query.reduced
    kept = constrain(required, reduced, window)
    inside = [
        (place, Motion.single(positions, query))
        for place, positions in zip(places, stops, strict=True)
        if window.first * last - ROUNDING <= place <= window.last * last + ROUNDING
    ]
    asked = constrain(required, reduced, window, inset=0.0)
    most = max((MOST_KEPT.get(unit, np.inf) for unit in required.units), default=np.inf)
    both = zip(kept, asked, strict=True)
    return tuple(_tapered(_no_more_kept(item, whole, most), whole, inside) for item, whole in both)


def _no_more_kept(item: Constraint, whole: Constraint, most: float) -> Constraint:
    with np.errstate(invalid="ignore"):  # infinite bounds keep nothing
        low, high = np.maximum(item.lower - whole.lower, 0.0), np.maximum(whole.upper - item.upper, 0.0)
    wide = np.nanmax(np.concatenate((low, high)), initial=0.0)
    if wide <= most:
        return item
    lower = np.where(low > most, whole.lower + most, item.lower)
    upper = np.where(high > most, whole.upper - most, item.upper)
    return replace(item, lower=lower, upper=upper, tolerance=min(item.tolerance, USABLE * most))


def _tapered(item: Constraint, whole: Constraint, stops: Sequence[tuple[int, Motion]]) -> Constraint:
    found: list[StopExcess] = []
    room = np.inf
    for place, motion in stops:
        rows = item.residual.linearise(motion)
        low, high = item.bounds(rows)
        lowest, highest = whole.bounds(rows)
        outside = (rows.value < low) | (rows.value > high)
        missed = np.maximum(lowest - rows.value, rows.value - highest)
        if not outside.any() or (missed > LEAST).any():
            continue
        below, above = (np.zeros(int(rows.component.max()) + 1) for _ in "lu")
        np.maximum.at(below, rows.component, low - rows.value)
        np.maximum.at(above, rows.component, rows.value - high)
        found.append(StopExcess(place, below, above))
        room = min(room, float(np.minimum(rows.value - lowest, highest - rows.value)[outside].min()))
    if not found:
        return item
    tolerance = min(item.tolerance, max(USABLE * room, LEAST))
    return TaperedConstraint(
        item.residual, item.lower, item.upper, tolerance, item.window, item.reach, tuple(found)
    )


def _of(values: Floats, component: Ints) -> Floats:
    return np.append(values, 0.0)[np.minimum(component, len(values))]
