"""Knots: joint positions at knots, solved by any solver of an `Nlp`, timed afterwards."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

from trajopt.arrays import Floats
from trajopt.errors.arguments import checked
from trajopt.methods.method import Decoded, NlpProgram, Progress, moving_start
from trajopt.problem import Problem
from trajopt.solvers import HasBriefForm, HasNearForm, Solver, SolveResult, Sqp
from trajopt.transcription import KnotsNlp, transcribe

SHARES = (0.4, 0.16, 0.064)
"""Shares of the margins beyond what is required that are tried where a gap is too narrow for all of them. The
last asks for half a millimetre or so: retiming rounds as much off the corners of a path."""


class NarrowResult(SolveResult):
    """A path through gaps that are too narrow for the margins."""


@checked
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

    @checked
    def program(self, problem: Problem, seed: Floats, waypoint_knots: Sequence[int] = ()) -> "KnotsProgram":
        """Transcribe a problem over knots; see `Method.program`."""
        return KnotsProgram(transcribe(problem, seed, waypoint_knots), self.solver)


@dataclass(frozen=True, eq=False)
class KnotsProgram(NlpProgram[KnotsNlp]):
    """A problem over knots and what solves it."""

    solver: Solver

    def solve(self, seed: Floats, *, progress: Progress | None = None) -> SolveResult:
        """Solve from a seed; see `Program.solve`.

        Where nothing but margins is missing in the end, a gap may be too narrow for them: then it goes on
        with smaller ones, never with less clearance than is required.
        """
        nlp, wide = self.nlp, self.solver.solve(self.nlp, seed, progress=progress)
        solved, log = wide, [*wide.log]
        for share in SHARES:
            if solved.feasible or not nlp.lacks_margin_only(solved.at):
                break
            nlp = self.nlp.keeping(share)
            solved = self.solver.solve(nlp, solved.x, progress=progress)
            log += solved.log
        if solved is wide:
            return wide
        if solved.feasible:
            return NarrowResult(solved.status, solved.x, solved.at, tuple(log))
        return replace(wide, log=tuple(log))

    def solve_near(self, seed: Floats, *, progress: Progress | None = None) -> SolveResult:
        """Solve from a seed that is nearly a solution; see `SupportsNearSeeds`."""
        solver = self.solver.near() if isinstance(self.solver, HasNearForm) else self.solver
        return replace(self, solver=solver).solve(seed, progress=progress)

    def solve_briefly(self, seed: Floats, *, progress: Progress | None = None) -> SolveResult:
        """Take a few steps, where the solver has a brief form, else all; see `SupportsEarlyStop`."""
        solver = self.solver.brief() if isinstance(self.solver, HasBriefForm) else self.solver
        return solver.solve(self.nlp, seed, progress=progress)

    def decode(self, solved: SolveResult) -> tuple[Decoded]:
        """Return the path through the knots; see `Program.decode`."""
        return (Decoded(self.nlp.decode(solved.x), narrow=isinstance(solved, NarrowResult)),)
