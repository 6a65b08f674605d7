"""`trajopt sample`: a table of configurations and placements, for training."""

import json
from pathlib import Path
from typing import Annotated

import typer

from trajopt.cli.kinematics import (
    CountOption,
    FrameOption,
    GroupOption,
    MarginOption,
    SceneOption,
    SeedOption,
    StateOption,
    chosen_frame,
    generator,
    sampled_model,
)
from trajopt.cli.options import JsonOption, LimitsOption, PackageOption, RobotOption, RobotSource, SrdfOption
from trajopt.cli.progress import progress_bar
from trajopt.lab.reach import check_table_path, sample_table

OutOption = Annotated[Path, typer.Option("--out", help="Table to write: .npz or .parquet.")]
AllOption = Annotated[
    bool, typer.Option("--all", help="Keep configurations in collision too; the column `clear` marks them.")
]


def sample(
    robot: RobotOption,
    out: OutOption,
    count: CountOption = 10_000,
    group: GroupOption = "",
    frame: FrameOption = "",
    scene: SceneOption = None,
    state: StateOption = None,
    margin: MarginOption = 0.0,
    keep_all: AllOption = False,
    seed: SeedOption = 0,
    srdf: SrdfOption = None,
    limits: LimitsOption = None,
    package_dir: PackageOption = None,
    as_json: JsonOption = False,
) -> None:
    """Write random collision-free configurations with the placements of a frame. Exit status 0 or 2."""
    check_table_path(out)
    source = RobotSource(robot, srdf, limits, tuple(package_dir or ()))
    reduced = sampled_model(source, scene, group, state)
    tip = chosen_frame(reduced, frame)
    with progress_bar("sampling", count) as progress:
        table = sample_table(
            reduced,
            tip,
            count,
            rng=generator(seed),
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
