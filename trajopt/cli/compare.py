"""`trajopt compare`: methods side by side, on the same problems, with the same budget and judge."""

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, cast

import typer
from rich.console import Console
from rich.table import Table

from trajopt.cli.options import RobotSource
from trajopt.cli.progress import quiet_bar
from trajopt.cli.thumbnails import PicturesOption, Thumbnails
from trajopt.lab.suite import (
    STANDARD,
    Allowance,
    Instance,
    RunOutcome,
    compared,
    installed_instances,
)
from trajopt.lab.suite.comparison_page import (
    LEGEND,
    RUN_HEAD,
    SUMMARY_HEAD,
    markdown,
    page,
    run_cells,
    summary_cells,
)
from trajopt.lab.suite.instance import find_instances
from trajopt.lab.suite.outcome import summaries
from trajopt.optimise.methods import Method, method_named, method_names
from trajopt.planning.result import Result
from trajopt.values.documents.document import write_json, write_text
from trajopt.values.documents.files import read_json
from trajopt.values.errors import FileFormatError, MissingExtra
from trajopt.viewer.plots import comparison_figures

ProblemOption = Annotated[
    list[str] | None,
    typer.Option("--problem", help='An installed problem (repeatable); "all" for every one.'),
]
SolverOption = Annotated[
    list[str] | None, typer.Option("--solver", help="A method (repeatable); all installed ones if left out.")
]
DataOption = Annotated[
    Path | None, typer.Option("--data", help="Folder laid out as <set>/sceneNNNN.yaml, requestNNNN.yaml.")
]
RobotOption = Annotated[str, typer.Option("--robot", help="The robot that --data is for.")]
LimitOption = Annotated[
    int | None, typer.Option("--limit", min=1, help="Problems of each set of --data at most.")
]
AttemptsOption = Annotated[int, typer.Option("--attempts", min=1, help="Seeds at most.")]
SecondsOption = Annotated[
    float, typer.Option("--cpu-seconds", min=0.0, help=r"No other seed after this much CPU time \[s].")
]
ResultsOption = Annotated[
    list[Path] | None,
    typer.Option("--results", help="What --json wrote earlier (repeatable): shown again, beside new runs."),
]
JsonFileOption = Annotated[Path | None, typer.Option("--json", help="Write every run here.")]
HtmlFileOption = Annotated[Path | None, typer.Option("--html", help="Write a page with figures here.")]
MarkdownOption = Annotated[Path | None, typer.Option("--markdown", help="Write tables in Markdown here.")]


def compare(
    problem: ProblemOption = None,
    solver: SolverOption = None,
    data: DataOption = None,
    robot: RobotOption = "panda",
    limit: LimitOption = None,
    attempts: AttemptsOption = Allowance.attempts,
    cpu_seconds: SecondsOption = Allowance.cpu_seconds,
    results: ResultsOption = None,
    json_file: JsonFileOption = None,
    html_file: HtmlFileOption = None,
    markdown_file: MarkdownOption = None,
    pictures: PicturesOption = True,
) -> None:
    """Plan the same problems with several methods, and compare the results.

    Without options: every installed method on a small standard choice of problems. Exit status 0 when all
    runs are done, independent of their outcome; 2 bad input.
    """
    found = [run for path in results or () for run in read_runs(path)]
    methods = [method_named(name) for name in solver or method_names()]
    instances = [] if results and not (problem or data) else _instances(problem, data, robot, limit)
    drawn = Thumbnails[tuple[str, str]](enabled=html_file is not None and pictures)
    found.extend(_planned(instances, methods, Allowance(attempts, cpu_seconds), drawn))
    if json_file is not None:
        write_json(json_file, {"results": [run.as_dict() for run in found]})
    if html_file is not None:
        write_text(html_file, page(found, comparison_figures(found), drawn.pictures, drawn.remark))
    if markdown_file is not None:
        write_text(markdown_file, markdown(found))
    console = Console()
    console.print(_table(RUN_HEAD, [run_cells(run) for run in found]))
    console.print(_table(SUMMARY_HEAD, [summary_cells(item) for item in summaries(found)]))
    console.print(LEGEND, style="dim")


def read_runs(path: Path) -> tuple[RunOutcome, ...]:
    """Read a file written by `--json`.

    Raises:
        FileFormatError: If the file is missing, or contains no runs.
    """
    try:
        document = cast("dict[str, list[dict[str, object]]]", read_json(path))
        return tuple(RunOutcome.from_dict(item) for item in document["results"])
    except (ValueError, KeyError, TypeError, AttributeError, OverflowError) as error:
        raise FileFormatError(str(path), f"holds no runs of a comparison ({error})") from error


def _instances(
    problem: Sequence[str] | None, data: Path | None, robot: str, limit: int | None
) -> list[Instance]:
    found: list[Instance] = []
    if problem or data is None:
        names = STANDARD if not problem else () if "all" in problem else problem
        found.extend(installed_instances(names))
    if data is not None:
        found.extend(find_instances(data, RobotSource(robot).load(), limit=limit))
    return found


def _planned(
    instances: Sequence[Instance],
    methods: Sequence[Method],
    allowance: Allowance,
    drawn: Thumbnails[tuple[str, str]],
) -> list[RunOutcome]:
    found: list[RunOutcome] = []
    results: list[Result] = []
    with quiet_bar() as bar:

        def skipped(method: Method, error: MissingExtra) -> None:
            bar.console.print(f"left out {method.name}: {error}", style="yellow")

        task = bar.add_task("planning", total=len(instances) * len(methods))
        for run in compared(instances, methods, allowance, skipped=skipped, seen=results.append):
            found.append(run)
            drawn.draw((run.problem, run.solver), results.pop())
            bar.update(task, advance=1, description=f"{run.problem}, {run.solver}")
    return found


def _table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> Table:
    table = Table(*head, box=None, pad_edge=False, header_style="bold")
    for column in table.columns[3:]:
        column.justify = "right"
    for row in rows:
        table.add_row(*row)
    return table
