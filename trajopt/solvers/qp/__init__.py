"""QP backends behind one interface: setup once a pattern, update values, solve."""

from collections.abc import Mapping
from importlib import import_module

from trajopt.solvers.qp.backend import Qp as Qp
from trajopt.solvers.qp.backend import QpBackend as QpBackend
from trajopt.solvers.qp.backend import QpSolution as QpSolution
from trajopt.solvers.qp.backend import QpStatus as QpStatus
from trajopt.solvers.qp.checked import Checked as Checked

NATIVE: Mapping[str, tuple[str, str]] = {
    "piqp": ("trajopt.solvers.qp.piqp", "Piqp"),
    "osqp": ("trajopt.solvers.qp.osqp", "Osqp"),
    "proxqp": ("trajopt.solvers.qp.proxqp", "Proxqp"),
    "proxqp-dense": ("trajopt.solvers.qp.proxqp", "DenseProxqp"),
}
"""Module and class of the backends that are driven directly; their packages come with trajopt."""

GENERAL: Mapping[str, str] = {
    "clarabel": "clarabel",
    "daqp": "daqp",
    "highs": "highspy",
    "qpalm": "qpalm",
    "quadprog": "quadprog",
    "scs": "scs",
}
"""Backends that are driven through qpsolvers, and the package of each; all in the extra `qp`."""

BACKENDS = (*NATIVE, *GENERAL)
"""Names of the backends that are known; any other that qpsolvers finds installed works too."""


def qp_backend(name: str) -> QpBackend:
    """Return a fresh backend by name, its answers checked; only its own package is imported.

    Raises:
        MissingExtra: If it is known and not installed.
        SolverNotFound: If neither trajopt nor qpsolvers knows it.
    """
    if name in NATIVE:
        module, backend = NATIVE[name]
        return Checked(getattr(import_module(module), backend)())
    from trajopt.solvers.qp.generic import Generic

    return Checked(Generic(name))
