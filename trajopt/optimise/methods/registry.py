"""Methods by name, and the default method of a problem."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial

from trajopt.optimise.methods.bspline import Bspline
from trajopt.optimise.methods.free_duration import FreeDuration
from trajopt.optimise.methods.knots import Knots
from trajopt.optimise.methods.method import Method
from trajopt.optimise.methods.space_time import SpaceTime
from trajopt.optimise.solvers import Chomp, Sqp, Stomp
from trajopt.optimise.solvers.qp import BACKENDS
from trajopt.problem.problem import Problem
from trajopt.values.arrays import Value, one_of
from trajopt.values.errors import ProblemError, SolverNotFound, shown
from trajopt.values.errors.arguments import checked

GROUP = "trajopt.methods"
"""Entry-point group through which packages add methods."""


def _sqp(backend: str) -> Method:
    return Knots(Sqp(qp=backend))


def _casadi(plugin: str) -> Method:
    from trajopt.optimise.methods.casadi import knots  # it takes a while to import

    solvers = {"ipopt": knots.ipopt, "fatrop": knots.fatrop, "sqpmethod": knots.sqpmethod}
    return knots.CasadiKnots(solvers[plugin]())


METHODS: Mapping[str, Callable[[], Method]] = {
    "sqp": Knots,
    **{f"sqp-{backend}": partial(_sqp, backend) for backend in BACKENDS},
    "chomp": lambda: Knots(Chomp()),
    "stomp": lambda: Knots(Stomp()),
    "ipopt": partial(_casadi, "ipopt"),
    "fatrop": partial(_casadi, "fatrop"),
    "sqpmethod": partial(_casadi, "sqpmethod"),
    "bspline": Bspline,
    "free-duration": FreeDuration,
    "space-time": SpaceTime,
}
"""Name of each method of trajopt -> factory with default options."""


def method_names() -> tuple[str, ...]:
    """Return the names of all methods: trajopt's own, then those of other packages."""
    from importlib.metadata import entry_points

    installed = {entry.name for entry in entry_points(group=GROUP)}
    return (*METHODS, *sorted(installed - set(METHODS)))


@checked
def method_named(name: str) -> Method:
    """Return a method with its default options.

    Each entry of the group `trajopt.methods` is a class or function that returns a `Method` when called
    without arguments.

    Raises:
        SolverNotFound: If the name is unknown.
    """
    from importlib.metadata import entry_points

    if name in METHODS:
        return METHODS[name]()
    installed = {entry.name: entry for entry in entry_points(group=GROUP)}
    if name not in installed:
        raise SolverNotFound("method", name, {*METHODS, *installed})
    return installed[name].load()()


def method_of(method: Method | str | None) -> Method:
    """Return the method of an argument; for None, sequential QP over knots.

    Raises:
        SolverNotFound: If the name is unknown.
        ProblemError: If it is neither a method nor a name.
    """
    if isinstance(method, str):
        return method_named(method)
    if not isinstance(method, Method | None):  # pyright: ignore[reportUnnecessaryIsInstance]
        raise ProblemError(f"method is a Method or the name of one, is {shown(method)}")
    return method or Knots()


@dataclass(frozen=True, eq=False)
class Choice(Value):
    """A method, and the reason for its choice.

    Attributes:
        because: Reason, if planning chose it; empty if requested or the default.
    """

    method: Method
    because: str = ""

    def objection(self, problem: Problem) -> str:
        words = self.method.objection(problem)
        if not words:
            return ""
        name = self.method.name
        return f"{self.because}, but {name} {words}" if self.because else f"{name}: {words}"


def choose(problem: Problem, method: Method | str | None, *, improve: bool = False) -> Choice:
    """Return the requested method, or one that can plan the problem.

    Args:
        method: None leaves the choice to the problem.
        improve: Whether shape and time of each path are to be optimised together too.

    Raises:
        SolverNotFound: If the name is unknown.
        ProblemError: If it is neither a method nor a name, or is to be improved and is not over knots.
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
