"""Motions among dynamic obstacles: unchanged, begun later, or with another timing on their path."""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import islice
from math import ceil, inf

import numpy as np

from trajopt.geometry import DynamicObstacles, Evaluator, WorkCounts
from trajopt.planning.moving.sampled_checks import INTERVAL, SampledChecks
from trajopt.planning.moving.timed_path import PathTiming, TimedOnPath, waits
from trajopt.problem.problem import Problem
from trajopt.timing.time_scaling import begun_later
from trajopt.values.arrays import Bools, Floats
from trajopt.values.trajectory import Trajectory

STEP = 0.05
"""Step of start times [s]; then the interval between the last blocked one and the next is halved."""
HALVINGS = 4
"""A motion then begins within 3 ms of the earliest time that is clear."""
MOST = 3
"""Start times of one motion to judge: an object between samples may be in the way of the first."""
TOGETHER = 32
"""Start times checked together."""
FEW = 4
"""Samples with an obstacle too near, checked first for later starts: mostly it is there still."""
SPARSE = 8
"""One in so many samples of a motion is checked first."""
LONGEST = 60.0
"""Longest wait [s]."""


@dataclass(eq=False)
class Waiting:
    """Finds when a motion can begin; one for each thread."""

    checks: SampledChecks
    dwell: float = 0.0

    def beginnings(self, trajectory: Trajectory, *, latest: float = inf) -> Iterator[Trajectory]:
        """Yield a motion begun as early as seems clear, by `latest` [s], and a few times a little later."""
        self.checks.start_at(trajectory(np.zeros(1)))
        met = self._met(trajectory, 0.0)
        if not len(met):
            yield trajectory
        if trajectory(0.0, 1).any():
            return
        blocked, yielded = 0.0, 0
        waits = self._later(latest)
        while len(stretch := np.fromiter(islice(waits, TOGETHER), np.float64)):
            open_ones = ~self._still_met(trajectory, met, stretch)
            if len(stretch) < TOGETHER and not open_ones.any():
                return
            stands = self._standing(trajectory(np.zeros(1)), blocked, stretch)
            for place in range(stands):
                wait = float(stretch[place])
                if open_ones[place]:
                    met = self._met(trajectory, wait)
                    if len(met):
                        open_ones[place:stands] &= ~self._still_met(trajectory, met, stretch[place:stands])
                    else:
                        sooner = wait if yielded else self._sooner(trajectory, blocked, wait)
                        yield begun_later(trajectory, sooner)
                        yielded += 1
                        if yielded == MOST:
                            return
                blocked = wait
            if stands < len(stretch):
                return

    def _later(self, latest: float) -> Iterator[float]:
        last = min(self.checks.settled, LONGEST, self.checks.obstacles.timed.until, latest)
        yield from (STEP * number for number in range(1, ceil(last / STEP)))
        if 0.0 < last < LONGEST:
            yield last

    def _sooner(self, trajectory: Trajectory, blocked: float, clear: float) -> float:
        for _ in range(HALVINGS):
            middle = (blocked + clear) / 2.0
            if not len(self._met(trajectory, middle)):
                clear = middle
            else:
                blocked = middle
        return clear

    def _met(self, trajectory: Trajectory, wait: float) -> Floats:
        """Return times along a motion at which an object is too near if it is begun after a wait, few [s].

        Moments at which objects appear and expire are sampled too.
        """
        even = self._even(trajectory)
        moments = self.checks.obstacles.moments
        rest: Floats = np.concatenate((even, np.clip(moments - wait, 0.0, even[-1])))
        # A contact lasts for several samples, mostly.
        for times in (even[::SPARSE], rest):
            near = np.flatnonzero(self.checks.near(trajectory(times), times + wait))
            if len(near):
                spread = np.linspace(0, len(near) - 1, min(len(near), FEW)).astype(np.int64)
                return times[near[spread]]
        return even[:0]

    def _even(self, trajectory: Trajectory) -> Floats:
        duration = trajectory.duration + self.dwell
        return np.linspace(0.0, duration, max(2, ceil(duration / INTERVAL) + 1))

    def _still_met(self, trajectory: Trajectory, met: Floats, waits: Floats) -> Bools:
        # Those looks only that `_met` takes too: moments at which things appear depend on the wait.
        met = met[np.isin(met, self._even(trajectory))]
        if not len(met) or not len(waits):
            return np.zeros(len(waits), dtype=np.bool_)
        positions = np.tile(trajectory(met), (len(waits), 1))
        near = self.checks.near(positions, (waits[:, None] + met).ravel())
        return np.any(near.reshape(len(waits), len(met)), axis=1)

    def _standing(self, start: Floats, since: float, waits: Floats) -> int:
        """Return the number of successive waits with the robot clear at rest at the start, (1, n)."""
        begins: list[float] = [since, *waits[:-1].tolist()]
        steps: list[Floats] = [
            np.arange(begin, end, INTERVAL, dtype=np.float64)
            for begin, end in zip(begins, waits.tolist(), strict=True)
        ]
        times: Floats = np.concatenate(steps)
        near = self.checks.near(np.tile(start, (len(times), 1)), times)
        which = np.repeat(np.arange(len(waits)), [len(each) for each in steps])
        return int(which[near].min(initial=len(waits)))


@dataclass(frozen=True, eq=False)
class DynamicTiming:
    """Times motions of one problem among dynamic obstacles; one for each thread.

    Attributes:
        latest: Latest end of a motion: the deadline, or the end of the predictions [s].
    """

    checks: SampledChecks
    waiting: Waiting
    timing: PathTiming
    latest: float

    @staticmethod
    def of(problem: Problem, query: Evaluator) -> "DynamicTiming | None":
        """Return the timing of a problem's motions; None if nothing changes with time."""
        obstacles = DynamicObstacles.of(problem.reduced, WorkCounts(), problem.evaluator)
        if obstacles is None:
            return None
        checks, until = SampledChecks(obstacles), obstacles.timed.until
        torque = query.dynamics.torque if np.isfinite(problem.limits.effort).any() else None
        timing = PathTiming(checks, problem.limits, torque, problem.dwell)
        latest = until if problem.finish_by is None else min(until, problem.finish_by)
        return DynamicTiming(checks, Waiting(checks, problem.dwell), timing, latest)

    @property
    def counts(self) -> WorkCounts:
        return self.checks.obstacles.query.counts

    def delayed(self, fastest: Trajectory, by: float) -> Iterator[TimedOnPath]:
        """Yield a motion unchanged and begun later, if that seems clear and it ends by a time [s]."""
        for begun in self.waiting.beginnings(fastest, latest=by - fastest.duration):
            wait = begun.duration - fastest.duration
            yield TimedOnPath(begun, () if begun is fastest else (waits(wait),))

    def timings(self, fastest: Trajectory, by: float = inf) -> Iterator[TimedOnPath]:
        """Yield a motion unchanged, if that seems clear; then a few clear timings of it, the soonest first.

        Args:
            by: Latest end [s]; may be infinite.
        """
        later = self.waiting.beginnings(fastest, latest=by - fastest.duration)
        begun = next(later, None)
        if begun is fastest:
            yield TimedOnPath(fastest, ())
            begun = next(later, None)
        settled = min(self.checks.settled, LONGEST) + 2.0 * fastest.duration
        until = settled if begun is None else begun.duration - STEP
        yield from self.timing.timings(fastest, min(until, self.latest, by))
        while begun is not None:
            wait = begun.duration - fastest.duration
            yield TimedOnPath(begun, (waits(wait),))
            begun = next(later, None)
