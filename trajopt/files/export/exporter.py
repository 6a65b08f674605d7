"""Exporter: the interface for writing a motion in one format."""

from dataclasses import dataclass
from pathlib import Path
from typing import Protocol, runtime_checkable

from trajopt.scene.reduced import ReducedModel
from trajopt.values.trajectory import Trajectory


@dataclass(frozen=True)
class Exported:
    """A written file."""

    path: Path
    points: int
    duration: float
    notes: tuple[str, ...]

    def __str__(self) -> str:
        lines = [f"{self.path}: {self.points} points, {self.duration:.3f} s"]
        return "\n".join([*lines, *(f"  {note}" for note in self.notes)])

    def as_dict(self) -> dict[str, object]:
        """Return plain data for JSON."""
        return {
            "file": str(self.path),
            "points": self.points,
            "duration": self.duration,
            "notes": list(self.notes),
        }


@runtime_checkable
class Exporter(Protocol):
    """Writes a motion in one format; each exporter has its own options."""

    def write(self, trajectory: Trajectory, path: Path, hz: float | None) -> Exported:
        """Write a motion."""
        ...


@runtime_checkable
class ModelExporter(Exporter, Protocol):
    """An exporter that writes robot and scene too, if the motion comes with them."""

    def with_model(self, reduced: ReducedModel) -> Exporter:
        """Return the exporter for a robot and its scene."""
        ...
