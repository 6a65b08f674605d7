"""Choice: the method that plans a problem, where the caller leaves it to planning."""

from dataclasses import dataclass

from trajopt.optimise.methods.free_duration import FreeDuration
from trajopt.optimise.methods.knots import Knots
from trajopt.optimise.methods.method import Method
from trajopt.optimise.methods.registry import method_of
from trajopt.problem.problem import Problem
from trajopt.values.arrays import Value, one_of
from trajopt.values.errors import ProblemError


@dataclass(frozen=True, eq=False)
class Choice(Value):
    """A method, and why planning took it.

    Attributes:
        method: The method.
        because: Why, where planning chose it itself; empty where it was asked for, or is the default.
    """

    method: Method
    because: str = ""

    def objection(self, problem: Problem) -> str:
        """Say why the problem cannot be planned with it; empty if it can."""
        words = self.method.objection(problem)
        if not words:
            return ""
        name = self.method.name
        return f"{self.because}, but {name} {words}" if self.because else f"{name}: {words}"


def choose(problem: Problem, method: Method | str | None, *, improve: bool = False) -> Choice:
    """Return the method for a problem: the one asked for, or the one that can.

    Args:
        problem: The problem.
        method: What the caller asks for; None leaves it to the problem.
        improve: Whether shape and time of each path are to be optimised together as well.

    Raises:
        SolverNotFound: If there is no method of that name.
        ProblemError: If it is neither a method nor a name, or is to be improved and is none over knots.
    """
    one_of("problem", problem, Problem)
    if one_of("improve", improve, bool):
        first = method_of(method)
        if isinstance(first, FreeDuration):
            return Choice(first)
        if not isinstance(first, Knots):
            raise ProblemError(
                f"improve goes on from a path over knots, and {first.name} has none: leave one out"
            )
        return Choice(FreeDuration(seed=first), "a shorter motion than along the path was asked for")
    if method is None and problem.starts_moving:
        # Who replans on the way needs the answer soon; as many pieces as the path has knots bend as finely.
        freed = FreeDuration(pieces=problem.knots)
        return Choice(freed, f"the start is in motion, which only {freed.name} takes")
    return Choice(method_of(method))
