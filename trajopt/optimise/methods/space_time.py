"""Space-time: shape and time of a motion planned together among moving objects."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from math import ceil, inf, sqrt

import numpy as np

from trajopt.geometry import WorkCounts
from trajopt.geometry.dynamics import DynamicsQuery
from trajopt.optimise.methods.bspline import windowed_differences
from trajopt.optimise.methods.free_duration import MovingResult
from trajopt.optimise.methods.method import Decoded, Progress, followed_curve
from trajopt.optimise.solvers import Iteration, SolveResult, Sqp
from trajopt.optimise.transcription import KnotsNlp, transcribe
from trajopt.optimise.transcription.bspline import KnotPlaces, even_basis
from trajopt.optimise.transcription.free_duration import SHORTEST
from trajopt.optimise.transcription.knots import shortest_duration
from trajopt.optimise.transcription.space_time import DEGREE, ObstacleMargins, SpaceTimeFamily, SpaceTimeNlp
from trajopt.problem.problem import Problem
from trajopt.problem.smoothness import Acceleration, Jerk, Velocity
from trajopt.values.arrays import Floats, Printed
from trajopt.values.trajectory import Trajectory

SMOOTH = (Velocity, Acceleration, Jerk)
"""Terms that make a motion short and smooth."""
PIECES, PIECES_AMONG_CHANGES = 1, 2
"""Pieces for each knot of a path; among changing objects twice as many, since a motion that waits bends in
time too.
"""
MOST_PIECES = 4
"""Most pieces: time and memory grow with them."""
STRETCHES = (1.0, 1.25, 1.6, 2.5)
"""Multiples of a seed's duration tried in turn: room to accelerate and to let obstacles pass."""
SHRINK = 0.8
"""Factor on the next duration while motions are found; after a failure, the geometric mean is tried."""
PRECISION = 0.97
"""Relative precision of the shortest duration: about the cost of pieces of equal length."""
GAIN = 0.02
"""Least predicted share of violation that a step must remove if the caller has other ways to try."""
UNHURRIED = 1.25
"""Duration of a seed without time, as a multiple of the least that the joint limits allow."""

Proves = Callable[[Trajectory], bool]
"""Returns whether a motion is proven."""


def _solver() -> Sqp:
    # What is sought is a motion that is possible: violations weigh much at once.
    return Sqp(penalty=50.0, penalty_rounds=1, max_iterations=20)


@dataclass(frozen=True)
class SpaceTime:
    """Plans shape and time together among moving objects: it can wait, hurry, go around and step aside.

    A motion of given duration is a program with linear limits; the duration is reduced while motions are
    found, each program beginning at the last motion.
    """

    solver: Sqp = field(default_factory=_solver)
    name: str = "space-time"

    def objection(self, problem: Problem) -> str:
        if problem.tool_speeds:
            return "holds no limits of tool speeds"
        return followed_curve(problem) or windowed_differences(problem)

    def program(
        self, problem: Problem, seed: Floats, waypoint_knots: Sequence[int] = ()
    ) -> "SpaceTimeProgram":
        base = transcribe(problem, seed, waypoint_knots)
        limited = np.isfinite(problem.limits.effort).any()
        dynamics = DynamicsQuery.loaded(problem.reduced) if limited else None
        obstacles = ObstacleMargins.of(problem, base.counts)
        return SpaceTimeProgram(self, problem, base, obstacles, dynamics, seed, tuple(waypoint_knots))


