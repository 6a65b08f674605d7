"""`trajopt replay`: plan a bundle's problem again."""

import json
from pathlib import Path
from typing import Annotated

import typer

from trajopt.cli.options import JsonOption
from trajopt.files.bundle import read_bundle
from trajopt.files.bundle import replay as plan_again

BundleArgument = Annotated[Path, typer.Argument(help="The bundle: a file that `plan --save` wrote.")]
MethodOption = Annotated[
    str | None, typer.Option("--method", help="Plan by this method instead of the one of then.")
]


def replay(bundle: BundleArgument, method: MethodOption = None, as_json: JsonOption = False) -> None:
    """Plan a bundle's problem again. Exit status 0 the same answer, 1 another, 2 bad input."""
    kept = read_bundle(bundle)
    found = plan_again(kept, method=method)
    typer.echo(json.dumps(found.as_dict()) if as_json else f"{kept}\n\n{found}")
    raise typer.Exit(0 if found.same else 1)
