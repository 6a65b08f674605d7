"""Try: what one first guess came to."""

from dataclasses import dataclass

from trajopt.infeasibility.reasons import Block
from trajopt.planning.seeds import SeedKind
from trajopt.planning.status import Status
from trajopt.solvers import SolverStatus


@dataclass(frozen=True)
class Try:
    """One first guess, optimised, timed and judged as far as it got.

    Attributes:
        number: Its place in the order of tries, from 1.
        kind: Where the first guess came from.
        status: How the try ended.
        solver: How the solver ended, if it got so far.
        message: The particulars: what could not be satisfied, where and by how much.
        iterations: Steps of the solver.
        block: What stood in its way most; None if nothing did, or nothing that has a place.
        goal_name: Of a goal set: the goal it was for.
    """

    number: int
    kind: SeedKind
    status: Status
    solver: SolverStatus | None
    message: str
    iterations: int
    block: Block | None = None
    goal_name: str = ""

    def as_dict(self) -> dict[str, object]:
        """Return plain data that JSON can hold."""
        return {
            "number": self.number,
            "kind": self.kind.name,
            "status": self.status.name,
            "solver": None if self.solver is None else self.solver.name,
            "message": self.message,
            "iterations": self.iterations,
            "block": None if self.block is None else self.block.as_dict(),
            "goal_name": self.goal_name,
        }

    def __str__(self) -> str:
        """Say it in a line."""
        goal = f" of {self.goal_name!r}" if self.goal_name else ""
        said = f": {self.message}" if self.message else ""
        return f"try {self.number}, {self.kind.value}{goal}: {self.status.name}{said}"
