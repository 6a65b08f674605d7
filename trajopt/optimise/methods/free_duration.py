"""Shape and time of a motion optimised together, from another method's timed path."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from trajopt.geometry import WorkCounts
from trajopt.geometry.dynamics import DynamicsQuery
from trajopt.optimise.methods.bspline import SAMPLES, windowed_differences
from trajopt.optimise.methods.knots import Knots, KnotsProgram
from trajopt.optimise.methods.method import Decoded, Progress, followed_curve
from trajopt.optimise.methods.timing import retime_path, stopping_motion, with_jerk
from trajopt.optimise.solvers import SolveResult, Sqp
from trajopt.optimise.solvers.sqp import TrustRegion
from trajopt.optimise.transcription.bspline import KnotPlaces, SplineBasis, over_control_points
from trajopt.optimise.transcription.free_breaks import FreeBreaksNlp
from trajopt.optimise.transcription.free_duration import RESTING, FreeDurationNlp
from trajopt.problem.problem import Problem
from trajopt.timing import RetimeFailure
from trajopt.values.arrays import Floats, Printed
from trajopt.values.trajectory import Path, Trajectory

SEED_TOLERANCE = 5e-3
"""Largest distance of the timed seed from its path [m]."""
FEW = 3
"""Waypoints up to which one duration for all pieces is as good: through random ones the motion lasts as long,
for less CPU; through five it lasts 5 % longer, through 30 a third.
"""
CROWDING = 0.8
"""Relative shortness of the pieces at the ends: 0 for equal ones, below 1."""


def _solver() -> Sqp:
    return Sqp(
        penalty=3.0,
        penalty_rounds=3,
        max_iterations=40,
        relative_gain=1e-3,
        trust_region=TrustRegion(radius=0.1, largest=0.5),
    )


def _solver_through_waypoints() -> Sqp:
    # The seed rests at each waypoint, so it is farther from the solution.
    return replace(_solver(), max_iterations=100, trust_region=TrustRegion(radius=0.3))


@dataclass(frozen=True)
class FreeDuration:
    """Minimises the duration under limits of velocity, acceleration, jerk and torque.

    The timed path of sequential QP over knots remains if nothing faster is found.
    """

    pieces: int = 64
    solver: Sqp = field(default_factory=_solver)
    through_waypoints: Sqp = field(default_factory=_solver_through_waypoints)
    seed: Knots = field(default_factory=Knots)
    name: str = "free-duration"

    def objection(self, problem: Problem) -> str:
        """Accept a start in motion with limits of tool speeds: the motion that brakes first holds them."""
        if problem.tool_speeds and not problem.starts_moving:
            return "holds no limits of tool speeds"
        return followed_curve(problem) or windowed_differences(problem)

    def program(
        self, problem: Problem, seed: Floats, waypoint_knots: Sequence[int] = ()
    ) -> "FreeDurationProgram":
        first = self.seed.program(problem, seed, waypoint_knots)
        stop = stopping_motion(problem) if problem.starts_moving else None
        if stop is not None:
            first = first.starting_at(stop.positions[-1])
        return FreeDurationProgram(self, problem, first, tuple(waypoint_knots), stop)


@dataclass(frozen=True, eq=False)
class MovingResult(SolveResult):
    """Result of a program that determines time too."""

    decoded: Decoded


@dataclass(frozen=True, eq=False)
class FreeDurationProgram(Printed):
    """A problem, first over knots, then over control points and duration."""

    method: FreeDuration
    problem: Problem
    first: KnotsProgram
    waypoint_knots: tuple[int, ...]
    stop: Trajectory | None = None

    @property
    def scale(self) -> Floats:
        return self.first.scale

    @property
    def counts(self) -> WorkCounts:
        return self.first.counts

    def solve(self, seed: Floats, *, progress: Progress | None = None) -> SolveResult:
        """Solve over knots; if the stopping point cannot be left, `improve` begins at the start itself."""
        if self.stop is None:
            return self.first.solve(seed, progress=progress)
        begin, rest = self.stop.positions[[0, -1]]
        ever_less = np.linspace(1.0, 0.0, len(seed))[:, None]
        solved = self.first.solve(seed + ever_less * (rest - seed[0]), progress=progress)
        if not solved.feasible:
            from_start = self.first.starting_at(begin)
            return from_start.solve(seed + ever_less * (begin - seed[0]), progress=progress)
        (onward,) = self.first.decode(solved)
        smooth = with_jerk(self.problem.limits)
        timed = retime_path(
            self.problem,
            onward.path,
            through=onward.waypoint_knots,
            tolerance=SEED_TOLERANCE,
            limits=smooth,
        )
        if isinstance(timed, RetimeFailure):
            return solved
        knots = np.concatenate((self.stop.positions[:-1], onward.path.knots))
        decoded = replace(
            onward, path=replace(onward.path, knots=knots), trajectory=self.stop.followed_by(timed.trajectory)
        )
        return MovingResult(solved.status, solved.x, solved.at, solved.log, decoded)

    def improve(
        self, solved: SolveResult, motion: Trajectory, *, progress: Progress | None = None
    ) -> SolveResult:
        (path,) = (item.path for item in self.first.decode(solved))
        if len(self.waypoint_knots) > FEW and self.stop is None:
            return self._through_waypoints(path, progress)
        nlp = self._program(path, motion, self._rested(solved))
        control = nlp.fitted(*_samples(nlp.spline.basis, motion))
        x0 = np.hstack((control, np.ones((len(control), 1))))
        freed = self.method.solver.solve(nlp, x0, progress=progress)
        decoded = Decoded(nlp.spline.decode(freed.x[:, :-1]), nlp.decode(freed.x) if freed.feasible else None)
        return MovingResult(freed.status, freed.x, freed.at, freed.log, decoded)

    def _through_waypoints(self, path: Path, progress: Progress | None) -> SolveResult:
        """Improve from rests at all waypoints, with a time of passing of its own for each."""
        nlp, seed = FreeBreaksNlp.through(self.first.nlp, path.knots, self._dynamics, self.method.pieces)
        freed = self.method.through_waypoints.solve(nlp, seed, progress=progress)
        motion = nlp.decode(freed.x) if freed.feasible else None
        decoded = Decoded(Path(path.joint_names, nlp.motion(freed.x, freed.at.sampling).positions), motion)
        return MovingResult(freed.status, freed.x, freed.at, freed.log, decoded)

    @property
    def _dynamics(self) -> DynamicsQuery | None:
        limited = np.isfinite(self.problem.limits.effort).any()
        return DynamicsQuery.loaded(self.problem.reduced) if limited else None

    def decode(self, solved: SolveResult) -> Sequence[Decoded]:
        return (solved.decoded,) if isinstance(solved, MovingResult) else self.first.decode(solved)

    def _rested(self, solved: SolveResult) -> float:
        return self.stop.duration if self.stop is not None and isinstance(solved, MovingResult) else 0.0

    def _program(self, path: Path, motion: Trajectory, begin: float) -> FreeDurationNlp:
        problem, base = self.problem, self.first.nlp
        places = KnotPlaces.along(path.knots, motion, self.waypoint_knots, begin)
        spline = over_control_points(base, _basis(self.method.pieces), places, resting=RESTING)
        spline.lower[-RESTING:] = spline.upper[-RESTING:] = path.knots[-1]
        if self.stop is not None:
            spline.lower[0] = spline.upper[0] = self.stop.positions[0]
            spline.lower[1:RESTING], spline.upper[1:RESTING] = base.lower[1], base.upper[1]
        begins = problem.start_velocities, problem.start_accelerations
        return FreeDurationNlp(spline, problem.limits, motion.duration, self._dynamics, *begins)


def _basis(pieces: int) -> SplineBasis:
    even = np.linspace(0.0, 1.0, pieces + 1)
    return SplineBasis(3, even - np.sin(2.0 * np.pi * even) / (2.0 * np.pi) * CROWDING)


def _samples(basis: SplineBasis, motion: Trajectory) -> tuple[Floats, Floats]:
    parameters = basis.parameters(np.full(len(basis.breaks) - 1, SAMPLES))
    return parameters, motion(parameters * motion.duration)
