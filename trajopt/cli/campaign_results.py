"""`trajopt campaign report|extract|dataset|remember`: results of a campaign."""

import json
from pathlib import Path
from typing import Annotated

import typer

from trajopt.cli.options import JsonOption
from trajopt.lab.campaign import CampaignFolder, compare_campaigns, dataset, extract, remember, summary
from trajopt.lab.campaign.page import lines, map_of, page
from trajopt.server.warehouse import Warehouse
from trajopt.values.documents.document import write_text
from trajopt.values.errors import CampaignError

FolderArgument = Annotated[Path, typer.Argument(help="Folder of the campaign.")]
BesideOption = Annotated[
    Path | None, typer.Option("--beside", help="Folder of another campaign, with which this is compared.")
]
HtmlOption = Annotated[Path | None, typer.Option("--html", help="Write a page with plots here.")]
PictureOption = Annotated[
    Path | None, typer.Option("--map", help="Write the map of the base's places here (SVG).")
]
RowsArgument = Annotated[list[str], typer.Argument(help="Ids of rows, or their beginnings.")]
BundlesOption = Annotated[Path, typer.Option("--out", help="Folder for the bundles.")]
TableOption = Annotated[Path, typer.Option("--out", help="Data set to write: .npz.")]
KeptOption = Annotated[
    Path, typer.Option("--experience", help="Warehouse that remembers the motions; made if it is not there.")
]
PointsOption = Annotated[int, typer.Option("--points", min=2, help="Points of each motion.")]


def report(
    folder: FolderArgument,
    beside: BesideOption = None,
    html: HtmlOption = None,
    picture: PictureOption = None,
    as_json: JsonOption = False,
) -> None:
    """Sum up the results so far, and compare them with another campaign's. Exit status 0 or 2."""
    opened = CampaignFolder.open(folder)
    found = summary(opened)
    compared = None if beside is None else compare_campaigns(CampaignFolder.open(beside), opened)
    if html is not None:
        write_text(html, page(found, compared))
    if picture is not None:
        if found.places is None:
            raise CampaignError(f"{folder} is about no places of a base: there is no map to draw")
        write_text(picture, map_of(found.places))
    if as_json:
        beside_it = None if compared is None else compared.as_dict()
        typer.echo(json.dumps({**found.as_dict(), "beside": beside_it}))
    else:
        typer.echo("\n".join(lines(found, compared)))


def extract_rows(folder: FolderArgument, rows: RowsArgument, out: BundlesOption = Path()) -> None:
    """Plan rows again and write bundles. Exit status 0 if the results match, 1 if not, 2 bad input."""
    opened = CampaignFolder.open(folder)
    found = [extract(opened, row, out / f"{row}.trajopt") for row in rows]
    words = {True: "as in the row", False: "NOT as in the row", None: "the problem alone"}
    for each in found:
        typer.echo(f"{each.path}: {words[each.same]}")
    raise typer.Exit(1 if any(each.same is False for each in found) else 0)


def write_dataset(folder: FolderArgument, out: TableOption, points: PointsOption = 64) -> None:
    """Write the verified motions as arrays of one shape, for training. Exit status 0 or 2."""
    found = dataset(CampaignFolder.open(folder), points)
    found.write(out)
    typer.echo(f"{len(found)} motions of {len(found.joint_names)} joints at {points} points each: {out}")


def remember_rows(folder: FolderArgument, experience: KeptOption) -> None:
    """Store the verified motions as experience for plan and bench. Exit status 0 or 2."""
    opened = CampaignFolder.open(folder)
    with Warehouse(experience) as kept:
        remembered = kept.experience()
        count = remember(opened, remembered)
        typer.echo(f"{count} motions more, {len(remembered)} are remembered in {experience}")
