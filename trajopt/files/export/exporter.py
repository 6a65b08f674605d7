"""Interface of exporters."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol, runtime_checkable

from trajopt.planning.result import Result
from trajopt.problem.requirements import FollowsCurve, Requirement
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.scene import Scene
from trajopt.values.arrays import Value
from trajopt.values.errors.arguments import checked
from trajopt.values.placement import WORLD
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


@checked
@dataclass(frozen=True, eq=False)
class ProgramSection(Value):
    """One motion of a program, and the rest at its end.

    Attributes:
        curve: The curve that the motion follows; None without one.
        gripped: Objects attached to the robot at its end.
        released: Objects detached there.
    """

    title: str
    reduced: ReducedModel
    trajectory: Trajectory
    curve: FollowsCurve | None = None
    rest: float = 0.0
    gripped: tuple[str, ...] = ()
    released: tuple[str, ...] = ()

    @staticmethod
    @checked
    def between(title: str, result: Result, rest: float, after: Scene) -> "ProgramSection":
        """Return the section of a planned motion, with the scene after it."""
        plan = result.require()
        before, later = _held(plan.problem.scene), _held(after)
        return ProgramSection(
            title,
            plan.problem.reduced,
            plan.trajectory,
            curve_of(plan.problem.goals),
            rest,
            tuple(name for name in later if name not in before),
            tuple(name for name in before if name not in later),
        )


@checked
def curve_of(goals: Sequence[Requirement]) -> FollowsCurve | None:
    """Return the curve that a motion with these goals follows; None without one."""
    return next((goal for goal in goals if isinstance(goal, FollowsCurve)), None)


def _held(scene: Scene) -> tuple[str, ...]:
    return tuple(name for name in scene.objects if scene.holder(name).link != WORLD)


@runtime_checkable
class ProgramExporter(Exporter, Protocol):
    """An exporter that writes several motions as the sections of one program."""

    def write_program(self, sections: Sequence[ProgramSection], path: Path, hz: float | None) -> Exported:
        """Write motions, in order."""
        ...
