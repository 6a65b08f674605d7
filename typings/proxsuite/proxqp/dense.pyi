"""Types of what trajopt uses of proxsuite 0.8.0's dense backend."""

import numpy as np
from numpy.typing import NDArray

from . import Results, Settings

class QP:
    settings: Settings
    @property
    def results(self) -> Results: ...
    def __init__(self, n: int, n_eq: int, n_in: int) -> None: ...
    def init(
        self,
        H: NDArray[np.float64] | None = None,
        g: NDArray[np.float64] | None = None,
        A: NDArray[np.float64] | None = None,
        b: NDArray[np.float64] | None = None,
        C: NDArray[np.float64] | None = None,
        l: NDArray[np.float64] | None = None,  # noqa: E741 (the library's name)
        u: NDArray[np.float64] | None = None,
    ) -> None: ...
    def solve(self) -> None: ...
