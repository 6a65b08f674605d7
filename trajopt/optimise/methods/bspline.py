"""Control points of a spline through joint space, by sequential QP, timed afterwards."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from trajopt.optimise.methods.method import Decoded, NlpProgram, Progress, followed_curve, moving_start
from trajopt.optimise.solvers import Solver, SolveResult, Sqp
from trajopt.optimise.terms import Acceleration, Jerk, Velocity
from trajopt.optimise.transcription import transcribe
from trajopt.optimise.transcription.bspline import (
    BsplineNlp,
    KnotPlaces,
    SplineBasis,
    fitted,
    over_control_points,
)
from trajopt.problem.problem import Problem
from trajopt.problem.residual import WHOLE
from trajopt.values.arrays import Floats
from trajopt.values.errors import ProblemError, shown

DEGREES = (3, 5)
"""Degrees offered: continuous curvature, and continuous fourth derivative."""
SAMPLES = 4
"""Samples of each segment of the seed, to fit the spline to."""


@dataclass(frozen=True)
class Bspline:
    """A smooth path of degree 3 or 5, within the joint limits since its control points are."""

    pieces: int = 24
    degree: int = 3
    solver: Solver = field(default_factory=Sqp)
    name: str = "bspline"

    def __post_init__(self) -> None:
        if self.degree not in DEGREES:
            raise ProblemError(f"the degree of a spline is 3 or 5, not {self.degree}")
        if self.pieces < 1:
            raise ProblemError(f"a spline needs at least one piece, not {self.pieces}")

    def objection(self, problem: Problem) -> str:
        return moving_start(problem) or followed_curve(problem) or windowed_differences(problem)

    def program(self, problem: Problem, seed: Floats, waypoint_knots: Sequence[int] = ()) -> "BsplineProgram":
        base = transcribe(problem, seed, waypoint_knots)
        basis = SplineBasis(self.degree, np.linspace(0.0, 1.0, self.pieces + 1))
        ends, last = np.array((0.0, 1.0)), problem.knots - 1
        places = KnotPlaces(ends, last * ends, np.array(waypoint_knots, dtype=np.float64) / last)
        return BsplineProgram(over_control_points(base, basis, places), self.solver)


def windowed_differences(problem: Problem) -> str:
    for cost in problem.costs or ():
        if isinstance(cost.residual, Velocity | Acceleration | Jerk) and cost.window != WHOLE:
            name = shown(cost.residual.name)
            return f"cost {name} is of a part of the motion only, which control points cannot state"
    return ""


@dataclass(frozen=True, eq=False)
class BsplineProgram(NlpProgram[BsplineNlp]):
    """A problem over control points and its solver."""

    solver: Solver

    def solve(self, seed: Floats, *, progress: Progress | None = None) -> SolveResult:
        segments = len(seed) - 1
        polyline = SplineBasis(1, np.linspace(0.0, 1.0, segments + 1))
        parameters = polyline.parameters(np.full(segments, SAMPLES))
        control = fitted(self.nlp.basis, parameters, polyline.at(parameters)(seed), resting=1)
        return self.solver.solve(self.nlp, control, progress=progress)

    def decode(self, solved: SolveResult) -> tuple[Decoded]:
        return (Decoded(self.nlp.decode(solved.x)),)
