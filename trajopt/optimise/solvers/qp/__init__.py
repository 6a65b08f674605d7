"""QP backends behind one interface: setup once a pattern, update values, solve."""

from importlib import import_module

from trajopt.optimise.solvers.qp.backend import BACKENDS as BACKENDS
from trajopt.optimise.solvers.qp.backend import GENERAL as GENERAL
from trajopt.optimise.solvers.qp.backend import NATIVE as NATIVE
from trajopt.optimise.solvers.qp.backend import Checked as Checked
from trajopt.optimise.solvers.qp.backend import Qp as Qp
from trajopt.optimise.solvers.qp.backend import QpBackend as QpBackend
from trajopt.optimise.solvers.qp.backend import QpSolution as QpSolution
from trajopt.optimise.solvers.qp.backend import QpStatus as QpStatus


def qp_backend(name: str) -> QpBackend:
    if name in NATIVE:
        module, backend = NATIVE[name]
        return Checked(getattr(import_module(module), backend)())
    from trajopt.optimise.solvers.qp.generic import Generic

    return Checked(Generic(name))
