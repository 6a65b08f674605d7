"""`trajopt check`: the judge alone, on any trajectory."""

import json
from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import typer

from trajopt.cli.options import (
    DwellOption,
    Ending,
    ExactOption,
    FinishByOption,
    JerkOption,
    JsonOption,
    LimitsOption,
    MotionsOption,
    PackageOption,
    RobotSource,
    SrdfOption,
    TorqueOption,
    read_files,
)
from trajopt.cli.planned import (
    OptionalRequest,
    OptionalRobot,
    OptionalScene,
    motion_in,
    problem_of,
)
from trajopt.files.moveit.trajectory_files import FORMATS
from trajopt.files.proof import SUFFIX, check_proof
from trajopt.planning.judgement import judge

TrajectoryArgument = Annotated[Path, typer.Argument(help=f"What to judge: a bundle, a proof, {FORMATS}.")]


def check(
    trajectory: TrajectoryArgument,
    robot: OptionalRobot = None,
    scene: OptionalScene = None,
    request: OptionalRequest = None,
    srdf: SrdfOption = None,
    limits: LimitsOption = None,
    package_dir: PackageOption = None,
    exact_meshes: ExactOption = False,
    torque_scaling: TorqueOption = 1.0,
    limit_jerk: JerkOption = False,
    motions: MotionsOption = None,
    dwell: DwellOption = 0.0,
    finish_by: FinishByOption = None,
    as_json: JsonOption = False,
) -> None:
    """Judge a trajectory as it is written. Exit status 0 verified, 1 not verified, 2 bad input.

    Between points that have accelerations it is quintic, with velocities cubic, with neither linear. A proof
    (.proof) is checked by the small checker instead of the judge.
    """
    if trajectory.suffix.lower() == SUFFIX:
        checked = check_proof(trajectory)
        typer.echo(json.dumps(asdict(checked)) if as_json else checked.words)
        raise typer.Exit(0 if checked.proven else 1)
    notes = list[str]()
    source = None
    if robot is not None:
        folders = tuple(package_dir or ())
        source = RobotSource(robot, srdf, limits, folders, exact_meshes, torque_scaling, limit_jerk)
    if source is None or scene is None or request is None:
        problem = problem_of(trajectory, source, scene, request, motions)
        if dwell or finish_by is not None:
            problem = Ending(dwell, finish_by).of(problem)
    else:
        around, asked = read_files(source.load(), scene, request, motions)
        problem = Ending(dwell, finish_by).of(asked.problem())
        notes += [*around.scene.robot.notes, *around.notes, *asked.notes]
    motion = motion_in(trajectory).ordered(problem.reduced.joint_names)
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
