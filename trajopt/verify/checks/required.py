"""Checks of goals, constraints, waypoints and user code."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np

from trajopt.problem.requirement import During, Requirement
from trajopt.values.arrays import Floats
from trajopt.values.errors import ShapeError, WaypointNotFound, shown
from trajopt.values.printed import in_unit
from trajopt.verify.certificate import Check, CheckKind, Evidence
from trajopt.verify.checks.quantities import Quantity, When, check_requirement, quantities
from trajopt.verify.kernel.motion import JudgedMotion, sampled_times
from trajopt.verify.specification import Criterion, SampledCheck, Specification

_ZOOMS = 8
_PIECES = 16
_BLOCK = 1024
"""Samples examined at a time: most waypoints are passed soon after their predecessors."""


@dataclass(frozen=True, eq=False)
class Passage:
    """Moment at which a motion passes a waypoint.

    Attributes:
        check: Check of the waypoint; None if the waypoint holds at any moment.
        time: The moment, or the nearest one if there is none [s].
    """

    check: Check | None
    time: float

    @property
    def holds(self) -> bool:
        return self.check is None or self.check.holds


def passages(
    motion: JudgedMotion,
    waypoints: Mapping[str, Sequence[Requirement]],
    partial: Sequence[During[Requirement]] = (),
) -> Iterator[tuple[str, Passage]]:
    """Check waypoints up to the first missed: each holds at some moment, not before its predecessor.

    Requirements on a part of the motion must also hold at the moments of its ends.
    """
    if not waypoints:
        return
    earliest, times = 0.0, sampled_times(motion)
    for name, wanted in waypoints.items():
        bounding = [part.required for part in partial if name in (part.after, part.until)]
        numbers = [item for requirement in (*wanted, *bounding) for item in quantities(requirement, motion)]
        # A line of sight past nothing holds at any moment.
        passage = Passage(None, earliest)
        if numbers:
            moments = np.append(earliest, times[times > earliest])
            passage = _passed(motion, f"waypoint {name}", numbers, moments)
        yield name, passage
        if not passage.holds:
            return
        earliest = passage.time


def _passed(motion: JudgedMotion, name: str, numbers: Sequence[Quantity], times: Floats) -> Passage:
    def excesses(times: Floats) -> Floats:
        return np.array([item.excess(item.states(times)) for item in numbers])

    def worst(times: Floats) -> Floats:
        return excesses(times).max(axis=0)

    accepted = motion.options.excess
    entered = _passage(worst, times, accepted)
    time = _deepest(worst, np.append(entered, times[times > entered]), accepted)
    now = np.array((time,))
    over = excesses(now)[:, 0]
    tightest = numbers[int(over.argmax())]
    excess = float(over.max())
    holds = excess <= accepted
    missed = f"the nearest moment from {times[0]:.3f} s on is {time:.3f} s"
    missed += f", and misses {tightest.name} by {in_unit(excess, tightest.unit)}"
    check = Check(
        name=f"{name}: {tightest.kind}",
        subject=tightest.subject,
        value=float(tightest.number(tightest.states(now))[0]),
        bound=tightest.limit,
        unit=tightest.unit,
        time=time,
        slack=-excess,
        evidence=Evidence.PROVEN if holds else Evidence.SAMPLED,
        holds=holds,
        detail=f"passed at {time:.3f} s" if holds else missed,
    )
    return Passage(check, time)


def _deepest(excess: Callable[[Floats], Floats], times: Floats, accepted: float) -> float:
    """Return the moment of largest margin in the accepted stretch at the first time, or that if it has none.

    From a moment at which it barely holds, a requirement is hard to prove.
    """
    values = np.empty(0)
    while len(values) < len(times) and (values <= accepted).all():
        values = np.append(values, excess(times[len(values) : len(values) + _BLOCK]))
    left = np.flatnonzero(values > accepted)
    stretch = values[: int(left[0])] if len(left) else values
    if not len(stretch):
        return float(times[0])
    place = int(stretch.argmin())
    begin, end = float(times[max(place - 1, 0)]), float(times[min(place + 1, len(times) - 1)])
    for _ in range(_ZOOMS):
        finer = np.linspace(begin, end, _PIECES + 1)
        at = int(excess(finer).argmin())
        begin, end = float(finer[max(at - 1, 0)]), float(finer[min(at + 1, _PIECES)])
    middle = (begin + end) / 2.0
    return middle if float(excess(np.array((middle,)))[0]) <= values[place] else float(times[place])


def _passage(excess: Callable[[Floats], Floats], times: Floats, accepted: float) -> float:
    """Return the first accepted moment, or the nearest one if there is none."""
    nearest, when = np.inf, float(times[0])
    for first in range(0, len(times), _BLOCK):
        begin = max(first - 1, 0)
        values = excess(times[begin : first + _BLOCK + 1])
        padded = np.concatenate(([np.inf], values, [np.inf]))
        lowest = (values <= padded[:-2]) & (values <= padded[2:])
        places = begin + np.flatnonzero(lowest | (values <= accepted))
        places = places[(places >= first) & (places < first + _BLOCK)]
        accepted_samples = np.flatnonzero(values[places - begin] <= accepted)
        for some in filter(len, np.split(places, accepted_samples + 1)):
            low, high = times[np.maximum(some - 1, 0)], times[np.minimum(some + 1, len(times) - 1)]
            found, moments = _zoom(excess, low, high, accepted)
            best = int((found <= accepted).argmax() if found.min() <= accepted else found.argmin())
            if found[best] < nearest:
                nearest, when = float(found[best]), float(moments[best])
            if nearest <= accepted:
                return when
    return when


def _zoom(
    excess: Callable[[Floats], Floats], low: Floats, high: Floats, accepted: float
) -> tuple[Floats, Floats]:
    """Return the least excess in each interval, or the first one accepted, and its moment, both (k,)."""
    rows, best, when = np.arange(len(low)), np.full(len(low), np.inf), low
    for _ in range(_ZOOMS):
        times = low[:, None] + (high - low)[:, None] / _PIECES * np.arange(_PIECES + 1)
        times[:, -1] = high
        values = excess(times.ravel()).reshape(times.shape)
        held = values <= accepted
        place = np.where(held.any(axis=1), held.argmax(axis=1), values.argmin(axis=1))
        best, when = values[rows, place], times[rows, place]
        # The entry lies before the first moment that holds; a minimum on either side.
        low = times[rows, np.maximum(place - 1, 0)]
        high = np.where(held.any(axis=1), when, times[rows, np.minimum(place + 1, _PIECES)])
    return best, when


Required = TypeVar("Required")
_SHORTEST = 1e-6
"""Duration examined for a part whose two ends coincide [s]."""


def part_checks(
    part: During[Required],
    motion: JudgedMotion,
    passed: Mapping[str, Passage],
    check: Callable[[Required, JudgedMotion], tuple[Check, ...]],
) -> tuple[Check, ...]:
    """Check a requirement between two stops, from the moments at which they are passed."""
    held = {None, *(name for name, passage in passed.items() if passage.holds)}
    missed = [name for name in (part.after, part.until) if name not in held]
    if missed:
        return (
            Check(
                name=f"path: {part.part}",
                subject="",
                value=None,
                bound=None,
                unit="",
                time=None,
                slack=None,
                evidence=Evidence.SAMPLED,
                holds=False,
                detail=f"waypoint {missed[0]} is not passed",
            ),
        )
    begin = 0.0 if part.after is None else passed[part.after].time
    end = motion.duration if part.until is None else passed[part.until].time
    begin = min(begin, motion.duration - _SHORTEST)
    end = max(end, begin + _SHORTEST)
    return tuple(
        replace(
            item,
            name=f"{item.name} {part.part}",
            time=None if item.time is None else item.time + begin,
            detail=f"{item.detail} (times from {begin:.3f} s on)",
        )
        for item in check(part.required, motion.between(begin, end))
    )


def sampled_check(check: SampledCheck, motion: JudgedMotion) -> Check:
    """Judge a constraint in user code at samples."""
    times = sampled_times(motion)
    returned = check.evaluate(times, motion.trajectory(times))
    try:
        values, lower, upper = (np.asarray(part, dtype=np.float64) for part in returned)
        rows = values.reshape(len(times), -1)
        low, high = (np.broadcast_to(bound, values.shape).reshape(len(times), -1) for bound in (lower, upper))
    except (TypeError, ValueError) as error:
        raise ShapeError(f"values of {shown(check.name)}", f"do not fit {len(times)} samples") from error
    excess = np.maximum(rows - high, low - rows)
    excess = np.where(np.isnan(excess), np.inf, excess)
    row, column = np.unravel_index(int(excess.argmax()), excess.shape)
    above = rows[row, column] - high[row, column] >= low[row, column] - rows[row, column]
    bound = float((high if above else low)[row, column])
    worst = float(excess[row, column])
    return Check(
        kind=CheckKind.USER_CODE,
        name=f"path: {check.name}",
        subject=f"row {column}" if rows.shape[1] > 1 else "",
        value=float(rows[row, column]),
        bound=bound if np.isfinite(bound) else None,
        unit="",
        time=float(times[row]),
        slack=-worst if np.isfinite(worst) else None,
        evidence=Evidence.SAMPLED,
        holds=worst <= motion.options.excess,
        detail=f"user code, {len(times)} samples",
    )


@dataclass(frozen=True, eq=False)
class RequirementCriterion(Criterion):
    """Static goals, constraints, waypoints and requirements between them.

    Attributes:
        followed: Moving goals, which are judged among dynamic obstacles.
    """

    motion: JudgedMotion
    specification: Specification
    followed: Sequence[Requirement]

    def measure(self) -> Iterator[Check]:
        motion, specification = self.motion, self.specification
        still = [goal for goal in specification.goals if not any(goal is each for each in self.followed)]
        for when, requirements in ((When.END, still), (When.ALWAYS, specification.constraints)):
            for requirement in requirements:
                yield from check_requirement(requirement, motion, when)
        yield from _on_the_way(motion, specification.waypoints, specification.partial)
        for check in specification.sampled:
            yield sampled_check(check, motion)


def _on_the_way(
    motion: JudgedMotion,
    waypoints: Mapping[str, Sequence[Requirement]],
    partial: Sequence[During[Requirement] | During[SampledCheck]],
) -> Iterator[Check]:
    proven: list[During[Requirement]] = []
    sampled: list[During[SampledCheck]] = []
    for part in partial:
        for name in (part.after, part.until):
            if name is not None and name not in waypoints:
                raise WaypointNotFound("waypoint", name, waypoints)
        if isinstance(part.required, Requirement):
            proven.append(During(part.required, part.after, part.until))
        else:
            sampled.append(During(part.required, part.after, part.until))
    passed: dict[str, Passage] = {}
    for name, passage in passages(motion, waypoints, proven):
        passed[name] = passage
        if passage.check is not None:
            yield passage.check
    for part in proven:
        yield from part_checks(part, motion, passed, _always)
    for part in sampled:
        yield from part_checks(part, motion, passed, lambda check, cut: (sampled_check(check, cut),))


def _always(requirement: Requirement, motion: JudgedMotion) -> tuple[Check, ...]:
    return check_requirement(requirement, motion, When.ALWAYS)
