"""`trajopt bench`: plan folders of MoveIt problems and sum up."""

import json
import time
from pathlib import Path
from typing import Annotated, cast

import typer
from rich.progress import Progress

from trajopt.benchmark.folders import Record, by_set, find_instances, run, summary
from trajopt.cli.options import (
    ExactOption,
    LimitsOption,
    PackageOption,
    PortfolioOption,
    RobotOption,
    RobotSource,
    SrdfOption,
    TimeBudgetOption,
    budget_of,
)
from trajopt.moveit.trajectory_files import write_json

DataOption = Annotated[
    Path, typer.Option("--data", help="Folder laid out as <set>/sceneNNNN.yaml, requestNNNN.yaml.")
]
SetsOption = Annotated[
    str, typer.Option("--sets", help="Names of sets, separated by commas; all if left out.")
]
LimitOption = Annotated[int | None, typer.Option("--limit", min=1, help="Problems of each set at most.")]
JsonFileOption = Annotated[
    Path | None, typer.Option("--json", help="Write every record and the summary here.")
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
    portfolio: PortfolioOption = True,
    time_budget: TimeBudgetOption = None,
) -> None:
    """Plan every problem below a folder. Exit status 0 if all that can be asked are solved, else 1.

    The time budget is for each problem, in CPU time.
    """
    source = RobotSource(robot, srdf, limits, tuple(package_dir or ()), exact_meshes)
    instances = find_instances(data, [name for name in sets.split(",") if name], limit=limit)
    budget = budget_of(time_budget, portfolio, clock=time.process_time)
    machine = source.load()
    records: list[Record] = []
    with Progress(transient=True) as bar:
        task = bar.add_task("planning", total=len(instances))
        for record in run(machine, instances, budget=budget):
            records.append(record)
            solved = sum(item.verified for item in records)
            bar.update(task, advance=1, description=f"{solved} of {len(records)} solved")
    total = summary(records)
    if json_file is not None:
        document = {
            "robot": machine.name,
            "problems": [record.as_dict() for record in records],
            "sets": by_set(records),
            "summary": total,
        }
        write_json(json_file, document)
    typer.echo(table({**by_set(records), "all": total}))
    typer.echo("\n" + stage_table(total))
    typer.echo(f"\nwon by {winners(total)}")
    typer.echo(json.dumps(total["statuses"]))
    for name, count in cast("dict[str, int]", total["causes"]).items():
        typer.echo(f"  {count:4} x {name}")
    for record in records:
        if not record.verified:
            name = f"{record.instance.set_name} {record.instance.index}"
            typer.echo(f"  {name}: {record.status.name}: {record.message}")
    raise typer.Exit(0 if total["success"] in (1.0, None) else 1)


def table(rows: dict[str, dict[str, object]]) -> str:
    """Return a Markdown table, one row for each set."""
    lines = [
        "| set | problems | left out | verified | success | first try | CPU ms median | CPU ms p90 "
        "| distance calls | path rad | motion s |",
        "|---|---|---|---|---|---|---|---|---|---|---|",
    ]
    for name, row in rows.items():
        lines.append(
            f"| {name} | {row['problems']} | {row['left_out']} | {row['verified']} "
            f"| {_number(row['success'], 100, '.1f')} % | {_number(row['first_try'], 100, '.1f')} % "
            f"| {_number(row['cpu_seconds_median'], 1000, '.0f')} "
            f"| {_number(row['cpu_seconds_p90'], 1000, '.0f')} "
            f"| {_number(row['distance_calls_median'], 1, '.0f')} "
            f"| {_number(row['path_length_median'], 1, '.2f')} "
            f"| {_number(row['duration_median'], 1, '.2f')} |"
        )
    return "\n".join(lines)


def stage_table(total: dict[str, object]) -> str:
    """Return a Markdown table of the stages' CPU times."""
    stages = cast("dict[str, list[float]]", total["stages"])
    lines = ["| stage | CPU ms median | CPU ms p90 |", "|---|---|---|"]
    lines += [f"| {name} | {1e3 * mid:.1f} | {1e3 * high:.1f} |" for name, (mid, high) in stages.items()]
    return "\n".join(lines)


def winners(total: dict[str, object]) -> str:
    """Say how many motions came from each kind of first guess."""
    won = cast("dict[str, int]", total["won_by"])
    return ", ".join(f"{count} {name}" for name, count in won.items()) or "none"


def _number(value: object, factor: float, form: str) -> str:
    return format(value * factor, form) if isinstance(value, int | float) else "-"
