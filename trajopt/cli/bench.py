"""`trajopt bench`: plan folders of MoveIt problems and summarise."""

import json
import time
from dataclasses import replace
from pathlib import Path
from typing import Annotated, cast

import typer

from trajopt.cli.options import (
    DwellOption,
    Ending,
    ExactOption,
    ExperienceOption,
    FinishByOption,
    LimitsOption,
    PackageOption,
    PortfolioOption,
    RobotOption,
    RobotSource,
    SrdfOption,
    TimeBudgetOption,
    budget_of,
)
from trajopt.cli.progress import quiet_bar
from trajopt.lab.suite import Instance, RunOutcome, run
from trajopt.lab.suite.instance import by_set, find_instances, row, summary
from trajopt.server.warehouse import Warehouse
from trajopt.values.documents.document import write_json

DataOption = Annotated[
    Path,
    typer.Option(
        "--data",
        help="Folder of <set>/sceneNNNN.yaml, requestNNNN.yaml, perhaps motionsNNNN.yaml.",
    ),
]
SetsOption = Annotated[
    str, typer.Option("--sets", help="Names of sets, separated by commas; all if left out.")
]
LimitOption = Annotated[int | None, typer.Option("--limit", min=1, help="Problems of each set at most.")]
JsonFileOption = Annotated[
    Path | None, typer.Option("--json", help="Write every outcome and the summary here.")
]


def bench(
    robot: RobotOption,
    data: DataOption,
    sets: SetsOption = "",
    limit: LimitOption = None,
    json_file: JsonFileOption = None,
    srdf: SrdfOption = None,
    limits: LimitsOption = None,
    package_dir: PackageOption = None,
    exact_meshes: ExactOption = False,
    dwell: DwellOption = 0.0,
    finish_by: FinishByOption = None,
    portfolio: PortfolioOption = True,
    time_budget: TimeBudgetOption = None,
    experience: ExperienceOption = None,
) -> None:
    """Plan every problem below a folder. Exit status 0 if all problems with valid ends are solved, else 1.

    The time budget is for each problem, in CPU time.
    """
    source = RobotSource(robot, srdf, limits, tuple(package_dir or ()), exact_meshes)
    budget = budget_of(time_budget, portfolio, clock=time.process_time)
    ending, machine = Ending(dwell, finish_by), source.load()
    instances = find_instances(data, machine, [name for name in sets.split(",") if name], limit=limit)
    outcomes: list[RunOutcome] = []
    remembered = None if experience is None else Warehouse(experience).experience()
    with quiet_bar() as bar:
        task = bar.add_task("planning", total=len(instances))
        for instance in instances:
            outcomes.append(run(_ending(instance, ending), budget=budget, experience=remembered))
            solved = sum(item.verified for item in outcomes)
            bar.update(task, advance=1, description=f"{solved} of {len(outcomes)} solved")
    total = summary(outcomes)
    if json_file is not None:
        document = {
            "robot": machine.name,
            "problems": [row(outcome) for outcome in outcomes],
            "sets": by_set(outcomes),
            "summary": total,
        }
        write_json(json_file, document)
    typer.echo(table({**by_set(outcomes), "all": total}))
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


def _ending(instance: Instance, ending: Ending) -> Instance:
    """Return an instance whose motion has to end so."""
    return replace(instance, make=lambda: ending.of(instance.make()))


def table(rows: dict[str, dict[str, object]]) -> str:
    """Return a Markdown table, one row for each set."""
    lines = [
        "| set | problems | left out | verified | success | first try | CPU ms median | CPU ms p90 "
        "| distance calls | path rad | motion s |",
        "|---|---|---|---|---|---|---|---|---|---|---|",
    ]
    for name, sums in rows.items():
        lines.append(
            f"| {name} | {sums['problems']} | {sums['left_out']} | {sums['verified']} "
            f"| {_number(sums['success'], 100, '.1f')} % | {_number(sums['first_try'], 100, '.1f')} % "
            f"| {_number(sums['cpu_seconds_median'], 1000, '.0f')} "
            f"| {_number(sums['cpu_seconds_p90'], 1000, '.0f')} "
            f"| {_number(sums['distance_calls_median'], 1, '.0f')} "
            f"| {_number(sums['path_length_median'], 1, '.2f')} "
            f"| {_number(sums['duration_median'], 1, '.2f')} |"
        )
    return "\n".join(lines)


def stage_table(total: dict[str, object]) -> str:
    """Return a Markdown table of the stages' CPU times."""
    stages = cast("dict[str, list[float]]", total["stages"])
    lines = ["| stage | CPU ms median | CPU ms p90 |", "|---|---|---|"]
    lines += [f"| {name} | {1e3 * mid:.1f} | {1e3 * high:.1f} |" for name, (mid, high) in stages.items()]
    return "\n".join(lines)


def winners(total: dict[str, object]) -> str:
    """Count the motions by kind of seed."""
    won = cast("dict[str, int]", total["won_by"])
    return ", ".join(f"{count} {name}" for name, count in won.items()) or "none"


def _number(value: object, factor: float, form: str) -> str:
    return format(value * factor, form) if isinstance(value, int | float) else "-"
