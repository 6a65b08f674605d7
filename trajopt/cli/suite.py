"""`trajopt suite`, `compare` and `bench`: commands that plan many problems and sum up."""

import json
import time
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Annotated, Generic, TypeVar, cast

import typer
from rich.console import Console
from rich.table import Table

from trajopt.cli import options
from trajopt.cli.progress import quiet_bar
from trajopt.lab.suite import (
    STANDARD,
    Allowance,
    Instance,
    RunOutcome,
    compared,
    installed_definitions,
    installed_instances,
    pages,
    run,
)
from trajopt.lab.suite import instance as instances_of
from trajopt.lab.suite.outcome import summaries
from trajopt.optimise.methods import Method, method_named, method_names
from trajopt.planning.result import Result
from trajopt.server.warehouse import Warehouse
from trajopt.simulation.rendering import thumbnail
from trajopt.values.documents.document import write_json, write_text
from trajopt.values.documents.files import read_json
from trajopt.values.errors import FileFormatError, MissingExtra, RenderingUnavailable
from trajopt.viewer.plots import comparison_figures

Key = TypeVar("Key")
PicturesOption = Annotated[
    bool, typer.Option("--pictures/--no-pictures", help="Whether the page has a picture of each problem.")
]


class Thumbnails(Generic[Key]):
    """Pictures by key; without OpenGL none, with a remark."""

    def __init__(self, *, enabled: bool) -> None:
        self.pictures: dict[Key, bytes] = {}
        self.remark = ""
        self._enabled = enabled

    def draw(self, key: Key, result: Result) -> None:
        if not self._enabled:
            return
        motion = result.trajectory if result.verified else None
        try:
            self.pictures[key] = thumbnail(result.problem.reduced, motion)
        except RenderingUnavailable as missing:
            self.remark = f"It has no pictures: {missing}"
            self._enabled = False


OutcomesOption = Annotated[
    Path | None, typer.Option("--json", help="Write all outcomes here as JSON, for compare --results.")
]
HtmlFileOption = Annotated[Path | None, typer.Option("--html", help="Write a page with figures here.")]
RandomOption = Annotated[
    int,
    typer.Option("--random", min=0, help="Random instances of each problem, in addition to the fixed one."),
]
ProblemsOption = Annotated[
    str, typer.Option("--problems", help="Names of problems, separated by commas; default: all.")
]


