"""What an exporter is: it writes a motion in one format and says what the file holds and what it lost."""

from dataclasses import dataclass
from pathlib import Path
from typing import Protocol, runtime_checkable

from trajopt.values.trajectory import Trajectory


@dataclass(frozen=True)
class Exported:
    """A file that was written.

    Attributes:
        path: The file.
        points: Points of the motion in it.
        duration: Time that it takes as written [s].
        notes: What it holds, in which units, and what it loses of the planned motion.
    """

    path: Path
    points: int
    duration: float
    notes: tuple[str, ...]

    def __str__(self) -> str:
        """Return the file and its size, and a line for each note."""
        lines = [f"{self.path}: {self.points} points, {self.duration:.3f} s"]
        return "\n".join([*lines, *(f"  {note}" for note in self.notes)])

    def as_dict(self) -> dict[str, object]:
        """Return plain data that JSON can hold."""
        return {
            "file": str(self.path),
            "points": self.points,
            "duration": self.duration,
            "notes": list(self.notes),
        }


@runtime_checkable
class Exporter(Protocol):
    """Writes a motion in one format; its options are its own."""

    def write(self, trajectory: Trajectory, path: Path, hz: float | None) -> Exported:
        """Write a motion.

        Args:
            trajectory: The motion.
            path: The file, written in one step.
            hz: Samples per second; None for what suits the format.

        Raises:
            FileFormatError: If the file cannot be written.
            ShapeError: If the format has no place for the motion's joints, or the rate cannot be kept.
        """
        ...
