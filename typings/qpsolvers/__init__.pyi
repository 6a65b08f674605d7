"""Types of what trajopt uses of qpsolvers 4.13, whose own leave out the type of an argument."""

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_matrix

available_solvers: list[str]
sparse_solvers: list[str]

class Problem:
    def __init__(
        self,
        P: NDArray[np.float64] | csc_matrix[np.float64],
        q: NDArray[np.float64],
        G: NDArray[np.float64] | csc_matrix[np.float64] | None = None,
        h: NDArray[np.float64] | None = None,
        A: NDArray[np.float64] | csc_matrix[np.float64] | None = None,
        b: NDArray[np.float64] | None = None,
        lb: NDArray[np.float64] | None = None,
        ub: NDArray[np.float64] | None = None,
    ) -> None: ...

class Solution:
    found: bool | None
    x: NDArray[np.float64] | None
    y: NDArray[np.float64] | None
    z: NDArray[np.float64] | None
    z_box: NDArray[np.float64] | None

def solve_problem(problem: Problem, solver: str, **options: float) -> Solution: ...
