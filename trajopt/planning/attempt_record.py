"""What became of one attempt, as results keep it."""

from dataclasses import dataclass

from trajopt.optimise.solvers import SolverStatus
from trajopt.planning.infeasibility.reasons import Block
from trajopt.planning.seeds import SeedKind
from trajopt.planning.status import Status
from trajopt.values.errors import shown


@dataclass(frozen=True)
class Attempt:
    """What became of one seed: optimised, timed and judged as far as it got.

    Attributes:
        number: Its number in the order of attempts, from 1.
        kind: Where the seed came from.
        status: How the attempt ended.
        solver: How the solver ended, if it got so far.
        message: The particulars: what could not be satisfied, where and by how much.
        iterations: Steps of the solver.
        block: What stood in its way most; None if nothing did, or nothing with a location.
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

    def __repr__(self) -> str:
        """Say its number, the kind of its seed and how it ended."""
        steps = f"{self.iterations} step{'s' * (self.iterations != 1)}"
        return f"Attempt({self.number}, {self.kind.name}: {self.status.name} after {steps})"

    def __str__(self) -> str:
        """Return one line."""
        goal = f" of {shown(self.goal_name)}" if self.goal_name else ""
        message = f": {self.message}" if self.message else ""
        return f"attempt {self.number}, {self.kind.value}{goal}: {self.status.name}{message}"
