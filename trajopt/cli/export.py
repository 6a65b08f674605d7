"""`trajopt export`: a plan in the format of a controller."""

import json
from pathlib import Path
from typing import Annotated

import typer

from trajopt.cli.options import JsonOption
from trajopt.cli.planned import bundle_in, is_bundle
from trajopt.files.bundle import Holds
from trajopt.files.export import EXPORTERS, exporter_named
from trajopt.files.export import export as write
from trajopt.files.moveit.trajectory_files import FORMATS, read_trajectory
from trajopt.values.documents.document import read_document
from trajopt.values.errors import FileFormatError
from trajopt.values.trajectory import Trajectory

PlanArgument = Annotated[Path, typer.Argument(help=f"What to read: a bundle, {FORMATS}.")]
ToOption = Annotated[str, typer.Option("--to", help=f"Format: {', '.join(EXPORTERS)}.")]
OutOption = Annotated[
    Path, typer.Option("--out", help="File to write; messages are JSON in a .json, YAML otherwise.")
]
RateOption = Annotated[
    float | None,
    typer.Option("--hz", metavar="N", help="Samples per second; without, what suits the format."),
]


def export(
    plan: PlanArgument,
    to: ToOption,
    out: OutOption,
    hz: RateOption = None,
    as_json: JsonOption = False,
) -> None:
    """Write a plan as CSV, ROS 2 message, MoveIt message or URScript. Exit status 0 or 2."""
    exporter = exporter_named(to)
    exported = write(_verified(plan), out, to=exporter, hz=hz)
    typer.echo(json.dumps(exported.as_dict()) if as_json else str(exported))


def _verified(plan: Path) -> Trajectory:
    """Read a motion; from a file with a planning status only a verified one."""
    if is_bundle(plan):
        bundle = bundle_in(plan)
        if bundle.holds is not Holds.PLAN:
            raise FileFormatError(str(plan), f"holds no verified motion, but {bundle.holds.value}")
        return bundle.require()
    if plan.suffix.lower() != ".csv":
        document = read_document(plan)
        if document.has("status") and not document["verified"].flag():
            raise FileFormatError(str(plan), f"holds no verified motion: {document['message'].text('')}")
    return read_trajectory(plan)
