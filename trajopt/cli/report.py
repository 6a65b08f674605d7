"""`trajopt report`: a bundle as one page, for the screen and for paper."""

import json
from pathlib import Path
from typing import Annotated

import typer

from trajopt.cli.options import JsonOption
from trajopt.cli.planned import bundle_in
from trajopt.viewer.report import write_report

BundleArgument = Annotated[Path, typer.Argument(help="The bundle: a file that `plan --save` wrote.")]
OutOption = Annotated[Path, typer.Option("--out", help="The page to write (HTML).")]
MovingOption = Annotated[
    bool, typer.Option("--3d/--no-3d", help="Whether it shows the motion in 3-D, which takes the extra view.")
]
PicturesOption = Annotated[
    bool, typer.Option("--pictures/--no-pictures", help="Whether it has still pictures, for paper.")
]


def report(
    bundle: BundleArgument,
    out: OutOption = Path("report.html"),
    moving: MovingOption = True,
    pictures: PicturesOption = True,
    as_json: JsonOption = False,
) -> None:
    """Write a report of a bundle: one page with the 3-D motion, the proof, and prices."""
    written = write_report(bundle_in(bundle), out, moving=moving, pictures=pictures)
    size = written.stat().st_size
    said = f"wrote {written} ({size / 1e6:.1f} MB)"
    typer.echo(json.dumps({"report": str(written), "bytes": size}) if as_json else said)
