"""Motions in the formats of controllers and logs."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, cast

from trajopt.files.export.exporter import Exported as Exported
from trajopt.files.export.exporter import Exporter as Exporter
from trajopt.files.export.exporter import ModelExporter as ModelExporter
from trajopt.files.export.exporter import ProgramExporter as ProgramExporter
from trajopt.files.export.exporter import ProgramSection as ProgramSection
from trajopt.files.export.exporter import curve_of
from trajopt.files.export.sampled import Csv as Csv
from trajopt.files.export.sampled import FollowJointTrajectory as FollowJointTrajectory
from trajopt.files.export.sampled import JointTrajectory as JointTrajectory
from trajopt.files.export.sampled import Mcap, Rerun
from trajopt.files.export.sampled import RobotTrajectoryMessage as RobotTrajectoryMessage
from trajopt.files.export.urscript import Movej as Movej
from trajopt.files.export.urscript import Servoj as Servoj
from trajopt.files.export.urscript import UrProgram as UrProgram
from trajopt.scene import reduced
from trajopt.scene.planned_robot import Planned, PlannedMotion, PlannedWhole
from trajopt.values import arrays
from trajopt.values.errors import NameNotFound, ProblemError, shown
from trajopt.values.trajectory import Trajectory

Motions = Planned[reduced.ReducedModel] | PlannedWhole[reduced.ReducedModel]
"""A plan, or a result of one or several motions."""
EXPORTERS: Mapping[str, Callable[[], Exporter]] = {
    "csv": Csv,
    "ros2": FollowJointTrajectory,
    "ros2-topic": JointTrajectory,
    "moveit": RobotTrajectoryMessage,
    "urscript": Servoj,
    "urscript-movej": Movej,
    "urscript-program": UrProgram,
    "mcap": Mcap,
    "rerun": Rerun,
}
"""Format name -> factory of its exporter with default options."""


def exporter_named(name: str) -> Exporter:
    """Return an exporter with its default options."""
    if not isinstance(name, str) or name not in EXPORTERS:  # pyright: ignore[reportUnnecessaryIsInstance]
        raise NameNotFound("format to export to", name, EXPORTERS)
    return EXPORTERS[name]()


def export(
    motion: Trajectory | Motions,
    path: Path | str,
    *,
    to: Exporter | str,
    hz: float | None = None,
) -> Exported:
    """Write a motion in the format of a controller or a viewer; return a summary with its losses.

    Args:
        motion: A plan, a successful result of one or several motions, or a trajectory.
        path: Messages are JSON if its name ends in .json, YAML otherwise.
        to: "csv"; "ros2" (the goal of FollowJointTrajectory) or "ros2-topic" (a JointTrajectory);
            "moveit"; "urscript" (a stream of servoj), "urscript-movej" (movej with blends) or
            "urscript-program" (one program of several motions: `UrProgram`); "mcap" (a log for Foxglove, with
            robot and scene of a plan); or an exporter with your own options.
        hz: Samples per second. By default messages have the motion's own points, tables 100 samples per
            second, URScript 125 and logs 50.

    Raises:
        NameNotFound: If no format has this name.
        PlanningFailed: If the result has no plan.
        ProblemError: If `motion` is not a motion, or `to` is not an exporter.
        FileFormatError: If the file cannot be written.
        ShapeError: If the format cannot represent the motion's joints, or the rate is not possible.
        MissingExtra: Without the package of the format.
    """
    exporter = exporter_named(to) if isinstance(to, str) else to
    if not isinstance(exporter, Exporter):  # pyright: ignore[reportUnnecessaryIsInstance]
        raise ProblemError(f"to is an Exporter or the name of one, is {shown(to)}")
    if isinstance(motion, Trajectory):
        return exporter.write(motion, arrays.path("path", path), hz)
    if isinstance(exporter, ProgramExporter):
        return exporter.write_program(_sections(motion), arrays.path("path", path), hz)
    model, trajectory = _whole(motion)
    if isinstance(exporter, ModelExporter):
        exporter = exporter.with_model(model)
    return exporter.write(trajectory, arrays.path("path", path), hz)


def _whole(motion: Motions) -> tuple[reduced.ReducedModel, Trajectory]:
    require = getattr(motion, "require", None)
    plan: object = motion if require is None else require()
    if isinstance(plan, tuple):
        return cast("PlannedWhole[reduced.ReducedModel]", motion).whole
    if not isinstance(getattr(plan, "trajectory", None), Trajectory) or not hasattr(plan, "problem"):
        raise ProblemError(
            f"export: give a plan, a result that has one, or a trajectory; motion is {shown(motion)}"
        )
    found = cast("PlannedMotion[reduced.ReducedModel]", plan)
    return found.problem.reduced, found.trajectory


def _sections(motion: Motions) -> list[ProgramSection]:
    found: Any = motion
    if not isinstance(getattr(found, "segments", None), tuple):
        model, trajectory = _whole(motion)
        goals = getattr(getattr(found, "problem", None), "goals", ())
        return [ProgramSection("motion", model, trajectory, curve_of(goals))]
    segments = found.require()
    scenes = [*(segment.result.problem.scene for segment in segments[1:]), found.final_scene]
    return [
        ProgramSection.between(segment.title, segment.result, segment.rest, after)
        for segment, after in zip(segments, scenes, strict=True)
    ]
