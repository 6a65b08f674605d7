"""Methods by name, for the command line and for comparisons."""

from collections.abc import Callable, Mapping
from functools import partial

from trajopt.optimise.methods.bspline import Bspline
from trajopt.optimise.methods.free_duration import FreeDuration
from trajopt.optimise.methods.knots import Knots
from trajopt.optimise.methods.method import Method
from trajopt.optimise.methods.space_time import SpaceTime
from trajopt.optimise.solvers import Chomp, Sqp, Stomp
from trajopt.optimise.solvers.qp import BACKENDS
from trajopt.values.errors import ProblemError, SolverNotFound, shown
from trajopt.values.errors.arguments import checked

GROUP = "trajopt.methods"
"""The entry-point group that names methods, so any package can add some."""


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
"""Name of each method that comes with trajopt -> what makes it with its default options."""


def method_names() -> tuple[str, ...]:
    """Return the names of all methods: those that come with trajopt, then those of other packages."""
    from importlib.metadata import entry_points

    installed = {entry.name for entry in entry_points(group=GROUP)}
    return (*METHODS, *sorted(installed - set(METHODS)))


@checked
def method_named(name: str) -> Method:
    """Return a method with its default options.

    Names that do not come with trajopt are those of the entry-point group `trajopt.methods`: of a class
    or function that returns a `Method` when called without arguments.

    Raises:
        SolverNotFound: If there is none of that name.
    """
    from importlib.metadata import entry_points

    if name in METHODS:
        return METHODS[name]()
    installed = {entry.name: entry for entry in entry_points(group=GROUP)}
    if name not in installed:
        raise SolverNotFound("method", name, {*METHODS, *installed})
    return installed[name].load()()


def method_of(method: Method | str | None) -> Method:
    """Return the method that an argument stands for; for None, sequential QP over knots.

    Raises:
        SolverNotFound: If there is none of that name.
        ProblemError: If it is neither a method nor a name.
    """
    if isinstance(method, str):
        return method_named(method)
    if not isinstance(method, Method | None):  # pyright: ignore[reportUnnecessaryIsInstance]
        raise ProblemError(f"method is a Method or the name of one, is {shown(method)}")
    return method or Knots()
