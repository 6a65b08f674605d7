"""Margins from dynamic obstacles: the clearance that a program keeps, and the spare clearance of states."""

from dataclasses import dataclass, field
from functools import cached_property
from math import ceil, inf

import numpy as np

from trajopt.geometry import DynamicObstacles, WorkCounts
from trajopt.optimise.transcription.knots import CLEARANCE_TOLERANCE, SWEEP, samples_for, swept
from trajopt.optimise.transcription.margins import shrinkable
from trajopt.problem.problem import Problem
from trajopt.values.arrays import Floats, Ints, Printed

MARGIN = SWEEP**2 / (8.0 * 0.025) + CLEARANCE_TOLERANCE
"""Clearance from dynamic obstacles above the required one [m]: so much nearer does a body come, between two
samples, that turns about a point 2.5 cm away, and the program may miss a margin by its tolerance."""
INTERVAL = 0.02
"""Time between two checks while the robot stays at a configuration [s]: at 1 m/s obstacles move by 2 cm."""
TOGETHER = 64
"""Times that are checked together: distances are held in memory for each."""


@dataclass(frozen=True, eq=False)
class ObstacleMargins(Printed):
    """The margins that one program keeps from dynamic obstacles, and the spare clearance of states.

    Attributes:
        rows: The obstacles, for the rows of programs: its evaluator remembers their samples. Its owner's, so
            one per thread.
        checks: The same for all else.
    """

    rows: DynamicObstacles
    checks: DynamicObstacles
    _stays: dict[tuple[bytes, float, float], Floats] = field(
        init=False, repr=False, default_factory=dict[tuple[bytes, float, float], Floats]
    )

    @staticmethod
    def of(problem: Problem, counts: WorkCounts) -> "ObstacleMargins | None":
        """Return the margins of a problem; None if nothing in its scene changes with time."""
        rows, checks = (DynamicObstacles.of(problem.reduced, counts, problem.evaluator) for _ in range(2))
        return None if rows is None or checks is None else ObstacleMargins(rows, checks)

    @cached_property
    def margin(self) -> Floats:
        """Clearance to keep above the required one: a little, or a margin that is stated, (p,) [m]."""
        pairs = self.checks.timed.reduced.pairs
        return np.where(shrinkable(pairs), MARGIN, pairs.margin - pairs.required)

    def spare(self, positions: Floats, times: Floats) -> Floats:
        """Return the least clearance of each pair above the required one, no more than its margin, (p,) [m].

        Args:
            positions: Shape (s, n) [rad | m].
            times: Shape (s,) [s].
        """
        spare = self.margin.copy()
        found = self.checks.contacts(positions, times, self.checks.required(), within=self.margin)
        near = found.present
        np.minimum.at(spare, found.pair[near], found.least_spare[near])
        return spare

    def samples(self, corners: Floats, times: Floats, way: Floats) -> Ints:
        """Return how many samples the obstacles demand between corners of a motion, shape (s - 1,).

        If no obstacle can be too near anywhere between two corners, they demand one.

        Args:
            corners: Shape (s, n) [rad | m].
            times: Shape (s,) [s].
            way: How far the robot moves between them, shape (s - 1,) [m].
        """
        # They may go opposite ways.
        resting = self.checks.timed.positions(np.repeat(corners[:1], len(times), axis=0), times)
        both = way + swept(self.checks.query, resting)
        least = self.checks.required(self.margin)
        found = self.checks.contacts(corners, times, least, within=float(both.max(initial=0.0)))
        spare = np.full(len(times), inf)
        np.minimum.at(spare, found.sample, found.least_spare)
        # A distance that is d1 here and d2 there is nowhere between less than half of d1 + d2 - way.
        near = spare[:-1] + spare[1:] < both
        return np.where(near, samples_for(both, 1, SWEEP / 2.0), 1)

    def spare_staying(self, positions: Floats, begin: float, dwell: float) -> Floats:
        """Return the clearance of each pair above the required one while the robot stays, (p,).

        Args:
            positions: Its configuration, shape (n,) [rad | m].
            begin: From when on [s].
            dwell: For how long [s].
        """
        asked = (positions.tobytes(), begin, dwell)
        if asked not in self._stays:
            times = begin + np.linspace(0.0, dwell, 1 + ceil(dwell / INTERVAL))
            self._stays[asked] = self.spare(np.tile(positions, (len(times), 1)), times)
        return self._stays[asked]

    def first_clear(self, positions: Floats, begin: float, until: float, dwell: float) -> float:
        """Return the first time, between two others, at which the robot can begin to stay somewhere [s].

        It is searched in steps; infinite if there is none.

        Args:
            positions: Its configuration, shape (n,) [rad | m].
            begin: No earlier [s].
            until: No later [s].
            dwell: How long it stays [s].
        """
        if (self.spare_staying(positions, begin, dwell) >= 0.0).all():
            return begin
        # An obstacle that expires is still present at that very time.
        last = min(self.checks.settled + INTERVAL, until)
        for first in range(1, 1 + ceil(max(last - begin, 0.0) / INTERVAL), TOGETHER):
            times = np.minimum(begin + INTERVAL * np.arange(first, first + TOGETHER), last)
            staying = np.tile(positions, (len(times), 1))
            for time in times[self.checks.clear(staying, times, self.checks.required())].tolist():
                if (self.spare_staying(positions, time, dwell) >= 0.0).all():
                    return time
        return inf
