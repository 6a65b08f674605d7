"""`trajopt check`, `prove`, `export`, `replay` and `report`: commands that read a motion or a bundle."""

import json
from dataclasses import asdict
from pathlib import Path
from typing import Annotated, Any, NoReturn

import typer

from trajopt.cli import options
from trajopt.cli.problems import (
    MotionArgument,
    OptionalRequest,
    OptionalScene,
    is_bundle,
    motion_in,
    motions_in,
    nothing_beside,
    problem_of,
    saved_in,
)
from trajopt.files.bundle import Bundle, Holds
from trajopt.files.bundle import replay as plan_again
from trajopt.files.export import EXPORTERS, ModelExporter, exporter_named
from trajopt.files.export import export as write
from trajopt.files.moveit.trajectories import FORMATS, read_trajectory
from trajopt.files.proof import SUFFIX, check_proof, save_proof
from trajopt.planning.judgement import judge
from trajopt.tasks.sequence import MotionSequence
from trajopt.values.documents.document import read_document
from trajopt.values.errors import FileFormatError
from trajopt.values.trajectory import Trajectory
from trajopt.viewer.report import write_report

TrajectoryArgument = Annotated[
    Path, typer.Argument(help=f"Trajectory to judge: a bundle, a proof, {FORMATS}.")
]


FastOption = Annotated[
    bool, typer.Option("--fast", help="For proofs: the fast kernel; the checker decides its refusals.")
]


@options.robot_options
def check(
    trajectory: TrajectoryArgument,
    robot: options.RobotSource | None = None,
    scene: OptionalScene = None,
    request: OptionalRequest = None,
    motions: options.MotionsOption = None,
    dwell: options.DwellOption = 0.0,
    finish_by: options.FinishByOption = None,
    as_json: options.JsonOption = False,
    fast: FastOption = False,
) -> None:
    """Judge a trajectory as it is written. Exit status 0 verified, 1 not verified, 2 bad input.

    Between points that have accelerations it is quintic, with velocities cubic, with neither linear. A proof
    (.proof) is checked by the small checker instead of the judge.
    """
    if trajectory.suffix.lower() == SUFFIX:
        checked = check_proof(trajectory, fast=fast)
        typer.echo(json.dumps(asdict(checked)) if as_json else checked.words)
        raise typer.Exit(0 if checked.proven else 1)
    if (several := motions_in(trajectory)) is not None:
        nothing_beside(trajectory, robot, scene, request, motions)
        _check_several(several, as_json=as_json)
    notes, motion = list[str](), motion_in(trajectory)
    if robot is None or scene is None or request is None:
        problem = problem_of(trajectory, robot, scene, request, motions)
        if dwell or finish_by is not None:
            problem = options.Ending(dwell, finish_by).of(problem)
    else:
        around, asked = options.read_files(robot.load(), scene, request, motions)
        problem = options.Ending(dwell, finish_by).of(asked.problem())
        notes += [*around.scene.robot.notes, *around.notes, *asked.notes]
    motion = motion.ordered(problem.reduced.joint_names)
    # Of several goals any one will do: the verdict is that with the goal that is reached.
    verdicts = [judge(each, motion) for each in problem.alternatives.values() or (problem,)]
    certificate = next((verdict for verdict in verdicts if verdict.verified), verdicts[0])
    if as_json:
        typer.echo(json.dumps(certificate.as_dict(), allow_nan=False))
    else:
        typer.echo(f"{trajectory}: {motion}\n{certificate}")
        for note in notes:
            typer.echo(f"note: {note}")
    raise typer.Exit(0 if certificate.verified else 1)


def _check_several(several: MotionSequence[Any], *, as_json: bool) -> NoReturn:
    if as_json:
        found = several.certificate.as_dict() if several.verified else {"verified": False}
        typer.echo(json.dumps(found, allow_nan=False))
    else:
        typer.echo(
            f"{several.explain()}\n{several.certificate}" if several.verified else str(several.explain())
        )
    raise typer.Exit(0 if several.verified else 1)


ProofOption = Annotated[Path, typer.Option("--out", help="Proof file to write.")]


