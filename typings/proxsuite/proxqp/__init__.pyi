"""Types of what trajopt uses of proxsuite 0.8.0's ProxQP: settings, results and their codes."""

from enum import Enum

import numpy as np
from numpy.typing import NDArray

from . import dense as dense
from . import sparse as sparse

class QPSolverOutput(Enum):
    PROXQP_SOLVED = ...
    PROXQP_MAX_ITER_REACHED = ...
    PROXQP_PRIMAL_INFEASIBLE = ...
    PROXQP_DUAL_INFEASIBLE = ...
    PROXQP_NOT_RUN = ...

class Settings:
    eps_abs: float
    eps_rel: float
    max_iter: int
    check_duality_gap: bool
    eps_duality_gap_abs: float
    eps_duality_gap_rel: float
    eps_primal_inf: float
    eps_dual_inf: float

class Info:
    status: QPSolverOutput
    iter: int

class Results:
    x: NDArray[np.float64]
    y: NDArray[np.float64]
    z: NDArray[np.float64]
    info: Info
