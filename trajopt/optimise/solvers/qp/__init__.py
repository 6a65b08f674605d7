"""QP backends behind one interface."""

from importlib import import_module

from trajopt.optimise.solvers.qp.backend import BACKENDS as BACKENDS
from trajopt.optimise.solvers.qp.backend import GENERAL as GENERAL
from trajopt.optimise.solvers.qp.backend import NATIVE as NATIVE
from trajopt.optimise.solvers.qp.backend import Qp as Qp
from trajopt.optimise.solvers.qp.backend import QpBackend as QpBackend
from trajopt.optimise.solvers.qp.backend import QpSolution as QpSolution
from trajopt.optimise.solvers.qp.backend import QpStatus as QpStatus
from trajopt.optimise.solvers.qp.backend import checked as checked


def qp_backend(name: str) -> QpBackend:
    if name in NATIVE:
        module, backend = NATIVE[name]
        return getattr(import_module(module), backend)()
    from trajopt.optimise.solvers.qp.generic import Generic

    return Generic(name)
