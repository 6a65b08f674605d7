"""`trajopt suite`: plan every installed problem and show what holds, by how much and where."""

from pathlib import Path
from typing import Annotated

import typer
from rich.progress import Progress

from trajopt.benchmark import Definition, Entry, definitions, page, run, table
from trajopt.benchmark.suite_table import summary
from trajopt.errors import ProblemNotFound
from trajopt.moveit.trajectory_files import write_json, write_text

JsonFileOption = Annotated[Path | None, typer.Option("--json", help="Write every entry here.")]
HtmlFileOption = Annotated[Path | None, typer.Option("--html", help="Write a page to look at here.")]
RandomOption = Annotated[
    int, typer.Option("--random", min=0, help="Random instances of each problem, beside the fixed one.")
]
ProblemsOption = Annotated[
    str, typer.Option("--problems", help="Names of problems, separated by commas; all if left out.")
]


def suite(
    json_file: JsonFileOption = None,
    html_file: HtmlFileOption = None,
    random: RandomOption = 0,
    problems: ProblemsOption = "",
) -> None:
    """Plan every installed problem, judge each motion anew. Exit status 0 if all end as expected, else 1."""
    chosen = _chosen([name for name in problems.split(",") if name])
    asked = [(item, draw) for item in chosen for draw in range(1 + random * item.randomised)]
    entries: list[Entry] = []
    with Progress(transient=True) as bar:
        task = bar.add_task("planning", total=len(asked))
        for definition, draw in asked:
            entries.append(run(definition, draw))
            good = sum(entry.as_expected for entry in entries)
            bar.update(task, advance=1, description=f"{good} of {len(entries)} as expected")
    if json_file is not None:
        write_json(json_file, {"problems": [entry.as_dict() for entry in entries]})
    if html_file is not None:
        write_text(html_file, page(entries))
    typer.echo("\n".join(table(entries)))
    typer.echo(f"\n{summary(entries)}")
    for entry in entries:
        if not entry.as_expected:
            typer.echo(f"  {entry.problem}, {entry.instance}: {entry.status.name}: {entry.message}")
    raise typer.Exit(0 if all(entry.as_expected for entry in entries) else 1)


def _chosen(names: list[str]) -> list[Definition]:
    known = {item.name: item for item in definitions()}
    for name in names:
        if name not in known:
            raise ProblemNotFound("installed problem", name, known)
    return [known[name] for name in names or known]
