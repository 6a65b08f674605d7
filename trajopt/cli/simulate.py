"""`trajopt simulate`: a motion under physics, in MuJoCo, and pictures of it."""

import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Annotated

import typer

from trajopt.cli.options import JsonOption, MotionsOption, RobotSource, robot_options
from trajopt.cli.problems import (
    MotionArgument,
    OptionalRequest,
    OptionalScene,
    model_and_motion,
    motions_in,
    nothing_beside,
)
from trajopt.cli.progress import ProgressLine, progress_line
from trajopt.simulation import Layout, Rollout, SimulationOptions, render
from trajopt.simulation import simulate as roll_out
from trajopt.simulation.picture_files import check_path
from trajopt.tasks.grasping.simulation import STEP, PickPlaceRollout, TaskRollout
from trajopt.values.documents.document import write_json
from trajopt.values.errors import ProblemError, shown

PictureOption = Annotated[
    list[Path] | None,
    typer.Option("--picture", help="Draw the rollout here: .png, .gif or .mp4 (repeatable)."),
]
WidthOption = Annotated[int, typer.Option("--width", help="Width of pictures, in pixels.")]
HeightOption = Annotated[int, typer.Option("--height", help="Height of pictures, in pixels.")]
RateOption = Annotated[float, typer.Option("--fps", help="Frames per second of GIF and MP4.")]
MomentsOption = Annotated[
    str,
    typer.Option("--moments", help="Times that a PNG shows, in seconds, separated by commas; default: four."),
]
SuperposedOption = Annotated[
    bool,
    typer.Option("--superposed", help="Superpose all times in one picture of a PNG; the last is opaque."),
]
HighlightOption = Annotated[
    list[str] | None, typer.Option("--highlight", help="Link or object to draw in red (repeatable).")
]
StepOption = Annotated[
    float | None,
    typer.Option("--dt", help="Time step of the physics, in seconds; default: 0.002, for tasks 0.001."),
]
SettlingOption = Annotated[
    float, typer.Option("--settling-time", help="Time at rest after the motion, in seconds.")
]
OutOption = Annotated[Path | None, typer.Option("--out", help="Write all measurements here as JSON.")]


@robot_options
def simulate(
    trajectory: MotionArgument,
    robot: RobotSource | None = None,
    scene: OptionalScene = None,
    request: OptionalRequest = None,
    motions: MotionsOption = None,
    dt: StepOption = None,
    settling_time: SettlingOption = SimulationOptions.settling_time,
    out: OutOption = None,
    picture: PictureOption = None,
    width: WidthOption = 640,
    height: HeightOption = 480,
    fps: RateOption = 20.0,
    moments: MomentsOption = "",
    superposed: SuperposedOption = False,
    highlight: HighlightOption = None,
    as_json: JsonOption = False,
) -> None:
    """Follow a motion or a task with the simulated robot. Exit status 0, 1 on a fault, 2 bad input.

    Faults are collisions, divergence, and an object that the fingers do not hold. Objects move, appear and
    expire by --motions; attached objects have their mass. In a task friction holds what the gripper picks.
    """
    for path in picture or ():
        check_path(path)
    several, shown_at = motions_in(trajectory), _times(moments)
    step = dt if dt is not None else SimulationOptions.dt if several is None else STEP
    options = SimulationOptions(dt=step, settling_time=settling_time)
    with progress_line() as line:
        line.show("simulate", None)
        if several is None:
            rollout = roll_out(*model_and_motion(trajectory, robot, scene, request, motions), options=options)
        else:
            nothing_beside(trajectory, robot, scene, request, motions)
            rollout = several.simulated(options)
        for path in picture or ():
            render(
                rollout,
                path,
                width=width,
                height=height,
                fps=fps,
                moments=shown_at,
                layout=Layout.SUPERPOSED if superposed else Layout.FILM_STRIP,
                highlight=highlight or (),
                progress=_share(line, path),
            )
    _tell(rollout, out, picture or [], as_json=as_json)
    raise typer.Exit(0 if rollout.succeeded else 1)


def _times(text: str) -> list[float] | None:
    try:
        return [float(part) for part in text.split(",")] if text else None
    except ValueError:
        raise ProblemError(f"--moments must be times with commas between, is {shown(text)}") from None


def _share(line: ProgressLine, path: Path) -> Callable[[float], None]:
    return lambda share: line.show(f"drawing {path.name}, {share:.0%}", None)


def _tell(
    rollout: Rollout | TaskRollout | PickPlaceRollout,
    out: Path | None,
    pictures: Sequence[Path],
    *,
    as_json: bool,
) -> None:
    document = {**rollout.as_dict(), "summary": rollout.summary(), "files": [str(path) for path in pictures]}
    if out is not None:
        write_json(out, document)
    if as_json:
        typer.echo(json.dumps(document, allow_nan=False))
        return
    lines = [str(rollout.trajectory)] if isinstance(rollout, Rollout) else []
    typer.echo("\n".join([*lines, rollout.summary()]))
    for note in rollout.notes:
        typer.echo(f"note: {note}")
    for path in (*([] if out is None else [out]), *pictures):
        typer.echo(f"written to {path}")
