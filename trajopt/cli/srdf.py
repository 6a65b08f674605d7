"""`trajopt srdf`: propose an SRDF for a robot, with its evidence."""

import json
from pathlib import Path
from typing import Annotated

import numpy as np
import typer

from trajopt.cli.kinematics import SeedOption
from trajopt.cli.options import JsonOption, PackageOption, RobotSource
from trajopt.cli.progress import progress_bar
from trajopt.lab.srdf import Confidence, propose_srdf
from trajopt.lab.srdf.judged_pairs import samples_needed
from trajopt.values.documents.document import write_text

UrdfArgument = Annotated[str, typer.Argument(help="The URDF file, or an installed robot by name.")]
OutOption = Annotated[Path | None, typer.Option("--out", help="Write the SRDF here.")]
ShareOption = Annotated[
    float,
    typer.Option(
        "--share", help="A pair is left out if it surely collides in a smaller share of configurations."
    ),
]
LevelOption = Annotated[
    float, typer.Option("--level", help="How sure: the confidence, of all pairs together.")
]


def srdf(
    urdf: UrdfArgument,
    out: OutOption = None,
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
