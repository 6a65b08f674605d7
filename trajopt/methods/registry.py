"""Methods by name, for the command line and for comparisons."""

from collections.abc import Callable, Mapping

from trajopt.errors import SolverNotFound
from trajopt.methods.knots import Knots
from trajopt.methods.method import Method
from trajopt.solvers import Sqp

METHODS: Mapping[str, Callable[[], Method]] = {
    "sqp": Knots,
    "sqp-piqp": lambda: Knots(Sqp(qp="piqp")),
    "sqp-osqp": lambda: Knots(Sqp(qp="osqp")),
    "sqp-proxqp": lambda: Knots(Sqp(qp="proxqp")),
}
"""Name of each method -> what makes it with its default options."""


def method_named(name: str) -> Method:
    """Return a method with its default options.

    Raises:
        SolverNotFound: If there is none of that name.
    """
    if name not in METHODS:
        raise SolverNotFound("method", name, METHODS)
    return METHODS[name]()
