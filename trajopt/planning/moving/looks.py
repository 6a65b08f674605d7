"""Looks: whether configurations at times keep clear of what changes, by the optimiser's distances."""

from dataclasses import dataclass, field
from functools import cached_property
from math import ceil, inf, log2
from typing import NamedTuple

import numpy as np

from trajopt.geometry import Query, WorkCounts
from trajopt.scene.timed import ChangingPairs, TimedModel
from trajopt.values.arrays import Bools, Floats, Ints

LOOK = 0.02
"""Time between two looks along a motion [s]: at 1 m/s things move by 2 cm, as between samples of a path."""
ROOM = 2e-3
"""Clearance that is kept above what is required, for what is between the looks [m]; of a pair that has less
at the start, half of what it has there."""


AT_ONCE = 500
"""Configurations looked at at once: what is measured of each pair at all of them is held in memory."""


class SampledClearance(NamedTuple):
    """What was seen at s configurations, each over an interval of time.

    Attributes:
        near: Whether something that changes is too near, there and then, shape (s,).
        within: Whether something would be too near if it came nearer by the interval's travel, shape (s,).
        throughout: Whether something stays too near even if it went away by that travel, shape (s,).
        pair: The pair that is too near, or -1, shape (s,).
    """

    near: Bools
    within: Bools
    throughout: Bools
    pair: Ints


@dataclass(eq=False)
class Looks:
    """Looks at configurations among what changes; one for each thread.

    Attributes:
        timed: The model among what changes.
        counts: The work done so far.
    """

    timed: TimedModel
    counts: WorkCounts
    _room: Floats = field(default_factory=lambda: np.zeros(0))
    _start: Floats | None = None

    def leave_room(self, start: Floats) -> None:
        """Note how much room each pair is to keep, by what it has where the motion begins, (1, n)."""
        if self._start is not None and np.array_equal(start, self._start):
            return
        self._start = start
        known = self._pairs
        self._room = np.full(len(known.required), ROOM)
        reach = np.where(known.changes, known.required + known.error_at(0.0, slice(None)) + ROOM, -inf)
        found = self.query.close_pairs(self.timed.positions(start, np.zeros(1)), reach)
        spare = found.distance - known.required[found.pair] - known.error_at(0.0, found.pair)
        self._room[found.pair] = np.clip(spare / 2.0, 0.0, ROOM)

    def near(self, positions: Floats, times: Floats) -> Bools:
        """Say whether something is too near at configurations (s, n) at times (s,), shape (s,)."""
        return self.seen(positions, times, np.zeros((len(times), 2)), np.zeros(len(times))).near

    def seen(self, positions: Floats, times: Floats, around: Floats, travel: Floats) -> SampledClearance:
        """Look at configurations, each for an interval of time around the look.

        Args:
            positions: Shape (s, n) [rad | m].
            times: When they are looked at, shape (s,) [s].
            around: How far the interval reaches before and after, shape (s, 2) [s].
            travel: How much nearer to each other a pair may be elsewhere in it, shape (s,) [m].
        """
        cuts = range(AT_ONCE, len(times), AT_ONCE)
        parts = zip(*(np.split(each, cuts) for each in (positions, times, around, travel)), strict=True)
        seen = [self._seen(*part) for part in parts]
        return (
            seen[0]
            if len(seen) == 1
            else SampledClearance(*(np.concatenate(rows) for rows in zip(*seen, strict=True)))
        )

    def _seen(self, positions: Floats, times: Floats, around: Floats, travel: Floats) -> SampledClearance:
        """Look at not too many configurations at once; as `seen`."""
        known, count = self._pairs, len(times)
        least = known.required + self._room
        latest, widest = times + around[:, 1], _rounded(float(travel.max(initial=0.0)))
        # Distances of interest change seldom, so that bounds of the last look hold for the next.
        farthest = known.error_at(_rounded(max(float(latest.max(initial=0.0)), LOOK)), slice(None))
        reach = np.where(known.changes, least + farthest + widest, -inf)
        found = self.query.close_pairs(self.timed.positions(positions, times), reach)
        sample, pair = found.sample, found.pair
        spare = found.distance - least[pair]
        first, last = (times - around[:, 0])[sample], latest[sample]
        met = (last >= known.appears[pair]) & (first <= known.expires[pair])
        always = (first >= known.appears[pair]) & (last <= known.expires[pair])
        near = met & (spare < known.error_at(last, pair))
        within = met & (spare < known.error_at(last, pair) + travel[sample])
        deep = always & (spare < known.error_at(np.maximum(first, 0.0), pair) - travel[sample])
        which = np.full(count, -1, dtype=np.int64)
        nearest_last = np.argsort(-spare[near])
        which[sample[near][nearest_last]] = pair[near][nearest_last]
        return SampledClearance(
            _any(count, sample[near]), _any(count, sample[within]), _any(count, sample[deep]), which
        )

    def mover(self, pair: int) -> str:
        """Return what of a pair changes with time."""
        return next(name for name in self.timed.reduced.owners(pair) if name in self.timed.timings)

    @cached_property
    def moments(self) -> Floats:
        """When things appear and expire [s]."""
        both = [time for timing in self.timed.timings.values() for time in (timing.appears, timing.expires)]
        return np.array([time for time in both if 0.0 < time < inf])

    @cached_property
    def settled(self) -> float:
        """When everything has come to rest, appeared and expired [s]."""
        times = [0.0]
        for timing in self.timed.timings.values():
            ends = (timing.appears, timing.expires, 0.0 if timing.motion is None else timing.motion.track.end)
            times.append(max(time for time in ends if time < inf))
        return max(times) + LOOK

    @cached_property
    def query(self) -> Query:
        """What measures."""
        return Query(self.timed.reduced, self.counts)

    @cached_property
    def _pairs(self) -> ChangingPairs:
        return ChangingPairs.of(self.timed)


def _any(count: int, which: Ints) -> Bools:
    """Return what is true of some of so many samples."""
    found = np.zeros(count, dtype=np.bool_)
    found[which] = True
    return found


def _rounded(value: float) -> float:
    """Return the next power of two, or 0."""
    return 2.0 ** ceil(log2(value)) if value > 0.0 else 0.0
