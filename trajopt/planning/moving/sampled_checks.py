"""Sampled collision checks: whether configurations at times keep clear of dynamic obstacles."""

from dataclasses import dataclass, field
from functools import cached_property
from math import ceil, log2
from typing import NamedTuple

import numpy as np

from trajopt.geometry import DynamicObstacles
from trajopt.values.arrays import Bools, Floats, Ints

INTERVAL = 0.02
"""Time between two checks along a motion [s]: at 1 m/s obstacles move by 2 cm in it."""
MARGIN = 2e-3
"""Clearance kept above the required one, as a reserve between checks [m]; pairs with less excess at the start
keep half of that.
"""
BATCH = 500
"""Configurations checked together, to bound the memory for distances."""


class SampledClearance(NamedTuple):
    """Checks of s configurations, each for an interval of time.

    Attributes:
        near: Whether an obstacle is too near at that very time, shape (s,).
        within: Whether one would be too near if it came nearer by the interval's travel, shape (s,).
        throughout: Whether one stays too near even if it moved away by that travel, shape (s,).
    """

    near: Bools
    within: Bools
    throughout: Bools
    pair: Ints


@dataclass(eq=False)
class SampledChecks:
    """Checks configurations for dynamic obstacles; one for each thread."""

    obstacles: DynamicObstacles
    _kept: Floats = field(default_factory=lambda: np.zeros(0))
    _start: Floats | None = None

    def start_at(self, start: Floats) -> None:
        """Choose the clearance that pairs keep, by their clearance where the motion begins, (1, n)."""
        if self._start is not None and np.array_equal(start, self._start):
            return
        self._start = start
        required = self.obstacles.required()
        margin = np.full(len(required), MARGIN)
        found = self.obstacles.contacts(start, np.zeros(1), required, within=MARGIN)
        margin[found.pair] = np.clip(found.least_spare / 2.0, 0.0, MARGIN)
        self._kept = required + margin

    def near(self, positions: Floats, times: Floats) -> Bools:
        """Return whether an obstacle is too near at configurations (s, n) at times (s,), shape (s,)."""
        return self.check(positions, times, np.zeros((len(times), 2)), np.zeros(len(times))).near

    def check(self, positions: Floats, times: Floats, around: Floats, travel: Floats) -> SampledClearance:
        """Check configurations, each for an interval of time around it.

        Args:
            positions: Shape (s, n) [rad | m].
            times: Shape (s,) [s].
            around: How far the interval reaches before and after, shape (s, 2) [s].
            travel: How much nearer to each other a pair may be elsewhere in it, shape (s,) [m].
        """
        cuts = range(BATCH, len(times), BATCH)
        parts = zip(*(np.split(each, cuts) for each in (positions, times, around, travel)), strict=True)
        checked = [self._check(*part) for part in parts]
        if len(checked) == 1:
            return checked[0]
        return SampledClearance(*(np.concatenate(rows) for rows in zip(*checked, strict=True)))

    def _check(self, positions: Floats, times: Floats, around: Floats, travel: Floats) -> SampledClearance:
        count, latest = len(times), times + around[:, 1]
        # Distances of interest change seldom, so that bounds of the last checks hold for the next.
        widest = _rounded(float(travel.max(initial=0.0)))
        until = _rounded(max(float(latest.max(initial=0.0)), INTERVAL))
        found = self.obstacles.contacts(positions, times, self._kept, within=widest, until=until)
        sample, spare, travel = found.sample, found.spare, travel[found.sample]
        first, last = (times - around[:, 0])[sample], latest[sample]
        present, error = found.present_within(first, last), found.error(last)
        near = present & (spare < error)
        within = present & (spare < error + travel)
        deep = found.present_throughout(first, last)
        deep &= spare < found.error(np.maximum(first, 0.0)) - travel
        which = np.full(count, -1, dtype=np.int64)
        nearest_last = np.argsort(-spare[near])
        which[sample[near][nearest_last]] = found.pair[near][nearest_last]
        return SampledClearance(
            _any(count, sample[near]), _any(count, sample[within]), _any(count, sample[deep]), which
        )

    def mover(self, pair: int) -> str:
        timed = self.obstacles.timed
        return next(name for name in timed.reduced.owners(pair) if name in timed.timings)

    @cached_property
    def settled(self) -> float:
        return self.obstacles.settled + INTERVAL


def _any(count: int, which: Ints) -> Bools:
    found = np.zeros(count, dtype=np.bool_)
    found[which] = True
    return found


def _rounded(value: float) -> float:
    return 2.0 ** ceil(log2(value)) if value > 0.0 else 0.0
