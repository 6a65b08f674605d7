"""Knots: joint positions at knots, solved by any solver of an `Nlp`, timed afterwards."""

from collections.abc import Sequence
from dataclasses import dataclass, field

from trajopt.arrays import Floats, Printed
from trajopt.methods.method import Decoded, Progress, moving_start
from trajopt.problem import Problem
from trajopt.query import Counts
from trajopt.solvers import HasBriefForm, Solver, SolveResult, Sqp
from trajopt.transcription import KnotsNlp, transcribe


@dataclass(frozen=True)
class Knots:
    """The method that planning uses unless told otherwise: sequential QP over knots.

    Attributes:
        solver: Any solver of an `Nlp`, with its options.
    """

    solver: Solver = field(default_factory=Sqp)

    @property
    def name(self) -> str:
        """What it is called in reports."""
        return self.solver.name

    def objection(self, problem: Problem) -> str:
        """Refuse a start in motion; every term has rows over knots."""
        return moving_start(problem)

    def program(self, problem: Problem, seed: Floats, waypoint_knots: Sequence[int] = ()) -> "KnotsProgram":
        """Transcribe a problem over knots; see `Method.program`."""
        return KnotsProgram(transcribe(problem, seed, waypoint_knots), self.solver)


@dataclass(frozen=True, eq=False)
class KnotsProgram(Printed):
    """A problem over knots and what solves it."""

    nlp: KnotsNlp
    solver: Solver

    @property
    def scale(self) -> Floats:
        """A step of ordinary size, shape (n,) [rad | m]."""
        return self.nlp.scale

    @property
    def counts(self) -> Counts:
        """The work done so far."""
        return self.nlp.counts

    def solve(self, seed: Floats, *, progress: Progress | None = None) -> SolveResult:
        """Solve from a seed; see `Program.solve`."""
        return self.solver.solve(self.nlp, seed, progress=progress)

    def solve_briefly(self, seed: Floats, *, progress: Progress | None = None) -> SolveResult:
        """Take a few steps, where the solver has a brief form, else all; see `SupportsEarlyStop`."""
        solver = self.solver.brief() if isinstance(self.solver, HasBriefForm) else self.solver
        return solver.solve(self.nlp, seed, progress=progress)

    def decode(self, solved: SolveResult) -> tuple[Decoded]:
        """Return the path through the knots; see `Program.decode`."""
        return (Decoded(self.nlp.decode(solved.x)),)
