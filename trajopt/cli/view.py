"""`trajopt view`: look at a plan in the browser."""

import json
from pathlib import Path
from typing import Annotated, cast

import typer

from trajopt.cli.options import (
    JsonOption,
    LimitsOption,
    PackageOption,
    RobotSource,
    SrdfOption,
    read_files,
)
from trajopt.errors import FileFormatError
from trajopt.io.files import read_json
from trajopt.moveit.trajectory_files import FORMATS, read_trajectory
from trajopt.problem import Problem, named_problem
from trajopt.view import view as open_viewer

PlanArgument = Annotated[Path, typer.Argument(help=f"With --robot ...: {FORMATS}; without: a plan's JSON.")]
RobotOption = Annotated[str | None, typer.Option("--robot", help="Robot, where the file does not say it.")]
SceneOption = Annotated[Path | None, typer.Option("--scene", help="Scene, where the file does not say it.")]
RequestOption = Annotated[
    Path | None, typer.Option("--request", help="Request, where the file does not say it.")
]
PortOption = Annotated[int, typer.Option("--port", help="Port of the page.")]
HostOption = Annotated[str, typer.Option("--host", help="Address that the page is served on.")]
SecondsOption = Annotated[
    float | None, typer.Option("--seconds", help="Close after this many seconds; Ctrl-C otherwise.")
]


def view(
    plan: PlanArgument,
    robot: RobotOption = None,
    scene: SceneOption = None,
    request: RequestOption = None,
    srdf: SrdfOption = None,
    limits: LimitsOption = None,
    package_dir: PackageOption = None,
    port: PortOption = 8080,
    host: HostOption = "127.0.0.1",
    seconds: SecondsOption = None,
    as_json: JsonOption = False,
) -> None:
    """Show robot, scene and motion in the browser: slider over time, play, clearance readout."""
    trajectory = read_trajectory(plan)
    if robot is not None:
        source = RobotSource(robot, srdf, limits, tuple(package_dir or ()))
        if scene is None or request is None:
            raise FileFormatError(str(plan), "with --robot give --scene and --request too")
        problem = read_files(source.load(), scene, request)[1].problem()
    else:
        problem = _problem_of(plan)
    viewer = open_viewer(
        problem.reduced, trajectory.ordered(problem.reduced.joint_names), port=port, host=host
    )
    typer.echo(json.dumps({"url": viewer.url}) if as_json else f"open {viewer.url} (Ctrl-C ends)")
    try:
        viewer.wait(seconds)
    finally:
        viewer.close()


def _problem_of(plan: Path) -> Problem:
    """Rebuild the problem that a plan's file names."""
    document = read_json(plan) if plan.suffix == ".json" else None
    source = cast("dict[str, object]", document).get("source") if isinstance(document, dict) else None
    if not isinstance(source, dict):
        raise FileFormatError(str(plan), "names no scene; give --robot, --scene and --request")
    source = cast("dict[str, object]", source)
    if isinstance(source.get("problem"), str):
        return named_problem(str(source["problem"]))
    robot = RobotSource.from_dict(plan, source)
    scene, request = source.get("scene"), source.get("request")
    if not isinstance(scene, str) or not isinstance(request, str):
        raise FileFormatError(str(plan), "names no scene; give --robot, --scene and --request")
    motions = source.get("motions")
    files = (Path(scene), Path(request), Path(motions) if isinstance(motions, str) else None)
    return read_files(robot.load(), *files)[1].problem()
