"""`trajopt view`: look at a plan or a recorded run in the browser."""

import json
from pathlib import Path

import typer

from trajopt.cli.options import (
    JsonOption,
    LimitsOption,
    MotionsOption,
    PackageOption,
    RobotSource,
    SrdfOption,
)
from trajopt.cli.planned import (
    MotionArgument,
    OptionalRequest,
    OptionalRobot,
    OptionalScene,
    motion_in,
    problem_of,
)
from trajopt.cli.watched import HostOption, PortOption, SecondsOption
from trajopt.errors import FileFormatError
from trajopt.execution.recording_file import RecordingFile
from trajopt.view import RunViewer, Viewer, view_run
from trajopt.view import view as open_viewer


def view(
    plan: MotionArgument,
    robot: OptionalRobot = None,
    scene: OptionalScene = None,
    request: OptionalRequest = None,
    srdf: SrdfOption = None,
    limits: LimitsOption = None,
    package_dir: PackageOption = None,
    motions: MotionsOption = None,
    port: PortOption = 8080,
    host: HostOption = "127.0.0.1",
    seconds: SecondsOption = None,
    as_json: JsonOption = False,
) -> None:
    """Show a plan or a recorded run in the browser: slider over time, play, clearance readout."""
    source = None if robot is None else RobotSource(robot, srdf, limits, tuple(package_dir or ()))
    if RecordingFile.is_one(plan):
        viewer: RunViewer | Viewer = _run(RecordingFile.open(plan), plan, source, port, host)
    else:
        trajectory = motion_in(plan)
        reduced = problem_of(plan, source, scene, request, motions).reduced
        viewer = open_viewer(reduced, trajectory.ordered(reduced.joint_names), port=port, host=host)
    typer.echo(json.dumps({"url": viewer.url}) if as_json else f"open {viewer.url} (Ctrl-C ends)")
    try:
        viewer.wait(seconds)
    finally:
        viewer.close()


def _run(file: RecordingFile, path: Path, source: RobotSource | None, port: int, host: str) -> RunViewer:
    """Show a recorded run, of the robot that is named or of that which the file names."""
    if source is None:
        if file.source is None:
            raise FileFormatError(str(path), f"does not say where {file.robot_name} is from; give --robot")
        source = RobotSource.from_dict(path, dict(file.source))
    return view_run(file.read(source.load()), port=port, host=host)
