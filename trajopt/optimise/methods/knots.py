"""Joint positions at knots, solved by any solver of an `Nlp`, timed afterwards."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial

import numpy as np

from trajopt.geometry import WorkCounts
from trajopt.optimise.methods.method import Decoded, Progress, moving_start
from trajopt.optimise.solvers import Effort, HasEfforts, Iteration, Solver, SolveResult, SolverStatus, Sqp
from trajopt.optimise.transcription import KnotsNlp, transcribe, transcribe_covered
from trajopt.problem.problem import Problem
from trajopt.values.arrays import Floats, Printed
from trajopt.values.errors.arguments import checked

SHARES = (0.4, 0.16, 0.064, 0.0256)
"""Shares of the excess margins to try in narrow gaps. The last leaves a quarter of a millimetre: corners that
retiming rounds off are of the size of the third.
"""


class NarrowResult(SolveResult):
    """A path through gaps too narrow for the margins."""


@checked
@dataclass(frozen=True)
class Knots:
    """Default method: sequential QP over knots."""

    solver: Solver = field(default_factory=Sqp)

    @property
    def name(self) -> str:
        return self.solver.name

    def objection(self, problem: Problem) -> str:
        return moving_start(problem)

    @checked
    def program(self, problem: Problem, seed: Floats, waypoint_knots: Sequence[int] = ()) -> "KnotsProgram":
        counts = WorkCounts()
        covered = transcribe_covered(problem, seed, waypoint_knots, counts)
        if covered is not None:
            later = partial(transcribe, problem, seed, waypoint_knots, counts)
            return KnotsProgram(counts, self.solver, covered, later)
        nlp = transcribe(problem, seed, waypoint_knots, counts)
        return KnotsProgram(counts, self.solver, None, lambda: nlp)


@dataclass(frozen=True, eq=False)
class KnotsProgram(Printed):
    """A problem over knots and its solver.

    Attributes:
        covered: The problem with boxes in place of clouds, which is tried first, if there are any.
        shares: Shares of the excess margins to try if only margins are violated.
    """

    counts: WorkCounts
    solver: Solver
    covered: KnotsNlp | None
    transcribed: Callable[[], KnotsNlp] = field(repr=False)
    shares: tuple[float, ...] = SHARES

    @cached_property
    def nlp(self) -> KnotsNlp:
        return self.transcribed()

    @property
    def scale(self) -> Floats:
        return (self.covered or self.nlp).scale

    def starting_at(self, positions: Floats) -> "KnotsProgram":
        covered = None if self.covered is None else self.covered.starting_at(positions)
        return replace(self, covered=covered, transcribed=lambda: self.nlp.starting_at(positions))

    def solve(self, seed: Floats, *, progress: Progress | None = None) -> SolveResult:
        """Solve with boxes around the clouds first, which are inside them.

        If only margins are violated in the end, smaller ones are tried, never below the required clearance;
        from the seed if it violates margins only: among obstacles nearer than these the least violation may
        be a collision.
        """
        log = list[Iteration]()
        if self.covered is not None:
            covered = self.covered
            beside = replace(self, covered=None, transcribed=lambda: covered).solve(seed, progress=progress)
            if beside.feasible:
                return beside
            log += beside.log
        nlp, wide = self.nlp, self.solver.solve(self.nlp, seed, progress=progress)
        solved = wide
        log += wide.log
        for share in self.shares:
            if solved.feasible:
                break
            begin = solved.x
            if not nlp.lacks_margin_only(solved.at):
                begin = np.clip(seed, nlp.lower, nlp.upper)
                if solved.status is SolverStatus.GIVEN_UP or not nlp.lacks_margin_only(
                    nlp.linearise(begin, nlp.sampling(begin, fine=False))
                ):
                    break
            nlp = self.nlp.keeping(share)
            solved = self.solver.solve(nlp, begin, progress=progress)
            log += solved.log
        if solved.feasible and solved is not wide:
            return NarrowResult(solved.status, solved.x, solved.at, tuple(log))
        return replace(wide, log=tuple(log))

    def with_effort(self, effort: Effort) -> "KnotsProgram":
        solver = self.solver.with_effort(effort) if isinstance(self.solver, HasEfforts) else self.solver
        same = replace(self, solver=solver, transcribed=lambda: self.nlp)
        return replace(same, covered=None, shares=()) if effort is Effort.BRIEF else same

    def decode(self, solved: SolveResult) -> tuple[Decoded]:
        nlp, narrow = self.covered or self.nlp, isinstance(solved, NarrowResult)
        return (Decoded(nlp.decode(solved.x), narrow=narrow, waypoint_knots=nlp.waypoint_knots),)
