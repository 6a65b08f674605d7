"""The structured QP of a step; see `trajopt.optimise.solvers.subproblem`."""

from trajopt.values.arrays import Bools, Floats, Ints

class Program:
    """Squared costs, and linear rows whose excess is penalised."""

    def __init__(self, joints: int, moves: Bools) -> None: ...
    def add_squared(self, value: Floats, jacobian: Floats, knots: Ints, weight: Floats) -> None: ...
    def add_excess(
        self, value: Floats, jacobian: Floats, knots: Ints, lower: Floats, upper: Floats, penalty: Floats
    ) -> None: ...
    def solve(
        self, lower: Floats, upper: Floats, regularisation: float, accuracy: float, max_iterations: int
    ) -> tuple[Floats, float, int, int]: ...
    @property
    def rows(self) -> int: ...
