"""Methods turn a seed into a path or a motion."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Generic, Protocol, TypeVar, runtime_checkable

from trajopt.geometry import WorkCounts
from trajopt.optimise.solvers import Effort, Iteration, SolveResult
from trajopt.optimise.transcription.motion_nlp import MotionNlp
from trajopt.problem.problem import Problem
from trajopt.problem.requirements import FollowsCurve
from trajopt.values.arrays import Floats, Printed, Value
from trajopt.values.errors import shown
from trajopt.values.trajectory import Path, Trajectory

Progress = Callable[[Iteration], None]
"""Called after every step of a solver."""


@dataclass(frozen=True, eq=False)
class Decoded(Value):
    """Path or motion of a solver's result.

    Attributes:
        trajectory: The motion, if the method determines time too; None leaves time to retiming.
        narrow: Whether gaps are too narrow for the margins: little may be rounded off.
        waypoint_knots: Knots of the path that the motion passes through.
    """

    path: Path
    trajectory: Trajectory | None = None
    narrow: bool = False
    waypoint_knots: tuple[int, ...] = ()


class Program(Protocol):
    """A problem transcribed by a method; solved from any number of seeds."""

    @property
    def scale(self) -> Floats:
        """Ordinary step of each joint, shape (n,) [rad | m]; the unit in which seeds are bent."""
        ...

    @property
    def counts(self) -> WorkCounts:
        """The work done so far."""
        ...

    def solve(self, seed: Floats, *, progress: Progress | None = None) -> SolveResult:
        """Solve from a seed of knots, shape (N, n) [rad | m]."""
        ...

    def decode(self, solved: SolveResult) -> Sequence[Decoded]:
        """Return the motions of a result, best first; the next is used if the judge refuses one."""
        ...


N_co = TypeVar("N_co", bound=MotionNlp, covariant=True)


@dataclass(frozen=True, eq=False)
class NlpProgram(Printed, Generic[N_co]):
    """A program with variables of its own."""

    nlp: N_co

    @property
    def scale(self) -> Floats:
        return self.nlp.scale

    @property
    def counts(self) -> WorkCounts:
        return self.nlp.counts


@runtime_checkable
class SupportsEffort(Protocol):
    """A program whose solver can do less for a seed."""

    def with_effort(self, effort: Effort) -> Program:
        """Return the program whose `solve` does this work."""
        ...


@runtime_checkable
class SupportsImprovement(Program, Protocol):
    """A program that can make a motion faster than its path alone allows."""

    def improve(
        self, solved: SolveResult, motion: Trajectory, *, progress: Progress | None = None
    ) -> SolveResult:
        """Optimise shape and time together, from a motion."""
        ...


@runtime_checkable
class Method(Protocol):
    """A transcription with a solver; its fields are its options."""

    @property
    def name(self) -> str:
        """Name in reports."""
        ...

    def objection(self, problem: Problem) -> str:
        """Return why the method cannot plan this problem; empty if it can."""
        ...

    def program(self, problem: Problem, seed: Floats, waypoint_knots: Sequence[int] = ()) -> Program:
        """Transcribe a problem.

        Args:
            seed: Shape (N, n): the motion's duration is estimated from it.

        Raises:
            ProblemError: If a requirement does not fit this robot.
        """
        ...


def moving_start(problem: Problem) -> str:
    said = "starts from rest only: leave the method to planning, or take free-duration"
    return said if problem.starts_moving else ""


def followed_curve(problem: Problem) -> str:
    path = (*problem.requirements, *(part.required for part in problem.partial))
    curves = [item for item in path if isinstance(item, FollowsCurve)]
    return f"cannot follow the curve of {shown(curves[0].frame)}" if curves else ""
