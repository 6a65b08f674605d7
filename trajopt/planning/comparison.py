"""Comparison of the motions to several goals, as rows of a table."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from math import isfinite

from trajopt.planning.status import Status

HEAD = ("goal", "duration [s]", "path length", "clearance [mm]", "status")


@dataclass(frozen=True)
class ComparedGoal:
    """What became of one goal of a set.

    Attributes:
        name: Its name.
        status: How planning to it ended.
        duration: Of the verified motion to it [s]; None where there is none.
        path_length: Of its path in joint space [rad | m].
        clearance: What is proven of the distance to everything that must keep apart [m]; infinite where there
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
    """Return the lines of a table, with its head; numbers stand to the right."""
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
