"""`trajopt suite`: plan every installed problem and show each constraint's worst value and its place."""

from functools import partial
from pathlib import Path
from typing import Annotated

import typer

from trajopt.cli.progress import quiet_bar
from trajopt.cli.thumbnails import PicturesOption, Thumbnails
from trajopt.lab.suite import RunOutcome, installed_definitions, run
from trajopt.lab.suite.suite_page import page, row, summary, text_table
from trajopt.values.documents.document import write_json, write_text

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
    pictures: PicturesOption = True,
) -> None:
    """Plan every installed problem, judge each motion again. Exit status 0 if all end as expected, else 1."""
    chosen = installed_definitions([name for name in problems.split(",") if name])
    asked = [item.instance(draw) for item in chosen for draw in range(1 + random * item.randomised)]
    outcomes: list[RunOutcome] = []
    drawn = Thumbnails[tuple[str, int]](enabled=html_file is not None and pictures)
    with quiet_bar() as bar:
        task = bar.add_task("planning", total=len(asked))
        for instance in asked:
            outcomes.append(run(instance, seen=partial(drawn.draw, (instance.name, instance.draw))))
            good = sum(outcome.good for outcome in outcomes)
            bar.update(task, advance=1, description=f"{good} of {len(outcomes)} as expected")
    if json_file is not None:
        write_json(json_file, {"problems": [row(outcome) for outcome in outcomes]})
    if html_file is not None:
        write_text(html_file, page(outcomes, drawn.pictures, drawn.remark))
    typer.echo("\n".join(text_table(outcomes)))
    typer.echo(f"\n{summary(outcomes)}")
    for outcome in outcomes:
        if not outcome.good:
            typer.echo(f"  {outcome.problem}, {outcome.instance}: {outcome.status.name}: {outcome.message}")
    raise typer.Exit(0 if all(outcome.good for outcome in outcomes) else 1)
