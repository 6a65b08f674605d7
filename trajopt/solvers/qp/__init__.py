"""QP backends behind one interface: setup once a pattern, update values, solve."""

from importlib import import_module

from trajopt.solvers.qp.backend import Qp as Qp
from trajopt.solvers.qp.backend import QpBackend as QpBackend
from trajopt.solvers.qp.backend import QpSolution as QpSolution
from trajopt.solvers.qp.backend import QpStatus as QpStatus

NATIVE: dict[str, tuple[str, str]] = {
    "piqp": ("trajopt.solvers.qp.piqp", "Piqp"),
    "osqp": ("trajopt.solvers.qp.osqp", "Osqp"),
    "proxqp": ("trajopt.solvers.qp.proxqp", "Proxqp"),
}
"""Module and class of the backends that are driven directly; any other name goes through qpsolvers."""


def qp_backend(name: str) -> QpBackend:
    """Return a fresh backend by name; only its own package is imported.

    Raises:
        SolverNotFound: If it is neither native nor known to qpsolvers as installed.
    """
    if name in NATIVE:
        module, backend = NATIVE[name]
        return getattr(import_module(module), backend)()
    from trajopt.solvers.qp.generic import Generic

    return Generic(name)
