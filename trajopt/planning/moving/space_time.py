"""In space and time: the shape of a motion and its timing planned together, among dynamic obstacles.

Seeds are motions that need not be possible: the one without dynamic obstacles, the best one found,
and the first begun later; if none of these leads to a motion, paths of a sampling planner. Each is made into
the shortest motion near to it.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from math import ceil, inf

import numpy as np

from trajopt.optimise.methods.space_time import PRECISION, SpaceTime, SpaceTimeProgram
from trajopt.planning.budget import BudgetTracker, Stopped
from trajopt.planning.moving.waiting import LONGEST
from trajopt.planning.result import Result
from trajopt.planning.seeds import with_knots
from trajopt.planning.seeds.in_time import SpaceTimeProblem, searched
from trajopt.planning.workspace import MotionCandidate, PlanningWorkspace
from trajopt.values.trajectory import Path, Trajectory

ENOUGH = 1.05
"""Excess over the duration without dynamic obstacles that is short enough: even pieces and the precision of
the
duration cost about half of it.
"""
FAR = 1.25
"""Excess over the duration without dynamic obstacles that is worth another seed: it may go the long way."""
LEFT = 1e-3
"""Distance of a joint from which a motion has left its start [rad | m]."""
SOON = 0.1
"""A motion that leaves its start within this time does not wait [s]: a person sees no shorter pause."""
PACES = 200
"""Moments of a seed."""
STEPS = 10
"""Steps of a seed's beginning in each duration of the motion."""
HORIZONS = (1.5, 3.0, 6.0)
"""Horizons of the sampled paths in turn, as multiples of the duration without dynamic obstacles."""
CHECKED = 20_000
"""Configurations that are checked for each of these paths: the same number as in a static scene."""
BECAUSE = "things move, appear or expire, and no timing of the path without them is better"
"""Reason of planning for the method."""


@dataclass(eq=False)
class InSpaceTime:
    """Attempts at one problem with shape and time planned together, each from a seed.

    Attributes:
        program: Makes motions of seeds.
        work: Judges them.
        still: The verified motion without dynamic obstacles.
        best: The shortest motion; it may be unverified.
    """

    program: SpaceTimeProgram
    work: PlanningWorkspace
    still: Result
    best: Result
    _too_short: float = 0.0

    @staticmethod
    def of(work: PlanningWorkspace, still: Result, best: Result) -> "InSpaceTime | None":
        """Return the attempts at a problem before the first; None if the method cannot plan it.

        Args:
            work: Of the problem, with one goal.
            still: The verified motion without dynamic obstacles.
            best: The present result.
        """
        problem, method = work.problem, SpaceTime()
        if problem.waypoints or method.objection(problem):
            return None
        knots = with_knots(still.require().path.knots, problem.knots)
        return InSpaceTime(method.program(problem, knots), work, still, best)

    def hardly_longer(self) -> Result:
        """Return a motion hardly longer than the one without dynamic obstacles; else the present one.

        Raises:
            Stopped: If the budget runs out.
        """
        if self.enough < inf:
            self._solved(self.still.require().trajectory, self.enough)
            self._too_short = self.enough
        return self.best

    @cached_property
    def enough(self) -> float:
        """Duration that is short enough [s]; infinite if no motion can end.

        It hardly exceeds the motion without dynamic obstacles, or the time until its end is clear.
        """
        # What moves may do so for ever.
        alone, until = self.still.require().trajectory, min(self.program.until, LONGEST)
        enough, dwell, margins = ENOUGH * alone.duration, self.work.problem.dwell, self.program.obstacles
        clear = enough
        if margins is not None:
            clear = margins.first_clear(alone.positions[-1], min(enough, until), until, dwell)
        return enough if clear <= enough else min(clear / PRECISION, max(until, clear))

    def longer(self) -> Result:
        """Return a motion from the one without dynamic obstacles that takes longer; else the present one.

        Raises:
            Stopped: If the budget runs out and nothing is verified.
        """
        try:
            self.add(self.still.require().trajectory, too_short=self._too_short)
        except Stopped as ended:
            if not self.best.verified:
                raise
            return replace(self.best, stopped=ended.stop)
        return self.best

    def shortest(self, best: Result, rng: np.random.Generator) -> Result:
        """Return the shortest motion that is found from other seeds; else the one given.

        Args:
            best: The shortest one found before; it may be unverified.
            rng: Random generator.

        Raises:
            Stopped: If the budget runs out and nothing is verified.
        """
        mine, self.best = self.best, best
        alone, tracker = self.still.require().trajectory, self.work.tracker
        try:
            if best.verified and best is not mine:
                self.add(best.require().trajectory)
            if self.longest > FAR * alone.duration:
                self.add(_clear_later(alone, self.program, tracker))
            for horizon in HORIZONS:
                if not self.best.verified:
                    self.add(_sampled(alone, horizon, self.program, tracker, rng))
        except Stopped as ended:
            if not self.best.verified:
                raise
            return replace(self.best, stopped=ended.stop)
        return self.best

    @property
    def longest(self) -> float:
        """Duration of the best motion [s]; infinite without one."""
        return self.best.require().trajectory.duration if self.best.verified else inf

    def add(self, seed: Trajectory | None, *, too_short: float = 0.0) -> None:
        """Make a motion of a seed, if it may be the shortest, and record it if it is verified.

        Args:
            seed: The seed; None for none.
            too_short: Longest duration for which nothing was found from it before [s].
        """
        longest = PRECISION * self.longest
        if seed is None or longest <= self.enough or PRECISION * seed.duration > self.longest:
            return
        if min(longest, self.program.until) > too_short:
            self._solved(seed, longest, too_short)

    def _solved(self, seed: Trajectory, longest: float, too_short: float = 0.0) -> None:
        program, tracker, enough = self.program, self.work.tracker, self.enough
        with tracker.optimising(program.counts) as step:
            solved = program.solve_from(
                seed, longest=longest, enough=enough, too_short=too_short, proves=self._proves, progress=step
            )
        tracker.count(attempts=1, qp_solves=solved.qp_solves, qp_iterations=solved.qp_iterations)
        if solved.decoded.trajectory is not None:
            self.best = replace(self.best, path=solved.decoded.path, solve=solved)

    def _proves(self, motion: Trajectory) -> bool:
        """Return whether a motion is verified, and record it if it is."""
        path = Path(motion.joint_names, motion.positions)
        judged = self.work.proven(MotionCandidate(path, motion, None))
        if judged is not None:
            kept = {name: getattr(self.still, name) for name in ("attempts", "won", "goal_name")}
            remarks = (*self.still.remarks, _described(motion, self.still.require().trajectory))
            name = self.program.method.name
            self.best = replace(judged, remarks=remarks, method=name, because=BECAUSE, **kept)
        return judged is not None