@dataclass(frozen=True, eq=False)
class SpaceTimeProgram(Printed):
    """A problem over the control points of a spline over time.

    Attributes:
        base: The problem over knots: its rows without time.
        polyline: Knots to which windows and margins refer, shape (N, n) [rad | m].
    """

    method: SpaceTime
    problem: Problem
    base: KnotsNlp
    obstacles: ObstacleMargins | None
    dynamics: DynamicsQuery | None
    polyline: Floats
    waypoint_knots: tuple[int, ...]

    @property
    def scale(self) -> Floats:
        return self.base.scale

    @property
    def counts(self) -> WorkCounts:
        return self.base.counts

    @property
    def solver(self) -> Sqp:
        """Solver of each duration: any motion suffices if the costs only make motions short and smooth.

        The shortest duration from such a seed gives such a motion; other costs are minimised.
        """
        smooth = all(isinstance(cost.residual, SMOOTH) for cost in self.problem.costs or ())
        return replace(self.method.solver, until_feasible=True) if smooth else self.method.solver

    @property
    def until(self) -> float:
        """Latest end: the deadline, or the end of the predictions of obstacles [s]."""
        known = inf if self.obstacles is None else self.obstacles.checks.timed.until - self.problem.dwell
        return known if self.problem.finish_by is None else min(known, self.problem.finish_by)

    def solve(self, seed: Floats, *, progress: Progress | None = None) -> SolveResult:
        return self.solve_from(_timed(seed, self.problem), progress=progress)

    def decode(self, solved: SolveResult) -> Sequence[Decoded]:
        assert isinstance(solved, MovingResult)
        return (solved.decoded,)

    def solve_from(
        self,
        motion: Trajectory,
        *,
        longest: float = inf,
        enough: float = SHORTEST,
        too_short: float = 0.0,
        proves: Proves | None = None,
        progress: Progress | None = None,
    ) -> MovingResult:
        """Solve from a motion: with the same duration, a longer one if necessary, then ever shorter ones.

        Args:
            motion: Of the group's joints; it need not hold any limit.
            longest: Longest duration to try [s].
            enough: Shortest duration to try [s].
            too_short: Longest duration that failed before from the same motion [s].
            proves: Called with motions that hold everything on few samples, if any motion suffices: a proven
                one needs no finer samples. None takes fine samples always.
        """
        solver = self.solver
        if proves is not None:
            # Shortness and smoothness hardly stand against violations at their first weight already.
            rounds = 0 if solver.until_feasible else solver.penalty_rounds
            solver = replace(solver, relative_gain=GAIN, penalty_rounds=rounds)
        run = _Run(solver, proves, progress)
        self.base.restart()
        family = self.family(motion)
        # Schoenberg's approximation: its velocities are slopes of chords, no larger than the motion's.
        positions = motion(family.basis.averages * motion.duration)
        most = min(longest, self.until)
        tried = sorted({min(max(stretch * motion.duration, enough), most) for stretch in STRETCHES})
        possible = [duration for duration in tried if duration > too_short and family.ends_clear(duration)]
        first, *others = possible or tried[:1]
        found = run.solved(family.lasting(first), positions)
        for duration in others:
            if found.motion is not None:
                break
            found = run.solved(family.lasting(duration), positions)
        if found.motion is not None:
            found = run.shrunk(family, found, max(family.least_duration, enough))
        solved, decoded = found.solved, Decoded(found.nlp.decode(found.solved.x), found.motion)
        return MovingResult(solved.status, solved.x, solved.at, tuple(run.log), decoded)

    def family(self, motion: Trajectory) -> SpaceTimeFamily:
        """Return the programs of all durations, with as many pieces as a motion needs."""
        limits, knots = self.problem.limits, self.problem.knots
        # What bends faster than a joint reaches its speed is no use to it.
        quickest = float((limits.velocity / limits.acceleration).min())
        count = ceil(min(motion.duration / quickest, MOST_PIECES * knots))
        pieces = PIECES if self.obstacles is None else PIECES_AMONG_CHANGES
        basis = even_basis(DEGREE, max(count, pieces * knots))
        places = KnotPlaces.along(self.polyline, motion, self.waypoint_knots)
        end = motion.positions[-1]
        return SpaceTimeFamily(self.base, self.obstacles, basis, places, end, self.dynamics)


@dataclass(frozen=True, eq=False)
class _Found:
    nlp: SpaceTimeNlp
    solved: SolveResult
    motion: Trajectory | None


@dataclass(eq=False)
class _Run:
    solver: Sqp
    proves: Proves | None
    progress: Progress | None
    log: list[Iteration] = field(default_factory=list[Iteration])

    def solved(self, nlp: SpaceTimeNlp, begin: Floats) -> _Found:
        return self._proven(self._tried(nlp, begin))

    def _tried(self, nlp: SpaceTimeNlp, begin: Floats) -> _Found:
        few = self.solver.until_feasible and self.proves is not None
        return self._solved(replace(self.solver, refines=False) if few else self.solver, nlp, begin)

    def _proven(self, found: _Found) -> _Found:
        if found.motion is None or self.proves is None or self.proves(found.motion):
            return found
        if self.solver.until_feasible:
            found = self._solved(replace(self.solver, fine_first=True), found.nlp, found.solved.x)
            if found.motion is None or self.proves(found.motion):
                return found
        return replace(found, motion=None)

    def _solved(self, solver: Sqp, nlp: SpaceTimeNlp, begin: Floats) -> _Found:
        solved = solver.solve(nlp, begin, progress=self.progress)
        self.log += solved.log
        return _Found(nlp, solved, nlp.trajectory(solved.x) if solved.feasible else None)

    def shrunk(self, family: SpaceTimeFamily, proven: _Found, low: float) -> _Found:
        """Return a shorter motion, proven at the end only: most on the way there are not needed."""
        if low >= PRECISION * proven.nlp.duration:
            return proven
        self.solver = replace(self.solver, max_iterations=ceil(self.solver.max_iterations / 2))
        found, refused = proven, False
        while True:
            while low < PRECISION * found.nlp.duration:
                longest = found.nlp.duration
                duration = sqrt(low * longest) if refused else max(SHRINK * longest, low)
                shorter = None
                if family.ends_clear(duration):
                    shorter = self._tried(family.lasting(duration), found.solved.x)
                if shorter is None or shorter.motion is None:
                    low, refused = duration, True
                else:
                    found = shorter
            if found is proven:
                return proven
            last = self._proven(found)
            if last.motion is None:
                low, refused, found = found.nlp.duration, True, proven
            else:
                found = proven = last


def _timed(seed: Floats, problem: Problem) -> Trajectory:
    steps = np.abs(np.diff(seed, axis=0))
    travel = steps.sum(axis=0)
    least = shortest_duration(problem.limits, np.zeros_like(travel), travel)
    lengths = np.linalg.norm(steps, axis=1)
    along = np.concatenate((np.zeros(1), np.cumsum(lengths))) / max(float(lengths.sum()), 1e-12)
    share = np.linspace(0.0, 1.0, 20 * len(steps))
    eased = share**2 * (3.0 - 2.0 * share)
    positions = np.empty((len(share), len(travel)))
    for joint in range(len(travel)):
        positions[:, joint] = np.interp(eased, along, seed[:, joint])
    times = share * max(UNHURRIED * least, SHORTEST)
    return Trajectory(problem.reduced.joint_names, times, positions)
