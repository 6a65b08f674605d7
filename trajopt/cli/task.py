"""`trajopt task`: check, plan, view, run and export a whole job that is written in YAML."""

import json
from pathlib import Path
from typing import Annotated

import typer

from trajopt.cli import drive, options
from trajopt.cli.motions import ToOption
from trajopt.cli.plan import OptionalScene
from trajopt.cli.problems import scene_around
from trajopt.cli.progress import progress_line
from trajopt.driving.rehearsal import run as run_task
from trajopt.driving.surprises import NONE, read_surprises
from trajopt.files.export import export as write_motion
from trajopt.planning.plan import plan as plan_task
from trajopt.problem.problem import Problem
from trajopt.tasks.result import TaskResult
from trajopt.tasks.task import Task
from trajopt.tasks.written import read_task
from trajopt.values.documents.document import write_json
from trajopt.viewer.playback import view as view_motions
from trajopt.viewer.report import write_report

task = typer.Typer(
    help="Plan a whole job: stages in YAML, in order or in the best order.",
    no_args_is_help=True,
    rich_markup_mode="rich",
)

JobArgument = Annotated[Path, typer.Argument(help="The job in YAML.")]
OutOption = Annotated[
    Path | None, typer.Option("--out", help="File for the result: .trajopt, .html or .json.")
]
ImproveOption = Annotated[
    bool, typer.Option("--improve", help="Optimise path and timing of each motion together.")
]
SurprisesOption = Annotated[Path | None, typer.Option("--surprises", help="Unannounced events: a YAML file.")]
FileOption = Annotated[Path, typer.Option("--out", help="File to write.")]
HzOption = Annotated[float | None, typer.Option("--hz", help=r"Samples per second \[1/s].")]


def _read(robot: options.RobotSource, job: Path, scene: Path | None) -> Task:
    around, notes = scene_around(robot, scene, None)
    for note in notes:
        typer.echo(f"note: {note}", err=True)
    return read_task(job, around)


def _planned(job: Task, *, improve: bool, seconds: float | None) -> TaskResult:
    with progress_line() as line:
        return plan_task(job, improve=improve, seconds=seconds, progress=line.show)


@task.command()
@options.robot_options
def check(
    robot: options.RobotSource,
    job: JobArgument,
    scene: OptionalScene = None,
    as_json: options.JsonOption = False,
) -> None:
    """Read a job and check its stages, without planning. Exit status 0 or 2."""
    names = [stage.name for stage in _read(robot, job, scene).stages]
    typer.echo(json.dumps(names) if as_json else "\n".join(names))


@task.command()
@options.robot_options
def plan(
    robot: options.RobotSource,
    job: JobArgument,
    scene: OptionalScene = None,
    out: OutOption = None,
    improve: ImproveOption = False,
    seconds: options.TimeBudgetOption = None,
    as_json: options.JsonOption = False,
) -> None:
    """Plan a job and print its cycle times. Exit status 0 verified, 1 no plan, 2 bad input."""
    result = _planned(_read(robot, job, scene), improve=improve, seconds=seconds)
    if out is not None:
        match out.suffix:
            case ".trajopt":
                result.save(out)
            case ".html":
                write_report(result, out)
            case _:
                write_json(out, result.as_dict())
    typer.echo(json.dumps(result.as_dict(), allow_nan=False) if as_json else str(result.explain()))
    raise typer.Exit(0 if result.verified else 1)


@task.command()
@options.robot_options
def view(
    robot: options.RobotSource,
    job: JobArgument,
    scene: OptionalScene = None,
    port: options.PortOption = 8080,
    host: options.HostOption = "127.0.0.1",
    seconds: options.SecondsOption = None,
) -> None:
    """Plan a job and play it in the browser. Exit status 0, 1 no plan, 2 bad input."""
    result = _planned(_read(robot, job, scene), improve=False, seconds=None)
    typer.echo(str(result.explain()))
    if not result.verified:
        raise typer.Exit(1)
    page = view_motions(result, port=port, host=host)
    typer.echo(page.url)
    page.wait(seconds)


@task.command()
@options.robot_options
def run(
    robot: options.RobotSource,
    job: JobArgument,
    scene: OptionalScene = None,
    surprises: SurprisesOption = None,
    longest: drive.LongestOption = 120.0,
    out: drive.OutOption = None,
    record: drive.RecordOption = None,
    view: drive.ViewOption = False,
    publish: drive.PublishOption = None,
    port: options.PortOption = 8080,
    host: options.HostOption = "127.0.0.1",
    seconds: options.SecondsOption = None,
    as_json: options.JsonOption = False,
) -> None:
    """Drive a job with the simulated robot, whose fingers hold objects by friction. Exit status as `run`."""
    read = _read(robot, job, scene)
    happening = NONE if surprises is None else read_surprises(surprises)
    stands = Problem(scene=read.scene, group=read.group, start=read.start, goal=read.start)
    with drive.watched(stands, view=view, port=port, host=host, as_json=as_json, publish=publish) as page:
        driven = run_task(read, surprises=happening, longest=longest, watch=page.look)
        if record is not None:
            drive.write_run(record, page.recording, robot)
        page.linger(seconds)
    drive.end_run(driven, out, as_json=as_json)


@task.command()
@options.robot_options
def export(
    robot: options.RobotSource,
    job: JobArgument,
    to: ToOption,
    out: FileOption,
    scene: OptionalScene = None,
    improve: ImproveOption = False,
    hz: HzOption = None,
) -> None:
    """Plan a job and write it as one motion or program. Exit status 0, 1 no plan, 2 bad input."""
    result = _planned(_read(robot, job, scene), improve=improve, seconds=None)
    if not result.verified:
        typer.echo(str(result.explain()))
        raise typer.Exit(1)
    typer.echo(str(write_motion(result, out, to=to, hz=hz)))
