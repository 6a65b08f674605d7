"""Timing among dynamic obstacles: a motion unchanged, begun later, or with another timing on its path."""

from collections.abc import Iterator
from dataclasses import dataclass
from math import inf

import numpy as np

from trajopt.geometry import DynamicObstacles, Evaluator, WorkCounts
from trajopt.planning.moving.sampled_checks import SampledChecks
from trajopt.planning.moving.timed_path import PathTiming, TimedOnPath
from trajopt.planning.moving.timing_words import waits
from trajopt.planning.moving.waiting import LONGEST, STEP, Waiting
from trajopt.problem.problem import Problem
from trajopt.values.trajectory import Trajectory


@dataclass(frozen=True, eq=False)
class DynamicTiming:
    """Times motions of one problem among dynamic obstacles; one for each thread.

    Attributes:
        checks: Checks configurations for the obstacles.
        waiting: Begins motions later.
        timing: Times motions on their paths.
        latest: Latest end of a motion: the deadline, or the time until which the obstacles are known [s].
    """

    checks: SampledChecks
    waiting: Waiting
    timing: PathTiming
    latest: float

    @staticmethod
    def of(problem: Problem, query: Evaluator) -> "DynamicTiming | None":
        """Return the timing of a problem's motions; None if nothing changes with time.

        Args:
            problem: The problem.
            query: Of its reduced model.
        """
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
        """The work done so far."""
        return self.checks.obstacles.query.counts

    def delayed(self, fastest: Trajectory, by: float) -> Iterator[TimedOnPath]:
        """Yield a motion unchanged and begun later, if that seems clear.

        Args:
            fastest: The motion.
            by: Latest end [s].
        """
        for begun in self.waiting.beginnings(fastest, latest=by - fastest.duration):
            wait = begun.duration - fastest.duration
            yield TimedOnPath(begun, () if begun is fastest else (waits(wait),))

    def timings(self, fastest: Trajectory, by: float = inf) -> Iterator[TimedOnPath]:
        """Yield a motion unchanged, if that seems clear; then a few clear timings of it, the soonest first.

        Args:
            fastest: The motion, the fastest along its path.
            by: Latest end [s]; infinite for any time.
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
