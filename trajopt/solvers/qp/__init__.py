"""QP backends behind one interface: setup once a pattern, update values, solve."""

from collections.abc import Callable

from trajopt.solvers.qp.backend import Qp as Qp
from trajopt.solvers.qp.backend import QpBackend as QpBackend
from trajopt.solvers.qp.backend import QpSolution as QpSolution
from trajopt.solvers.qp.backend import QpStatus as QpStatus
from trajopt.solvers.qp.generic import Generic as Generic
from trajopt.solvers.qp.osqp import Osqp as Osqp
from trajopt.solvers.qp.piqp import Piqp as Piqp
from trajopt.solvers.qp.proxqp import Proxqp as Proxqp

NATIVE: dict[str, Callable[[], QpBackend]] = {"piqp": Piqp, "osqp": Osqp, "proxqp": Proxqp}
"""Backends that are driven directly; any other name goes through qpsolvers."""


def qp_backend(name: str) -> QpBackend:
    """Return a fresh backend by name.

    Raises:
        SolverNotFound: If it is neither native nor known to qpsolvers as installed.
    """
    return NATIVE[name]() if name in NATIVE else Generic(name)
