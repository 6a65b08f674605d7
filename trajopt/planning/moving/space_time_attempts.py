"""Attempts with shape and time optimised together among dynamic obstacles, each from a seed in time."""

from dataclasses import dataclass, replace
from functools import cached_property
from math import ceil, inf

import numpy as np

from trajopt.optimise.methods.space_time import PRECISION, SpaceTime, SpaceTimeProgram
from trajopt.planning.moving.dynamic_timing import LONGEST
from trajopt.planning.result import Result
from trajopt.planning.seeds import with_knots
from trajopt.planning.seeds.space_time_rrt import SpaceTimeProblem, searched
from trajopt.planning.status import Certainty, Status
from trajopt.planning.workspace import MotionCandidate, PlanningWorkspace
from trajopt.values.trajectory import Path, Trajectory


@dataclass(eq=False)
class BestMotion:
    """The best result of a search: a verified motion, or the failure that came nearest to one."""

    result: Result

    def learn(self, found: Result) -> None:
        """Keep a result if it is better: verified before late before refused, and then by duration."""
        self.result = min(found, self.result, key=_order)

    @property
    def verified(self) -> bool:
        return self.result.verified

    @property
    def impossible(self) -> bool:
        return not self.verified and self.result.certainty is Certainty.PROVEN

    @property
    def duration(self) -> float:
        """Duration of the motion [s]; infinite if there is none."""
        return self.result.cost


def _order(result: Result) -> tuple[bool, bool, bool, float]:
    late = result.status is Status.TOO_LATE and result.trajectory is not None
    duration = inf if result.trajectory is None else result.trajectory.duration
    proven = result.certainty is Certainty.PROVEN
    return not result.verified, not proven, not late, duration


ENOUGH = 1.05
"""Factor on the static duration that is short enough: even pieces and the precision of the duration cost
about half of it.
"""
FAR = 1.25
"""Factor on the static duration that is worth another seed."""
LEFT = 1e-3
"""A motion has left its start when a joint has moved this far [rad | m]."""
SOON = 0.1
"""A shorter pause at the start is not reported [s]."""
SAMPLES = 200
STEPS = 10
"""Steps of a seed's beginning in each duration of the motion."""
HORIZONS = (1.5, 3.0, 6.0)
"""Static durations in which paths are sampled, in turn."""
CHECKED = 20_000
"""Configurations checked for each of these paths."""
BECAUSE = "things move, appear or expire, and no timing of the path without them is better"


