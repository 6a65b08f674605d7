"""Timing among dynamic obstacles: unchanged, begun later, or retimed on the path, the soonest first."""

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
class Among:
    """Times motions of one problem among what changes; one for each thread.

    Attributes:
        checks: Checks configurations for dynamic obstacles.
        waiting: Begins them later.
        timing: Times them anew on their paths.
        latest: When they must be over, or nothing is known any more [s].
    """

    checks: SampledChecks
    waiting: Waiting
    timing: PathTiming
    latest: float

    @staticmethod
    def of(problem: Problem, query: Evaluator) -> "Among | None":
        """Return what times the motions of a problem; None where nothing changes with time.

        Args:
            problem: The problem.
            query: Of its reduced model.
        """
        obstacles = DynamicObstacles.of(problem.reduced, WorkCounts(), problem.evaluator)
        if obstacles is None:
            return None
        checks, until = SampledChecks(obstacles), obstacles.timed.until
        torque = query.dynamics.torque if np.isfinite(problem.limits.effort).any() else None
        waiting = Waiting(checks, problem.dwell)
        latest = until if problem.finish_by is None else min(until, problem.finish_by)
        return Among(checks, waiting, PathTiming(checks, problem.limits, torque, problem.dwell), latest)

    def soon(self, fastest: Trajectory, by: float) -> Iterator[TimedOnPath]:
        """Yield a motion as it is, and begun later, where that seems clear and is over by a time.

        Args:
            fastest: The motion.
            by: The time [s].
        """
        for begun in self.waiting.beginnings(fastest, latest=by - fastest.duration):
            wait = begun.duration - fastest.duration
            yield TimedOnPath(begun, () if begun is fastest else (waits(wait),))

    def timings(self, fastest: Trajectory, by: float = inf) -> Iterator[TimedOnPath]:
        """Yield a motion as it is, if that seems clear; then what does and is over soonest, a few times.

        Args:
            fastest: The motion, the fastest along its path.
            by: When it is to be over [s]; infinite for any time.
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
