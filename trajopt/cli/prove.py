"""`trajopt prove`: a proof file of a motion, for a checker that needs no trajopt."""

import json
from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import typer

from trajopt.cli.options import (
    ExactOption,
    JerkOption,
    JsonOption,
    LimitsOption,
    MotionsOption,
    PackageOption,
    RobotSource,
    SrdfOption,
    TorqueOption,
)
from trajopt.cli.planned import (
    MotionArgument,
    OptionalRequest,
    OptionalRobot,
    OptionalScene,
    motion_in,
    problem_of,
)
from trajopt.files.proof import check_proof, save_proof

OutOption = Annotated[Path, typer.Option("--out", help="Proof file to write.")]


def prove(
    motion: MotionArgument,
    out: OutOption,
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
    as_json: JsonOption = False,
) -> None:
    """Write a proof of a motion, of any planner, and check it. Exit status 0 proven, 1 not, 2 bad input."""
    source = None
    if robot is not None:
        folders = tuple(package_dir or ())
        source = RobotSource(robot, srdf, limits, folders, exact_meshes, torque_scaling, limit_jerk)
    problem = problem_of(motion, source, scene, request, motions)
    size = save_proof(problem, motion_in(motion).ordered(problem.reduced.joint_names), out)
    found = check_proof(out)
    typer.echo(json.dumps({**asdict(found), **asdict(size)}) if as_json else f"{found.words}\n{out}: {size}")
    raise typer.Exit(0 if found.proven else 1)
