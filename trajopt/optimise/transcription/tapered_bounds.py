"""Path constraints whose bounds give way near stops that violate the program's narrower bounds.

The program keeps a part of every tolerance in reserve. A start, a goal or a waypoint that lies in that part
holds the requirement, and no path could hold more there: near it the bounds widen to its value.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from trajopt.geometry import Evaluator
from trajopt.optimise.terms import Constraint
from trajopt.optimise.terms.requirement import constrain
from trajopt.optimise.transcription.margins import TAPER_KNOTS
from trajopt.optimise.transcription.motion_nlp import ROUNDING
from trajopt.problem.motion import Motion
from trajopt.problem.requirements import Requirement
from trajopt.problem.residual import Window
from trajopt.values.arrays import Floats, Ints, Rows

USABLE = 0.5
"""Part of the tolerance left at a stop that the program may use up: the rest is for the error of retiming."""
LEAST = 1e-7
"""No tolerance is less: linear programs are solved to a few digits more than that."""


MOST_KEPT = {"m": 0.01, "rad": 0.05}
"""Largest reserve, by unit: retiming first leaves a path by up to 5 mm, which turns a frame by this at a
lever of
a decimetre, and by less if that violates something. A tenth of a wide cone would be far more.
"""


@dataclass(frozen=True, eq=False)
class StopExcess:
    """Excess of a stop over the bounds that the program keeps.

    Attributes:
        place: Its knot.
        below: Of the lower bound, by component; 0 if it is kept, as for components beyond the last one.
        above: Of the upper bound.
    """

    place: int
    below: Floats
    above: Floats


@dataclass(frozen=True, eq=False)
class TaperedConstraint(Constraint):
    """A constraint whose bounds give way near stops.

    Attributes:
        stops: The stops.
    """

    stops: tuple[StopExcess, ...] = ()

    def bounds(self, rows: Rows) -> tuple[Floats, Floats]:
        """Return lower and upper bound of each row, shape (m,)."""
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
        required: The requirement.
        query: Of the reduced model.
        window: Part of the motion in which it must hold.
        places: The stops' knots.
        stops: Configurations there, shape (k, n) [rad | m].
        last: The last knot.
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
    """Return a constraint whose reserve is at most `most`."""
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
    """Return the value of each component, 0 for missing ones."""
    return np.append(values, 0.0)[np.minimum(component, len(values))]
