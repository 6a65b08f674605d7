"""`trajopt view`: look at a plan in the browser."""

import json
from typing import Annotated

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
    problem_of,
)
from trajopt.moveit.trajectory_files import read_trajectory
from trajopt.view import view as open_viewer

PortOption = Annotated[int, typer.Option("--port", help="Port of the page.")]
HostOption = Annotated[str, typer.Option("--host", help="Address that the page is served on.")]
SecondsOption = Annotated[
    float | None, typer.Option("--seconds", help="Close after this many seconds; Ctrl-C otherwise.")
]


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
    """Show robot, scene and motion in the browser: slider over time, play, clearance readout."""
    trajectory = read_trajectory(plan)
    source = None if robot is None else RobotSource(robot, srdf, limits, tuple(package_dir or ()))
    reduced = problem_of(plan, source, scene, request, motions).reduced
    viewer = open_viewer(reduced, trajectory.ordered(reduced.joint_names), port=port, host=host)
    typer.echo(json.dumps({"url": viewer.url}) if as_json else f"open {viewer.url} (Ctrl-C ends)")
    try:
        viewer.wait(seconds)
    finally:
        viewer.close()
