"""`trajopt run`: a request planned and driven in the simulated world, among surprises."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Annotated

import typer

from trajopt.cli.options import (
    ExactOption,
    JsonOption,
    LimitsOption,
    MotionsOption,
    PackageOption,
    RequestOption,
    RobotOption,
    RobotSource,
    SceneOption,
    SrdfOption,
    TorqueOption,
    read_files,
)
from trajopt.cli.watched import HostOption, PortOption, SecondsOption, watched
from trajopt.driving.recording import write_recording
from trajopt.driving.rehearsal import RunReport
from trajopt.driving.rehearsal import run as drive
from trajopt.driving.simulated import TOLERANCE
from trajopt.driving.surprises import NONE, Surprises, random_surprise, read_surprises, undisturbed
from trajopt.problem.problem import Problem
from trajopt.simulation import render
from trajopt.simulation.picture_files import check_path
from trajopt.values.documents.document import write_json
from trajopt.values.errors import ProblemError, shown
from trajopt.values.printed import in_length

RANDOM = "random:"
SurprisesOption = Annotated[
    str,
    typer.Option(
        "--surprises",
        help="What happens unannounced: a YAML file, or random:SEED for a box that appears on the way.",
    ),
]
LongestOption = Annotated[float, typer.Option("--longest", help="Most seconds of simulated time.")]
ToleranceOption = Annotated[
    float,
    typer.Option(
        "--tolerance",
        help="Largest tracking error of each joint \\[rad] or \\[m]; give your driver's to see its room.",
    ),
]
OutOption = Annotated[
    Path | None, typer.Option("--out", help="Write everything, and how the robot moved, here as JSON.")
]
RecordOption = Annotated[
    Path | None, typer.Option("--record", help="Record the run here as JSON, for `trajopt view FILE`.")
]
ViewOption = Annotated[
    bool, typer.Option("--view", help="Show the run in the browser while it goes on, in real time.")
]
PublishOption = Annotated[
    int | None,
    typer.Option(
        "--publish", help="Tell mirrors on this port, in real time: trajopt view --mirror http://HOST:PORT."
    ),
]
PictureOption = Annotated[
    list[Path] | None,
    typer.Option("--picture", help="Draw what happened here: .png, .gif or .mp4 (repeatable)."),
]


def run(
    robot: RobotOption,
    scene: SceneOption,
    request: RequestOption,
    srdf: SrdfOption = None,
    limits: LimitsOption = None,
    package_dir: PackageOption = None,
    exact_meshes: ExactOption = False,
    torque_scaling: TorqueOption = 1.0,
    motions: MotionsOption = None,
    surprises: SurprisesOption = "",
    longest: LongestOption = 60.0,
    tolerance: ToleranceOption = TOLERANCE,
    out: OutOption = None,
    picture: PictureOption = None,
    record: RecordOption = None,
    view: ViewOption = False,
    publish: PublishOption = None,
    port: PortOption = 8080,
    host: HostOption = "127.0.0.1",
    seconds: SecondsOption = None,
    as_json: JsonOption = False,
) -> None:
    """Plan and drive the simulated robot. Exit status 0 reached, 1 not or a contact at fault, 2 bad input."""
    for path in picture or ():
        check_path(path)
    folders = tuple(package_dir or ())
    source = RobotSource(robot, srdf, limits, folders, exact_meshes, torque_scaling)
    problem = read_files(source.load(), scene, request, motions)[1].problem()
    happening = _surprises(problem, surprises, tolerance)
    with watched(problem, view=view, port=port, host=host, as_json=as_json, publish=publish) as page:
        driven = drive(problem, surprises=happening, longest=longest, tolerance=tolerance, watch=page.look)
        if record is not None:
            write_recording(record, page.recording, source.as_dict())
        page.linger(seconds)
    document = driven.as_dict()
    if out is not None:
        write_json(out, {**document, "measured": driven.measured.as_dict()})
    world = happening.world(problem.scene)
    for path in picture or ():
        render(replace(problem, scene=world).reduced, driven.measured, path)
    typer.echo(json.dumps(document, allow_nan=False) if as_json else _report(driven))
    raise typer.Exit(0 if driven.reached and not driven.contacts_at_fault else 1)


def _surprises(problem: Problem, words: str, tolerance: float) -> Surprises:
    """Read the surprises, or draw one on the path of the plan.

    Raises:
        ProblemError: If the seed is not a number, or there is no plan to disturb.
    """
    if not words:
        return NONE
    if not words.startswith(RANDOM):
        return read_surprises(words)
    seed = words.removeprefix(RANDOM)
    if not seed.isdigit():
        raise ProblemError(f"--surprises random:SEED takes a whole number, is {shown(words)}")
    return random_surprise(problem, undisturbed(problem, tolerance=tolerance), int(seed))


def _report(driven: RunReport) -> str:
    lines = [str(event) for event in driven.events]
    lines.append("reached the goal" if driven.reached else "did not reach the goal")
    proven = driven.clearance_proven
    known = "not proven" if proven is None else f"{in_length(proven)} proven"
    lines[-1] += f" after {driven.duration:.2f} s; clearance {in_length(driven.clearance_measured)}, {known}"
    lines += [f"touched: {contact}" for contact in driven.contacts]
    return "\n".join(lines)
