"""Free duration: shape and time of a motion optimised together, from the timed path of another method."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from trajopt.arrays import Floats, Printed
from trajopt.methods.bspline import SAMPLES, windowed_differences
from trajopt.methods.knots import Knots, KnotsProgram
from trajopt.methods.method import Decoded, Progress, followed_curve
from trajopt.methods.timing import retime_path
from trajopt.model.trajectory import Path, Trajectory
from trajopt.problem import Problem
from trajopt.query import Counts
from trajopt.query.dynamics import DynamicsQuery
from trajopt.retime import RetimeFailure
from trajopt.solvers import SolveResult, Sqp
from trajopt.solvers.sqp import TrustRegion
from trajopt.transcription.basis import SplineBasis, fitted
from trajopt.transcription.bspline import Places, over_control_points
from trajopt.transcription.free_duration import RESTING, FreeDurationNlp

SEED_TOLERANCE = 5e-3
"""How far the timed seed may leave its path [m]."""
CROWDING = 0.8
"""How much shorter the pieces at the ends are than those in the middle: 0 for equal ones, below 1."""


def _solver() -> Sqp:
    return Sqp(
        penalty=3.0,
        penalty_rounds=3,
        max_iterations=40,
        relative_gain=1e-3,
        trust_region=TrustRegion(radius=0.1, largest=0.5),
    )


@dataclass(frozen=True)
class FreeDuration:
    """Minimises the duration itself, under limits of velocity, acceleration, jerk and torque.

    A seed is made into a path by sequential QP over knots and timed; from that motion the shape
    and the time of a spline are optimised, and it is kept where nothing faster is found.

    Attributes:
        pieces: Polynomial pieces of the spline.
        solver: Of the program over control points and duration.
        seed: Makes the first motion.
    """

    pieces: int = 64
    solver: Sqp = field(default_factory=_solver)
    seed: Knots = field(default_factory=Knots)
    name: str = "free-duration"

    def objection(self, problem: Problem) -> str:
        """Refuse what has no rows over the spline."""
        if problem.tool_speeds:
            return "holds no limits of tool speeds"
        return followed_curve(problem) or windowed_differences(problem)

    def program(
        self, problem: Problem, seed: Floats, waypoint_knots: Sequence[int] = ()
    ) -> "FreeDurationProgram":
        """Transcribe the problem over knots first; see `Method.program`."""
        return FreeDurationProgram(
            self, problem, self.seed.program(problem, seed, waypoint_knots), tuple(waypoint_knots)
        )


@dataclass(frozen=True, eq=False)
class FreedResult(SolveResult):
    """What the program over control points and duration came to.

    Attributes:
        decoded: Its motion, then the path that it was found from.
    """

    decoded: tuple[Decoded, ...]


@dataclass(frozen=True, eq=False)
class FreeDurationProgram(Printed):
    """A problem, first over knots, then over control points and duration."""

    method: FreeDuration
    problem: Problem
    first: KnotsProgram
    waypoint_knots: tuple[int, ...]

    @property
    def scale(self) -> Floats:
        """A step of ordinary size, shape (n,) [rad | m]."""
        return self.first.scale

    @property
    def counts(self) -> Counts:
        """The work done so far."""
        return self.first.counts

    def solve(self, seed: Floats, *, progress: Progress | None = None) -> SolveResult:
        """Solve from a seed; see `Program.solve`."""
        first = self.first.solve(seed, progress=progress)
        if not first.feasible:
            return first
        (path,) = (item.path for item in self.first.decode(first))
        motion = retime_path(self.problem, path, tolerance=SEED_TOLERANCE)
        if isinstance(motion, RetimeFailure):
            return first
        freed = self._freed(first, path, motion.trajectory, progress)
        if self.problem.start_velocities.any():  # what starts from rest is no answer
            return replace(freed, decoded=freed.decoded[:1])
        faster = freed.decoded[0].trajectory
        return freed if faster is not None and faster.duration < motion.trajectory.duration else first

    def decode(self, solved: SolveResult) -> Sequence[Decoded]:
        """Return the motion, then the path that it was found from; see `Program.decode`."""
        return solved.decoded if isinstance(solved, FreedResult) else self.first.decode(solved)

    def _freed(
        self, first: SolveResult, path: Path, motion: Trajectory, progress: Progress | None
    ) -> "FreedResult":
        """Optimise shape and time, from a motion along a path."""
        nlp = self._program(path, motion)
        control = fitted(nlp.spline.basis, *_samples(nlp.spline.basis, motion), resting=RESTING)
        x0 = np.hstack((control, np.ones((len(control), 1))))
        solved = self.method.solver.solve(nlp, x0, progress=progress)
        trajectory = nlp.decode(solved.x) if solved.feasible else None
        decoded = Decoded(nlp.spline.decode(solved.x[:, :-1]), trajectory)
        log = (*first.log, *solved.log)
        return FreedResult(solved.status, solved.x, solved.at, log, (decoded, *self.first.decode(first)))

    def _program(self, path: Path, motion: Trajectory) -> FreeDurationNlp:
        reduced, base = self.problem.reduced, self.first.nlp
        spline = over_control_points(
            base, _basis(self.method.pieces), self._places(path, motion), resting=RESTING
        )
        spline.lower[-RESTING:] = spline.upper[-RESTING:] = path.knots[-1]
        limited = np.isfinite(self.problem.limits.effort).any()
        dynamics, moving = DynamicsQuery.loaded(reduced) if limited else None, self.problem.start_velocities
        if moving.any():
            spline.lower[1:RESTING], spline.upper[1:RESTING] = base.lower[1], base.upper[1]
        return FreeDurationNlp(spline, self.problem.limits, motion.duration, dynamics, moving)

    def _places(self, path: Path, motion: Trajectory) -> Places:
        """Say where on the path over knots the motion is: equal shares of their lengths."""
        legs = np.linalg.norm(np.diff(path.knots, axis=0), axis=1)
        lengths = np.concatenate((np.zeros(1), np.cumsum(legs))) / max(float(legs.sum()), 1e-12)
        # Knots that coincide are one place; the last of them is.
        times = np.linspace(0.0, motion.duration, 20 * len(legs))
        steps = np.linalg.norm(np.diff(motion(times), axis=0), axis=1)
        share = np.concatenate((np.zeros(1), np.cumsum(steps))) / max(float(steps.sum()), 1e-12)
        knots = np.interp(share, lengths, np.arange(len(lengths), dtype=np.float64))
        knots[0], knots[-1] = 0.0, float(len(legs))
        parameters = times / motion.duration
        exact = np.interp(np.array(self.waypoint_knots, dtype=np.float64), knots, parameters)
        return Places(parameters, knots, exact)


def _basis(pieces: int) -> SplineBasis:
    """Return cubic pieces, shorter towards both ends, where the acceleration has to rise from nothing."""
    even = np.linspace(0.0, 1.0, pieces + 1)
    return SplineBasis(3, even - np.sin(2.0 * np.pi * even) / (2.0 * np.pi) * CROWDING)


def _samples(basis: SplineBasis, motion: Trajectory) -> tuple[Floats, Floats]:
    parameters = basis.parameters(np.full(len(basis.breaks) - 1, SAMPLES))
    return parameters, motion(parameters * motion.duration)