def suite(
    json_file: OutcomesOption = None,
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
        write_json(json_file, {"results": [outcome.as_dict() for outcome in outcomes]})
    if html_file is not None:
        write_text(html_file, pages.suite_page(outcomes, drawn.pictures, drawn.remark))
    typer.echo("\n".join(pages.text_table(outcomes)))
    typer.echo(f"\n{pages.summary(outcomes)}")
    for outcome in outcomes:
        if not outcome.good:
            typer.echo(f"  {outcome.problem}, {outcome.instance}: {outcome.status.name}: {outcome.message}")
    raise typer.Exit(0 if all(outcome.good for outcome in outcomes) else 1)


MethodProblemsOption = Annotated[
    list[str] | None,
    typer.Option("--problem", help='Installed problem (repeatable), or "all".'),
]
SolverOption = Annotated[
    list[str] | None,
    typer.Option("--solver", help="Planning method (repeatable); default: all installed methods."),
]
DataOption = Annotated[
    Path | None, typer.Option("--data", help="Folder laid out as <set>/sceneNNNN.yaml, requestNNNN.yaml.")
]
DataRobotOption = Annotated[str, typer.Option("--robot", help="Robot of --data.")]
LimitOption = Annotated[
    int | None, typer.Option("--limit", min=1, help="Most problems of each set of --data.")
]
AttemptsOption = Annotated[int, typer.Option("--attempts", min=1, help="Most seeds.")]
SecondsOption = Annotated[
    float, typer.Option("--cpu-seconds", min=0.0, help=r"CPU time after which no further seed is tried \[s].")
]
ResultsOption = Annotated[
    list[Path] | None,
    typer.Option("--results", help="Earlier output of --json (repeatable), shown with new runs."),
]
RunsFileOption = Annotated[Path | None, typer.Option("--json", help="Write all runs here as JSON.")]
MarkdownOption = Annotated[Path | None, typer.Option("--markdown", help="Write tables in Markdown here.")]


def compare(
    problem: MethodProblemsOption = None,
    solver: SolverOption = None,
    data: DataOption = None,
    robot: DataRobotOption = "panda",
    limit: LimitOption = None,
    attempts: AttemptsOption = Allowance.attempts,
    cpu_seconds: SecondsOption = Allowance.cpu_seconds,
    results: ResultsOption = None,
    json_file: RunsFileOption = None,
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
        write_text(
            html_file, pages.comparison_page(found, comparison_figures(found), drawn.pictures, drawn.remark)
        )
    if markdown_file is not None:
        write_text(markdown_file, pages.markdown(found))
    console = Console()
    console.print(_columns(pages.RUN_HEAD, [pages.run_cells(run) for run in found]))
    console.print(_columns(pages.SUMMARY_HEAD, [pages.summary_cells(item) for item in summaries(found)]))
    console.print(pages.LEGEND, style="dim")


def read_runs(path: Path) -> tuple[RunOutcome, ...]:
    document = cast("dict[str, list[dict[str, object]]]", read_json(path))
    try:
        return tuple(RunOutcome.from_dict(item) for item in document["results"])
    except (ValueError, KeyError, TypeError, AttributeError, OverflowError) as error:
        raise FileFormatError(str(path), "holds no runs that compare or suite wrote") from error


def _instances(
    problem: Sequence[str] | None, data: Path | None, robot: str, limit: int | None
) -> list[Instance]:
    found: list[Instance] = []
    if problem or data is None:
        names = STANDARD if not problem else () if "all" in problem else problem
        found.extend(installed_instances(names))
    if data is not None:
        found.extend(instances_of.find_instances(data, options.RobotSource(robot).load(), limit=limit))
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


def _columns(head: Sequence[str], rows: Sequence[Sequence[str]]) -> Table:
    table = Table(*head, box=None, pad_edge=False, header_style="bold")
    for column in table.columns[3:]:
        column.justify = "right"
    for row in rows:
        table.add_row(*row)
    return table


ProblemsFolder = Annotated[
    Path,
    typer.Option(
        "--data",
        help="Folder of <set>/sceneNNNN.yaml, requestNNNN.yaml, optionally motionsNNNN.yaml.",
    ),
]
SetsOption = Annotated[str, typer.Option("--sets", help="Names of sets, separated by commas; default: all.")]
SetLimitOption = Annotated[int | None, typer.Option("--limit", min=1, help="Most problems of each set.")]
SetsFileOption = Annotated[
    Path | None, typer.Option("--json", help="Write all outcomes and the summary here as JSON.")
]


@options.robot_options
def bench(
    robot: options.RobotSource,
    data: ProblemsFolder,
    sets: SetsOption = "",
    limit: SetLimitOption = None,
    json_file: SetsFileOption = None,
    dwell: options.DwellOption = 0.0,
    finish_by: options.FinishByOption = None,
    portfolio: options.PortfolioOption = True,
    time_budget: options.TimeBudgetOption = None,
    experience: options.ExperienceOption = None,
) -> None:
    """Plan every problem below a folder. Exit status 0 if all problems with valid ends are solved, else 1.

    The time budget is for each problem, in CPU time.
    """
    budget = options.budget_of(time_budget, portfolio, clock=time.process_time)
    ending, machine = options.Ending(dwell, finish_by), robot.load()
    instances = instances_of.find_instances(
        data, machine, [name for name in sets.split(",") if name], limit=limit
    )
    outcomes: list[RunOutcome] = []
    remembered = None if experience is None else Warehouse(experience).experience()
    with quiet_bar() as bar:
        task = bar.add_task("planning", total=len(instances))
        for instance in instances:
            outcomes.append(run(_with_ending(instance, ending), budget=budget, experience=remembered))
            solved = sum(item.verified for item in outcomes)
            bar.update(task, advance=1, description=f"{solved} of {len(outcomes)} solved")
    total = instances_of.summary(outcomes)
    if json_file is not None:
        document = {
            "robot": machine.name,
            "problems": [instances_of.row(outcome) for outcome in outcomes],
            "sets": instances_of.by_set(outcomes),
            "summary": total,
        }
        write_json(json_file, document)
    typer.echo(set_table({**instances_of.by_set(outcomes), "all": total}))
    typer.echo("\n" + stage_table(total))
    typer.echo(f"\nwon by {winners(total)}")
    typer.echo(json.dumps(total["statuses"]))
    for name, count in cast("dict[str, int]", total["causes"]).items():
        typer.echo(f"  {count:4} x {name}")
    for outcome in outcomes:
        if not outcome.verified:
            name = outcome.problem.replace("/", " ")
            typer.echo(f"  {name}: {outcome.status.name}: {outcome.message}")
    raise typer.Exit(0 if total["success"] in (1.0, None) else 1)


def _with_ending(instance: Instance, ending: options.Ending) -> Instance:
    return replace(instance, make=lambda: ending.of(instance.make()))


def set_table(rows: dict[str, dict[str, object]]) -> str:
    """Return a Markdown table, one row for each set."""
    lines = [
        "| set | problems | left out | verified | success | first try | CPU ms median | CPU ms p90 "
        "| distance calls | path rad | motion s |",
        "|---|---|---|---|---|---|---|---|---|---|---|",
    ]
    for name, sums in rows.items():
        lines.append(
            f"| {name} | {sums['problems']} | {sums['left_out']} | {sums['verified']} "
            f"| {_scaled(sums['success'], 100, '.1f')} % | {_scaled(sums['first_try'], 100, '.1f')} % "
            f"| {_scaled(sums['cpu_seconds_median'], 1000, '.0f')} "
            f"| {_scaled(sums['cpu_seconds_p90'], 1000, '.0f')} "
            f"| {_scaled(sums['distance_calls_median'], 1, '.0f')} "
            f"| {_scaled(sums['path_length_median'], 1, '.2f')} "
            f"| {_scaled(sums['duration_median'], 1, '.2f')} |"
        )
    return "\n".join(lines)


def stage_table(total: dict[str, object]) -> str:
    stages = cast("dict[str, list[float]]", total["stages"])
    lines = ["| stage | CPU ms median | CPU ms p90 |", "|---|---|---|"]
    lines += [f"| {name} | {1e3 * mid:.1f} | {1e3 * high:.1f} |" for name, (mid, high) in stages.items()]
    return "\n".join(lines)


def winners(total: dict[str, object]) -> str:
    won = cast("dict[str, int]", total["won_by"])
    return ", ".join(f"{count} {name}" for name, count in won.items()) or "none"


def _scaled(value: object, factor: float, form: str) -> str:
    return format(value * factor, form) if isinstance(value, int | float) else "-"
