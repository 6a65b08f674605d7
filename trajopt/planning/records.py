"""Records of a result: the attempts of planning, and the goals of a set side by side."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from math import isfinite

from trajopt.optimise.solvers import SolverStatus
from trajopt.planning.infeasibility.reasons import Obstruction
from trajopt.planning.seeds import SeedKind
from trajopt.planning.status import Status
from trajopt.values.errors import shown


@dataclass(frozen=True)
class Attempt:
    """Record of one seed: optimised, timed and judged as far as it got.

    Attributes:
        number: Its number in the order of attempts, from 1.
        kind: Source of the seed.
        status: Status at the end of the attempt.
        solver: Status of the solver, if it got that far.
        message: The particulars: which constraint was violated, where and by how much.
        iterations: Steps of the solver.
        block: The main obstruction; None if there was none, or none with a location.
        goal_name: Of a goal set: its goal.
    """

    number: int
    kind: SeedKind
    status: Status
    solver: SolverStatus | None
    message: str
    iterations: int
    block: Obstruction | None = None
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
        """Return its number, the kind of its seed and its status."""
        steps = f"{self.iterations} step{'s' * (self.iterations != 1)}"
        return f"Attempt({self.number}, {self.kind.name}: {self.status.name} after {steps})"

    def __str__(self) -> str:
        """Return one line."""
        goal = f" of {shown(self.goal_name)}" if self.goal_name else ""
        message = f": {self.message}" if self.message else ""
        return f"attempt {self.number}, {self.kind.value}{goal}: {self.status.name}{message}"


HEAD = ("goal", "duration [s]", "path length", "clearance [mm]", "status")


@dataclass(frozen=True)
class ComparedGoal:
    """Result of one goal of a set.

    Attributes:
        name: Its name.
        status: Status of planning to it.
        duration: Of the verified motion to it [s]; None without.
        path_length: Of its path in joint space [rad | m].
        clearance: Proven distance to everything that must keep apart [m]; infinite if there
            is nothing.
    """

    name: str
    status: Status
    duration: float | None = None
    path_length: float | None = None
    clearance: float | None = None

    def as_dict(self) -> dict[str, object]:
        """Return plain data that JSON can hold."""
        known = self.clearance if self.clearance is not None and isfinite(self.clearance) else None
        return {**asdict(self), "status": self.status.name, "clearance": known}

    @property
    def cells(self) -> tuple[str, ...]:
        """The row of the table."""
        millimetres = None if self.clearance is None else 1000.0 * self.clearance
        numbers = ((self.duration, ".3f"), (self.path_length, ".3f"), (millimetres, ".1f"))
        told = ("-" if value is None or not isfinite(value) else f"{value:{form}}" for value, form in numbers)
        return self.name, *told, self.status.name


def table(goals: Sequence[ComparedGoal]) -> list[str]:
    """Return the lines of a table, with its head; numbers are aligned right."""
    rows = (HEAD, *(goal.cells for goal in goals))
    widths = [max(len(row[column]) for row in rows) for column in range(len(HEAD))]
    lines = (
        "  ".join(
            cell.rjust(width) if 0 < column < len(HEAD) - 1 else cell.ljust(width)
            for column, (cell, width) in enumerate(zip(row, widths, strict=True))
        )
        for row in rows
    )
    return [line.rstrip() for line in lines]
