"""Types of what trajopt uses of osqp 1.1: the solver object, its status codes and results."""

from enum import IntEnum

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_matrix

class SolverStatus(IntEnum):
    OSQP_SOLVED = ...
    OSQP_SOLVED_INACCURATE = ...
    OSQP_MAX_ITER_REACHED = ...

class _Info:
    status_val: int
    iter: int

class _Results:
    x: NDArray[np.float64]
    y: NDArray[np.float64]
    info: _Info

class OSQP:
    def __init__(self) -> None: ...
    def setup(
        self,
        P: csc_matrix[np.float64],
        q: NDArray[np.float64],
        A: csc_matrix[np.float64],
        l: NDArray[np.float64],  # noqa: E741 (the library's name)
        u: NDArray[np.float64],
        *,
        eps_abs: float = ...,
        eps_rel: float = ...,
        max_iter: int = ...,
        polishing: bool = ...,
        verbose: bool = ...,
    ) -> None: ...
    def update(
        self,
        *,
        q: NDArray[np.float64] = ...,
        l: NDArray[np.float64] = ...,  # noqa: E741 (the library's name)
        u: NDArray[np.float64] = ...,
        Px: NDArray[np.float64] = ...,
        Ax: NDArray[np.float64] = ...,
    ) -> None: ...
    def solve(self, raise_error: bool | None = None) -> _Results: ...