def _clear_later(motion: Trajectory, program: SpaceTimeProgram, tracker: BudgetTracker) -> Trajectory | None:
    """Return a motion begun when it is clear, wherever the robot is until then; None if that is never."""
    with tracker.stage("wait"):
        wait = _first_clear(motion, program)
    return None if wait <= 0.0 else _begun_later(motion, wait)


def _first_clear(motion: Trajectory, program: SpaceTimeProgram) -> float:
    """Return the time at which a motion can begin if the robot may be anywhere until then; 0 if never [s]."""
    assert program.obstacles is not None
    margins, dwell = program.obstacles, program.problem.dwell
    times = np.linspace(0.0, motion.duration, PACES)
    positions, step = motion(times), motion.duration / STEPS
    last = min(margins.checks.settled, program.until - motion.duration, LONGEST)
    for wait in (step * np.arange(ceil(max(last, 0.0) / step) + 1)).tolist():
        if (margins.spare(positions, times + wait) >= 0.0).all():
            stays = margins.spare_staying(positions[-1], motion.duration + wait, dwell)
            if (stays >= 0.0).all():
                return wait
    return 0.0


def _sampled(
    alone: Trajectory,
    horizon: float,
    program: SpaceTimeProgram,
    tracker: BudgetTracker,
    rng: np.random.Generator,
) -> Trajectory | None:
    """Return a path through space and time, if there is one within this multiple of the duration."""
    assert program.obstacles is not None
    counts, latest = program.counts, min(horizon * alone.duration, program.until)
    before = replace(counts)
    ends = alone.positions[0], alone.positions[-1]

    def check() -> None:
        tracker.check(counts.since(before))

    dwell = program.problem.dwell
    stage = SpaceTimeProblem(program.obstacles, program.problem.limits, *ends, latest, dwell, CHECKED, check)
    with tracker.stage("seed"):
        try:
            return searched(stage, alone.joint_names, rng)
        finally:
            tracker.count_work(counts.since(before))


def _begun_later(motion: Trajectory, wait: float) -> Trajectory:
    """Return a motion begun later; it need not be possible."""
    times = np.linspace(0.0, wait + motion.duration, PACES)
    return Trajectory(motion.joint_names, times, motion(np.maximum(times - wait, 0.0)))


def _described(motion: Trajectory, alone: Trajectory) -> str:
    """Return remarks on a motion's changes because of dynamic obstacles."""
    begun = _begun(motion)
    late = begun > SOON and begun > 2.0 * _begun(alone)
    waits = f"waits {begun:.2f} s, then takes" if late else "takes"
    more = motion.duration - alone.duration
    return (
        f"shape and time were planned together for what changes with time: {waits} another way or another "
        f"pace, {abs(more):.3f} s {'longer' if more > 0.0 else 'shorter'} than without it"
    )


def _begun(motion: Trajectory) -> float:
    """Return when a motion has left its start [s]."""
    times = np.linspace(0.0, motion.duration, PACES)
    away = (np.abs(motion(times) - motion(0.0)) > LEFT).any(axis=1)
    return float(times[np.argmax(away)])
