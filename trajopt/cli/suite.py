"""`trajopt suite`: plan every installed problem and show what holds, by how much and where."""

from pathlib import Path
from typing import Annotated

import typer
from rich.progress import Progress

from trajopt.benchmark import Outcome, installed_definitions, run
from trajopt.benchmark.suite_page import page
from trajopt.benchmark.suite_table import row, summary, table
from trajopt.moveit.trajectory_files import write_json, write_text

JsonFileOption = Annotated[Path | None, typer.Option("--json", help="Write every outcome here.")]
HtmlFileOption = Annotated[Path | None, typer.Option("--html", help="Write a page with figures here.")]
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
    chosen = installed_definitions([name for name in problems.split(",") if name])
    asked = [item.instance(draw) for item in chosen for draw in range(1 + random * item.randomised)]
    outcomes: list[Outcome] = []
    with Progress(transient=True) as bar:
        task = bar.add_task("planning", total=len(asked))
        for instance in asked:
            outcomes.append(run(instance))
            good = sum(outcome.good for outcome in outcomes)
            bar.update(task, advance=1, description=f"{good} of {len(outcomes)} as expected")
    if json_file is not None:
        write_json(json_file, {"problems": [row(outcome) for outcome in outcomes]})
    if html_file is not None:
        write_text(html_file, page(outcomes))
    typer.echo("\n".join(table(outcomes)))
    typer.echo(f"\n{summary(outcomes)}")
    for outcome in outcomes:
        if not outcome.good:
            typer.echo(f"  {outcome.problem}, {outcome.instance}: {outcome.status.name}: {outcome.message}")
    raise typer.Exit(0 if all(outcome.good for outcome in outcomes) else 1)
