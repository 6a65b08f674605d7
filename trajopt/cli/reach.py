"""`trajopt reach`: reachable places of a frame, their directions and manipulability."""

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
from trajopt.lab.reach import CELL, DIRECTIONS, reach_map
from trajopt.viewer.plots import plot_reach

OutOption = Annotated[Path | None, typer.Option("--out", help="Write the map here (.npz).")]
PictureOption = Annotated[Path | None, typer.Option("--picture", help="Draw cuts through it here.")]
CellOption = Annotated[float, typer.Option("--cell", help=r"Edge of a cell \[m].")]
DirectionsOption = Annotated[
    int, typer.Option("--directions", min=1, help="Directions that the sphere around a cell is divided into.")
]
ReferenceOption = Annotated[str, typer.Option("--reference", help="Frame that positions are seen from.")]


def reach(
    robot: RobotOption,
    out: OutOption = None,
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
    srdf: SrdfOption = None,
    limits: LimitsOption = None,
    package_dir: PackageOption = None,
    as_json: JsonOption = False,
) -> None:
    """Map what a frame reaches without collision, by random configurations. Exit status 0 or 2."""
    source = RobotSource(robot, srdf, limits, tuple(package_dir or ()))
    reduced = sampled_model(source, scene, group, state)
    tip = chosen_frame(reduced, frame)
    with progress_bar("sampling", count) as progress:
        found = reach_map(
            reduced,
            tip,
            count,
            rng=generator(seed),
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
