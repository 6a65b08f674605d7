"""Types of what trajopt uses of proxsuite 0.8.0's sparse backend."""

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_matrix

from . import Results, Settings

class QP:
    settings: Settings
    @property
    def results(self) -> Results: ...
    def __init__(self, n: int, n_eq: int, n_in: int) -> None: ...
    def init(
        self,
        H: csc_matrix[np.float64] | None = None,
        g: NDArray[np.float64] | None = None,
        A: csc_matrix[np.float64] | None = None,
        b: NDArray[np.float64] | None = None,
        C: csc_matrix[np.float64] | None = None,
        l: NDArray[np.float64] | None = None,  # noqa: E741 (the library's name)
        u: NDArray[np.float64] | None = None,
    ) -> None: ...
    def solve(self) -> None: ...
