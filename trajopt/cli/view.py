"""`trajopt view`: look at a plan or a recorded run in the browser, or plan there by hand."""

import json
from pathlib import Path
from typing import Annotated

import typer

from trajopt.cli.kinematics import StateOption
from trajopt.cli.options import (
    GroupOption,
    HostOption,
    JsonOption,
    MotionsOption,
    PortOption,
    RobotSource,
    SecondsOption,
    robot_options,
)
from trajopt.cli.problems import OptionalRequest, OptionalScene, model_and_motion, motions_in
from trajopt.driving.recording import RecordingFile
from trajopt.files.moveit import read_scene
from trajopt.files.moveit.trajectories import FORMATS
from trajopt.scene.scene import Scene
from trajopt.values.errors import FileFormatError, ProblemError
from trajopt.viewer import LiveView, RunViewer, live_view, mirror_view, view_run
from trajopt.viewer import view as open_viewer
from trajopt.viewer.server import Served

OptionalFile = Annotated[
    Path | None,
    typer.Argument(help=f"A saved result, a plan's JSON or a recorded run; with --robot ...: {FORMATS}."),
]


MirrorOption = Annotated[
    str | None,
    typer.Option(
        "--mirror",
        metavar="URL",
        help="Show the state of a remote robot: a session of trajopt serve (http://HOST:PORT/sessions/ID), "
        "or a run with --publish.",
    ),
]
TokenOption = Annotated[
    str, typer.Option("--token", envvar="TRAJOPT_TOKEN", help="With --mirror: token of the server.")
]


@robot_options
def view(
    file: OptionalFile = None,
    robot: RobotSource | None = None,
    scene: OptionalScene = None,
    request: OptionalRequest = None,
    motions: MotionsOption = None,
    group: GroupOption = "",
    state: StateOption = None,
    mirror: MirrorOption = None,
    token: TokenOption = "",
    port: PortOption = 8080,
    host: HostOption = "127.0.0.1",
    seconds: SecondsOption = None,
    as_json: JsonOption = False,
) -> None:
    """Show a plan, a recorded run or a remote robot in the browser; with --robot alone, plan by hand.

    Without a file the page has the robot, arrows at its hand for dragging, joint sliders, the
    objects, and buttons to plan and execute: trajopt view --robot panda.
    """
    viewer: Served
    if mirror is not None:
        if file is not None or robot is not None:
            raise ProblemError("view: --mirror shows the robot at its address: omit the file and --robot")
        viewer = mirror_view(mirror, token=token, port=port, host=host)
    elif file is None:
        if robot is None:
            raise ProblemError("view: name a file to show, or with --robot a robot to plan for by hand")
        if request is not None or motions is not None:
            raise ProblemError(
                "view: --request and --motions belong to a file; leave them out to plan by hand"
            )
        viewer = _live(robot, scene, group, state, port, host)
    elif group or state is not None:
        raise ProblemError("view: --group and --state are for planning by hand, without a file")
    elif RecordingFile.is_one(file):
        viewer = _run(RecordingFile.open(file), file, robot, port, host)
    elif robot is None and (several := motions_in(file)) is not None:
        viewer = open_viewer(several, port=port, host=host)
    else:
        reduced, trajectory = model_and_motion(file, robot, scene, request, motions)
        viewer = open_viewer(reduced, trajectory, port=port, host=host)
    typer.echo(json.dumps({"url": viewer.url}) if as_json else f"open {viewer.url} (Ctrl-C ends)")
    try:
        viewer.wait(seconds)
    finally:
        viewer.close()


def _live(
    source: RobotSource, scene: Path | None, group: str, state: str | None, port: int, host: str
) -> LiveView:
    robot = source.load()
    if scene is None:
        return live_view(Scene(robot), group=group, start=state, port=port, host=host)
    file = read_scene(scene, robot)
    start = state if state is not None or not file.state else file.positions
    return live_view(file.scene, group=group, start=start, port=port, host=host)


def _run(file: RecordingFile, path: Path, source: RobotSource | None, port: int, host: str) -> RunViewer:
    if source is None:
        if file.source is None:
            raise FileFormatError(str(path), f"does not state the source of {file.robot_name}; give --robot")
        source = RobotSource.from_dict(path, dict(file.source))
    return view_run(file.read(source.load()), port=port, host=host)
