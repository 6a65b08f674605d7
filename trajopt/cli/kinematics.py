"""`trajopt sample`, `reach` and `srdf`: commands that sample configurations of a robot."""

import json
from pathlib import Path
from typing import Annotated

import numpy as np
import typer

from trajopt.cli.options import GroupOption, JsonOption, PackageOption, RobotSource, robot_options
from trajopt.cli.progress import progress_bar
from trajopt.files.moveit import read_scene
from trajopt.lab.reach import CELL, DIRECTIONS, check_table_path, reach_map, sample_table
from trajopt.lab.srdf import Confidence, propose_srdf
from trajopt.lab.srdf.judged_pairs import samples_needed
from trajopt.optimise.kinematics.forward import frame_of
from trajopt.scene.group_tools import end_link
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.reducing import reduce_model
from trajopt.scene.scene import Scene
from trajopt.values.documents.document import write_text
from trajopt.values.errors import ProblemError, shown
from trajopt.viewer.plots import plot_reach

FrameOption = Annotated[
    str,
    typer.Option("--frame", help="Link, tool frame or attached object; default: the group's tip."),
]
CountOption = Annotated[int, typer.Option("--count", min=1, help="Number of configurations.")]
SeedOption = Annotated[int, typer.Option("--seed", min=0, help="Seed of the random numbers.")]
MarginOption = Annotated[float, typer.Option("--margin", min=0.0, help=r"Required clearance \[m].")]
SceneOption = Annotated[Path | None, typer.Option("--scene", help="MoveIt PlanningScene in YAML.")]
StateOption = Annotated[
    str | None, typer.Option("--state", help="Named state of the joints outside the group.")
]


def sampled_model(source: RobotSource, scene: Path | None, group: str, state: str | None) -> ReducedModel:
    robot = source.load()
    if not group:
        if len(robot.groups) != 1:
            raise ProblemError(f"name the group with --group: {', '.join(robot.groups)}")
        group = next(iter(robot.groups))
    around = Scene(robot) if scene is None else read_scene(scene, robot).scene
    return reduce_model(around, group, robot.positions(state))


def chosen_frame(reduced: ReducedModel, frame: str) -> str:
    tip = frame or end_link(reduced.scene.robot, reduced.group)
    if not tip:
        raise ProblemError(f"group {shown(reduced.group)} has no single end; name the frame with --frame")
    return frame_of(reduced, tip)


TableOption = Annotated[Path, typer.Option("--out", help="Output table (.npz or .parquet).")]
AllOption = Annotated[
    bool, typer.Option("--all", help="Keep configurations in collision too; the column `clear` marks them.")
]


@robot_options
def sample(
    robot: RobotSource,
    out: TableOption,
    count: CountOption = 10_000,
    group: GroupOption = "",
    frame: FrameOption = "",
    scene: SceneOption = None,
    state: StateOption = None,
    margin: MarginOption = 0.0,
    keep_all: AllOption = False,
    seed: SeedOption = 0,
    as_json: JsonOption = False,
) -> None:
    """Write random collision-free configurations with the placements of a frame. Exit status 0 or 2."""
    check_table_path(out)
    reduced = sampled_model(robot, scene, group, state)
    tip = chosen_frame(reduced, frame)
    with progress_bar("sampling", count) as progress:
        table = sample_table(
            reduced,
            tip,
            count,
            rng=np.random.default_rng(seed),
            margin=margin,
            only_clear=not keep_all,
            progress=progress,
        )
    table.write(out)
    clear = int(table.clear.sum())
    if as_json:
        facts = {"file": str(out), "rows": len(table), "clear": clear, "frame": tip}
        typer.echo(json.dumps({**facts, "group": reduced.group, "joints": list(table.joint_names)}))
    else:
        typer.echo(f"{len(table)} configurations of {reduced.group} with {tip}, {clear} clear: {out}")


MapOption = Annotated[Path | None, typer.Option("--out", help="Write the map here (.npz).")]
PictureOption = Annotated[Path | None, typer.Option("--picture", help="Draw cross-sections of the map here.")]
CellOption = Annotated[float, typer.Option("--cell", help=r"Edge length of a cell \[m].")]
DirectionsOption = Annotated[
    int, typer.Option("--directions", min=1, help="Number of directions that each cell distinguishes.")
]
ReferenceOption = Annotated[str, typer.Option("--reference", help="Reference frame of positions.")]


@robot_options
def reach(
    robot: RobotSource,
    out: MapOption = None,
    picture: PictureOption = None,
    count: CountOption = 1_000_000,
    cell: CellOption = CELL,
    directions: DirectionsOption = DIRECTIONS,
    group: GroupOption = "",
    frame: FrameOption = "",
    reference: ReferenceOption = "world",
    scene: SceneOption = None,
    state: StateOption = None,
    margin: MarginOption = 0.0,
    seed: SeedOption = 0,
    as_json: JsonOption = False,
) -> None:
    """Map the collision-free poses of a frame by random configurations. Exit status 0 or 2."""
    reduced = sampled_model(robot, scene, group, state)
    tip = chosen_frame(reduced, frame)
    with progress_bar("sampling", count) as progress:
        found = reach_map(
            reduced,
            tip,
            count,
            rng=np.random.default_rng(seed),
            cell=cell,
            directions=directions,
            reference=reference,
            margin=margin,
            progress=progress,
        )
    written = [
        *([] if out is None else [found.save(out)]),
        *([] if picture is None else [plot_reach(found, picture)]),
    ]
    if as_json:
        facts = {"frame": tip, "group": reduced.group, "volume": found.volume, "cell": found.cell}
        counts = {"cells": int((found.hits > 0).sum()), "valid": found.valid, "drawn": found.drawn}
        typer.echo(json.dumps({**facts, **counts, "files": [str(path) for path in written]}))
    else:
        typer.echo("\n".join([str(found), *(f"written to {path}" for path in written)]))


UrdfArgument = Annotated[str, typer.Argument(help="The URDF file, or an installed robot by name.")]
SrdfFileOption = Annotated[Path | None, typer.Option("--out", help="Write the SRDF here.")]
ShareOption = Annotated[
    float,
    typer.Option("--share", help="Disable pairs that collide in less than this share of configurations."),
]
LevelOption = Annotated[float, typer.Option("--level", help="Confidence level, of all pairs together.")]


def srdf(
    urdf: UrdfArgument,
    out: SrdfFileOption = None,
    share: ShareOption = Confidence.share,
    level: LevelOption = Confidence.level,
    seed: SeedOption = 0,
    package_dir: PackageOption = None,
    as_json: JsonOption = False,
) -> None:
    """Propose an SRDF: pairs that never collide, groups, states; check the URDF. Exit status 0 or 2."""
    confidence = Confidence(share=share, level=level)
    robot = RobotSource(urdf, package_dirs=tuple(package_dir or ())).load()
    with progress_bar("sampling pairs", samples_needed(robot, confidence)) as progress:
        proposal = propose_srdf(
            robot, rng=np.random.default_rng(seed), confidence=confidence, progress=progress
        )
    if out is not None:
        write_text(out, proposal.xml)
    if as_json:
        typer.echo(
            json.dumps({**proposal.as_dict(), "file": None if out is None else str(out)}, allow_nan=False)
        )
    else:
        typer.echo("\n".join([str(proposal), *([] if out is None else [f"\nwritten to {out}"])]))