@options.robot_options
def prove(
    motion: MotionArgument,
    out: ProofOption,
    robot: options.RobotSource | None = None,
    scene: OptionalScene = None,
    request: OptionalRequest = None,
    motions: options.MotionsOption = None,
    as_json: options.JsonOption = False,
) -> None:
    """Write a proof of a motion, of any planner, and check it. Exit status 0 proven, 1 not, 2 bad input."""
    trajectory = motion_in(motion)
    problem = problem_of(motion, robot, scene, request, motions)
    size = save_proof(problem, trajectory.ordered(problem.reduced.joint_names), out)
    found = check_proof(out)
    typer.echo(json.dumps({**asdict(found), **asdict(size)}) if as_json else f"{found.words}\n{out}: {size}")
    raise typer.Exit(0 if found.proven else 1)


ExportedArgument = Annotated[Path, typer.Argument(help=f"Motion to export: a bundle, {FORMATS}.")]
ToOption = Annotated[str, typer.Option("--to", help=f"Format: {', '.join(EXPORTERS)}.")]
ExportOption = Annotated[
    Path, typer.Option("--out", help="Output file; messages are JSON if it ends in .json, else YAML.")
]
RateOption = Annotated[
    float | None,
    typer.Option("--hz", metavar="N", help="Samples per second; the default depends on the format."),
]


def export(
    plan: ExportedArgument,
    to: ToOption,
    out: ExportOption,
    hz: RateOption = None,
    as_json: options.JsonOption = False,
) -> None:
    """Write a plan as CSV, ROS 2 message, MoveIt message, URScript or MCAP log. Exit status 0 or 2."""
    exporter = exporter_named(to)
    saved = saved_in(plan) if is_bundle(plan) else _verified(plan)
    if isinstance(saved, Bundle):
        if saved.holds is not Holds.PLAN:
            raise FileFormatError(str(plan), f"holds no verified motion, but {saved.holds.value}")
        if isinstance(exporter, ModelExporter):
            exporter = exporter.with_model(saved.problem.reduced)
        saved = saved.require()
    exported = write(saved, out, to=exporter, hz=hz)
    typer.echo(json.dumps(exported.as_dict()) if as_json else str(exported))


def _verified(plan: Path) -> Trajectory:
    if plan.suffix.lower() != ".csv":
        document = read_document(plan)
        if document.has("status") and not document["verified"].flag():
            raise FileFormatError(str(plan), f"holds no verified motion: {document['message'].text('')}")
    return read_trajectory(plan)


BundleArgument = Annotated[Path, typer.Argument(help="A bundle, as written by `plan --save`.")]
MethodOption = Annotated[str | None, typer.Option("--method", help="Planning method; default: the bundle's.")]


def replay(bundle: BundleArgument, method: MethodOption = None, as_json: options.JsonOption = False) -> None:
    """Plan a bundle's problem again. Exit status 0 the same answer, 1 another, 2 bad input."""
    kept = saved_in(bundle)
    if not isinstance(kept, Bundle):
        raise FileFormatError(
            str(bundle),
            "is the result of a task or a curve, without its stages and options: plan it again",
        )
    found = plan_again(kept, method=method)
    typer.echo(json.dumps(found.as_dict()) if as_json else f"{kept}\n\n{found}")
    raise typer.Exit(0 if found.same else 1)


PageOption = Annotated[Path, typer.Option("--out", help="Output page (HTML).")]
MovingOption = Annotated[
    bool, typer.Option("--3d/--no-3d", help="Whether to include the motion in 3-D (needs the extra `view`).")
]
PicturesOption = Annotated[
    bool, typer.Option("--pictures/--no-pictures", help="Whether to include still pictures, for printing.")
]


def report(
    bundle: BundleArgument,
    out: PageOption = Path("report.html"),
    moving: MovingOption = True,
    pictures: PicturesOption = True,
    as_json: options.JsonOption = False,
) -> None:
    """Write a report of a bundle: one page with the 3-D motion, the proof, and prices."""
    written = write_report(saved_in(bundle), out, moving=moving, pictures=pictures)
    size = written.stat().st_size
    said = f"wrote {written} ({size / 1e6:.1f} MB)"
    typer.echo(json.dumps({"report": str(written), "bytes": size}) if as_json else said)
