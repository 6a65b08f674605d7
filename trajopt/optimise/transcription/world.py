"""The world of a motion: what changes with time around its robot, and what is clear of it when."""

from dataclasses import dataclass, field
from functools import cached_property
from math import ceil, inf

import numpy as np

from trajopt.geometry import Query, WorkCounts
from trajopt.optimise.transcription.knots import CLEARANCE_TOLERANCE, SWEEP, samples_for, swept
from trajopt.optimise.transcription.margins import shrinkable
from trajopt.problem.problem import Problem
from trajopt.scene.timed import ChangingPairs, TimedModel, timed_model
from trajopt.values.arrays import Bools, Floats, Ints, Printed

ROOM = SWEEP**2 / (8.0 * 0.025) + CLEARANCE_TOLERANCE
"""Clearance of what changes that is kept above what is required [m]: so much nearer does a body come, between
two samples, that turns about a point 2.5 cm away, and the program may miss a margin by its tolerance."""
LOOK = 0.02
"""Time between two looks while the robot stays somewhere [s]: at 1 m/s things move by 2 cm."""
TOGETHER = 64
"""Times that are looked at together: distances are held in memory for each."""


@dataclass(frozen=True, eq=False)
class DynamicObstacles(Printed):
    """What changes with time, as one program sees it.

    Attributes:
        timed: The model among it.
        query: Of that, for the rows of programs: what it remembers is of their samples. Its owner's, so one
            per thread.
        looks: The same for all else.
        pairs: What is known of its pairs.
    """

    timed: TimedModel
    query: Query
    looks: Query
    pairs: ChangingPairs
    _stays: dict[tuple[bytes, float, float], Floats] = field(
        init=False, repr=False, default_factory=dict[tuple[bytes, float, float], Floats]
    )

    @staticmethod
    def of(problem: Problem, counts: WorkCounts) -> "DynamicObstacles | None":
        """Return what changes around a problem's robot; None where nothing does."""
        timed = timed_model(problem.reduced)
        if timed is None:
            return None
        query, looks = (Query(timed.reduced, counts) for _ in range(2))
        return DynamicObstacles(timed, query, looks, ChangingPairs.of(timed))

    @cached_property
    def moments(self) -> Floats:
        """When things appear and expire [s]."""
        both = [time for timing in self.timed.timings.values() for time in (timing.appears, timing.expires)]
        return np.unique([time for time in both if np.isfinite(time)])

    @property
    def settled(self) -> float:
        """When everything has come to rest, appeared and expired [s]."""
        motions = (timing.motion for timing in self.timed.timings.values())
        ends = [0.0 if motion is None else motion.track.end for motion in motions]
        return max(0.0, *ends, *self.moments.tolist())

    @cached_property
    def room(self) -> Floats:
        """Clearance to keep above what is required: a little, or the margin that was asked for, (p,) [m]."""
        pairs = self.timed.reduced.pairs
        return np.where(shrinkable(pairs), ROOM, pairs.margin - pairs.required)

    def spare(self, positions: Floats, times: Floats) -> Floats:
        """Return what each pair has above what is required, up to its room, the least of some states, (p,).

        Args:
            positions: Shape (s, n) [rad | m].
            times: Shape (s,) [s].
        """
        pairs, spare = self.pairs, self.room.copy()
        errors = pairs.error_at(float(times.max()), slice(None))
        reach = np.where(pairs.changes, pairs.required + self.room + errors, -np.inf)
        found = self.looks.close_pairs(self.timed.positions(positions, times), reach)
        when, pair = times[found.sample], found.pair
        there = (when >= pairs.appears[pair]) & (when <= pairs.expires[pair])
        left = found.distance - pairs.required[pair] - pairs.error_at(when, pair)
        np.minimum.at(spare, pair[there], left[there])
        return spare

    def samples(self, corners: Floats, times: Floats, way: Floats) -> Ints:
        """Return how many samples what changes demands between corners of a motion, shape (s - 1,).

        Where nothing that changes can be too near anywhere between two corners, it demands none.

        Args:
            corners: Shape (s, n) [rad | m].
            times: Shape (s,) [s].
            way: How far the robot gets on between them, shape (s - 1,) [m].
        """
        # They may go opposite ways.
        both = way + swept(
            self.looks, self.timed.positions(np.repeat(corners[:1], len(times), axis=0), times)
        )
        pairs, least = self.pairs, self.pairs.required + self.room
        farthest = least + pairs.error_at(float(times[-1]), slice(None)) + both.max(initial=0.0)
        reach = np.where(pairs.changes, farthest, -np.inf)
        found = self.looks.close_pairs(self.timed.positions(corners, times), reach)
        spare = np.full(len(times), np.inf)
        above = least[found.pair] + pairs.error_at(times[found.sample], found.pair)
        np.minimum.at(spare, found.sample, found.distance - above)
        # A distance that is d1 here and d2 there is nowhere between less than half of d1 + d2 - way.
        near = spare[:-1] + spare[1:] < both
        return np.where(near, samples_for(both, 1, SWEEP / 2.0), 1)

    def spare_staying(self, positions: Floats, begin: float, dwell: float) -> Floats:
        """Return what each pair has above what is required while the robot stays somewhere, (p,).

        Args:
            positions: Where, shape (n,) [rad | m].
            begin: From when on [s].
            dwell: How long [s].
        """
        asked = (positions.tobytes(), begin, dwell)
        if asked not in self._stays:
            times = begin + np.linspace(0.0, dwell, 1 + ceil(dwell / LOOK))
            self._stays[asked] = self.spare(np.tile(positions, (len(times), 1)), times)
        return self._stays[asked]

    def first_clear(self, positions: Floats, begin: float, until: float, dwell: float) -> float:
        """Return from when on, between two times, the robot can stay somewhere for a time [s].

        It is looked for in steps; infinite where it is never.

        Args:
            positions: Where, shape (n,) [rad | m].
            begin: No earlier [s].
            until: No later [s].
            dwell: How long it stays [s].
        """
        if (self.spare_staying(positions, begin, dwell) >= 0.0).all():
            return begin
        # What expires is still there at that very time.
        last = min(self.settled + LOOK, until)
        for first in range(1, 1 + ceil(max(last - begin, 0.0) / LOOK), TOGETHER):
            times = np.minimum(begin + LOOK * np.arange(first, first + TOGETHER), last)
            for time in times[self._clear_at(positions, times)].tolist():
                if (self.spare_staying(positions, time, dwell) >= 0.0).all():
                    return time
        return inf

    def _clear_at(self, positions: Floats, times: Floats) -> Bools:
        """Say at which times nothing that changes is too near to the robot somewhere, shape (s,)."""
        pairs, clear = self.pairs, np.ones(len(times), dtype=np.bool_)
        errors = pairs.error_at(float(times[-1]), slice(None))
        reach = np.where(pairs.changes, pairs.required + errors, -np.inf)
        resting = np.tile(positions, (len(times), 1))
        found = self.looks.close_pairs(self.timed.positions(resting, times), reach)
        when, pair = times[found.sample], found.pair
        there = (when >= pairs.appears[pair]) & (when <= pairs.expires[pair])
        near = found.distance - pairs.required[pair] < pairs.error_at(when, pair)
        clear[found.sample[there & near]] = False
        return clear