@dataclass(eq=False)
class SpaceTimeAttempts:
    """Attempts at one problem, each from a seed in time."""

    program: SpaceTimeProgram
    work: PlanningWorkspace
    static: Result
    best: BestMotion
    _too_short: float = 0.0
    _found: Result | None = None

    @staticmethod
    def of(work: PlanningWorkspace, static: Result, best: BestMotion) -> "SpaceTimeAttempts | None":
        problem, method = work.problem, SpaceTime()
        if problem.waypoints or method.objection(problem):
            return None
        knots = with_knots(static.require().path.knots, problem.knots)
        return SpaceTimeAttempts(method.program(problem, knots), work, static, best)

    def hardly_longer(self) -> None:
        if self.enough < inf:
            self._solve(self._motion, self.enough)
            self._too_short = self.enough

    def longer(self) -> None:
        self._attempt(self._motion, too_short=self._too_short)

    def from_best(self) -> None:
        if self.best.verified and self.best.result is not self._found:
            self._attempt(self.best.result.require().trajectory)

    def from_later_start(self) -> None:
        if self.best.duration <= FAR * self._motion.duration:
            return
        with self.work.tracker.stage("wait"):
            wait = self._first_clear()
        if wait > 0.0:
            self._attempt(_begun_later(self._motion, wait))

    def from_sampled_paths(self, rng: np.random.Generator) -> None:
        for horizon in HORIZONS:
            if not self.best.verified:
                self._attempt(self._sampled(horizon, rng))

    @property
    def _motion(self) -> Trajectory:
        return self.static.require().trajectory

    @cached_property
    def enough(self) -> float:
        """Sufficient duration [s]: hardly longer than the static one, or than until its end is clear."""
        # Obstacles may move for ever.
        static, until = self._motion, min(self.program.until, LONGEST)
        enough, dwell, margins = ENOUGH * static.duration, self.work.problem.dwell, self.program.obstacles
        clear = enough
        if margins is not None:
            clear = margins.first_clear(static.positions[-1], min(enough, until), until, dwell)
        return enough if clear <= enough else min(clear / PRECISION, max(until, clear))

    def _attempt(self, seed: Trajectory | None, *, too_short: float = 0.0) -> None:
        longest = PRECISION * self.best.duration
        if seed is None or longest <= self.enough or PRECISION * seed.duration > self.best.duration:
            return
        if min(longest, self.program.until) > too_short:
            self._solve(seed, longest, too_short)

    def _solve(self, seed: Trajectory, longest: float, too_short: float = 0.0) -> None:
        program, tracker, best = self.program, self.work.tracker, self.best
        with tracker.optimising(program.counts) as step:
            solved = program.solve_from(
                seed,
                longest=longest,
                enough=self.enough,
                too_short=too_short,
                proves=self._proves,
                progress=step,
            )
        tracker.count(attempts=1, qp_solves=solved.qp_solves, qp_iterations=solved.qp_iterations)
        if solved.decoded.trajectory is not None:
            found = best.result is self._found
            best.result = replace(best.result, path=solved.decoded.path, solve=solved)
            self._found = best.result if found else self._found

    def _proves(self, motion: Trajectory) -> bool:
        path = Path(motion.joint_names, motion.positions)
        judged = self.work.proven(MotionCandidate(path, motion, None))
        if judged is None:
            return False
        remarks = (*self.static.remarks, _described(motion, self._motion))
        self._found = replace(
            judged.planned_as(self.static),
            remarks=remarks,
            method=self.program.method.name,
            because=BECAUSE,
            along_path=None,
        )
        self.best.learn(self._found)
        return True

    def _first_clear(self) -> float:
        """Return the first start at which the static motion is clear [s]; 0 if none, or without a delay."""
        assert self.program.obstacles is not None
        motion, margins, dwell = self._motion, self.program.obstacles, self.program.problem.dwell
        times = np.linspace(0.0, motion.duration, SAMPLES)
        positions, step = motion(times), motion.duration / STEPS
        last = min(margins.checks.settled, self.program.until - motion.duration, LONGEST)
        for wait in (step * np.arange(ceil(max(last, 0.0) / step) + 1)).tolist():
            if (margins.spare(positions, times + wait) >= 0.0).all():
                stays = margins.spare_staying(positions[-1], motion.duration + wait, dwell)
                if (stays >= 0.0).all():
                    return wait
        return 0.0

    def _sampled(self, horizon: float, rng: np.random.Generator) -> Trajectory | None:
        program, tracker, motion = self.program, self.work.tracker, self._motion
        assert program.obstacles is not None
        counts, latest = program.counts, min(horizon * motion.duration, program.until)
        before, ends = replace(counts), (motion.positions[0], motion.positions[-1])
        limits, dwell = program.problem.limits, program.problem.dwell

        def check() -> None:
            tracker.check(counts.since(before))

        space = SpaceTimeProblem(program.obstacles, limits, *ends, latest, dwell, CHECKED, check)
        with tracker.stage("seed"):
            try:
                return searched(space, motion.joint_names, rng)
            finally:
                tracker.count_work(counts.since(before))


def _begun_later(motion: Trajectory, wait: float) -> Trajectory:
    times = np.linspace(0.0, wait + motion.duration, SAMPLES)
    return Trajectory(motion.joint_names, times, motion(np.maximum(times - wait, 0.0)))


def _described(motion: Trajectory, static: Trajectory) -> str:
    begun = _begun(motion)
    late = begun > SOON and begun > 2.0 * _begun(static)
    waits = f"waits {begun:.2f} s, then takes" if late else "takes"
    more = motion.duration - static.duration
    return (
        f"shape and time were planned together for what changes with time: {waits} another way or another "
        f"pace, {abs(more):.3f} s {'longer' if more > 0.0 else 'shorter'} than without it"
    )


def _begun(motion: Trajectory) -> float:
    times = np.linspace(0.0, motion.duration, SAMPLES)
    away = (np.abs(motion(times) - motion(0.0)) > LEFT).any(axis=1)
    return float(times[np.argmax(away)])
