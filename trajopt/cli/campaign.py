"""`trajopt campaign`: thousands to millions of plans, resumable after an interruption."""

import json
import signal
from collections.abc import Generator
from contextlib import contextmanager
from enum import Enum
from pathlib import Path
from typing import Annotated, NoReturn

import typer

from trajopt.cli.campaign_results import (
    FolderArgument,
    extract_rows,
    remember_rows,
    report,
    write_dataset,
)
from trajopt.cli.campaign_sources import Words
from trajopt.cli.options import (
    ROBOT_HELP,
    ExactOption,
    JsonOption,
    LimitsOption,
    PackageOption,
    RobotSource,
    SrdfOption,
)
from trajopt.cli.progress import quiet_bar
from trajopt.lab.campaign import (
    Campaign,
    CampaignFolder,
    Engine,
    Local,
    Options,
    Progress,
    Ray,
    resume_campaign,
)
from trajopt.values.errors import ProblemError

INTERRUPTED = 130
"""Exit status after Ctrl-C, as in shells."""
DEFAULT_STEPS = (0.0, 0.0, 1)


class EngineName(Enum):
    """Kinds of engines."""

    LOCAL = "local"
    RAY = "ray"


SourceArgument = Annotated[
    str,
    typer.Argument(
        help="Folder of MoveIt problems, as bench takes it, or a .parquet table of them; random: motions "
        "between free configurations; perturbed: a request among displaced objects; placements: requests "
        "from a grid of places for the base; or an installed problem."
    ),
]
OutOption = Annotated[Path, typer.Option("--out", help="Folder that the campaign is kept in.")]
RobotOption = Annotated[
    str | None,
    typer.Option("--robot", help=ROBOT_HELP),
]
SceneOption = Annotated[
    Path | None, typer.Option("--scene", help="random, perturbed, placements: MoveIt PlanningScene in YAML.")
]
RequestsOption = Annotated[
    list[Path] | None,
    typer.Option(
        "--request", help="perturbed, placements: MoveIt MotionPlanRequest in YAML (placements: repeatable)."
    ),
]
GroupOption = Annotated[
    str, typer.Option("--group", help="random: planning group; the only one if left out.")
]
CountOption = Annotated[int, typer.Option("--count", min=1, help="How many are drawn.")]
SeedOption = Annotated[int, typer.Option("--seed", min=0, help="Seed of the drawings.")]
ShiftOption = Annotated[
    float,
    typer.Option("--shift", min=0.0, help=r"perturbed: objects are moved along each axis by at most \[m]."),
]
TurnOption = Annotated[
    float, typer.Option("--turn", min=0.0, help=r"perturbed: objects are turned by at most \[rad].")
]
XOption = Annotated[
    tuple[float, float, int],
    typer.Option("--x", metavar="FROM TO STEPS", help=r"placements: where the base may stand \[m]."),
]
YOption = Annotated[
    tuple[float, float, int],
    typer.Option("--y", metavar="FROM TO STEPS", help=r"placements: where the base may stand \[m]."),
]
YawOption = Annotated[
    tuple[float, float, int],
    typer.Option("--yaw", metavar="FROM TO STEPS", help=r"placements: its turn about the vertical \[rad]."),
]
SetsOption = Annotated[
    str, typer.Option("--sets", help="Of a folder: names of sets, separated by commas; all if left out.")
]
LimitOption = Annotated[
    int | None, typer.Option("--limit", min=1, help="Of a folder: problems of each set at most.")
]
MethodsOption = Annotated[
    str,
    typer.Option("--methods", help="Names of methods, separated by commas; each problem is planned by each."),
]
ImproveOption = Annotated[bool, typer.Option("--improve", help="Look for shorter motions, too.")]
TimeBudgetOption = Annotated[
    float | None,
    typer.Option("--time-budget", metavar="S", help=r"Process time that one problem may take \[s]."),
]
WorkOption = Annotated[
    int | None,
    typer.Option("--work", min=1, help="Configurations that one problem may evaluate: the same everywhere."),
]
AttemptsOption = Annotated[
    int | None,
    typer.Option("--attempts", min=1, help="Seeds that one problem may try; 1: the straight line."),
]
MostOption = Annotated[
    float,
    typer.Option(
        "--most-seconds", metavar="S", help=r"Wall-clock time after which a problem counts as hanging \[s]."
    ),
]
EngineOption = Annotated[
    EngineName, typer.Option("--engine", help="What plans: processes of this machine, or a cluster of Ray.")
]
AddressOption = Annotated[
    str,
    typer.Option(
        "--address", help="Ray: where the cluster is (HOST:PORT, auto); one on this machine if left out."
    ),
]
WorkersOption = Annotated[
    int, typer.Option("--workers", min=0, help="Processes that plan; as many as there are cores when 0.")
]

campaign = typer.Typer(
    help="Plans by the thousand and the million: run, resume, look at and compare them.",
    no_args_is_help=True,
)


@campaign.command()
def run(
    source: SourceArgument,
    out: OutOption,
    robot: RobotOption = None,
    scene: SceneOption = None,
    request: RequestsOption = None,
    group: GroupOption = "",
    count: CountOption = 1000,
    seed: SeedOption = 0,
    shift: ShiftOption = 0.02,
    turn: TurnOption = 0.0,
    x: XOption = DEFAULT_STEPS,
    y: YOption = DEFAULT_STEPS,
    yaw: YawOption = DEFAULT_STEPS,
    sets: SetsOption = "",
    limit: LimitOption = None,
    methods: MethodsOption = "",
    improve: ImproveOption = False,
    time_budget: TimeBudgetOption = None,
    work: WorkOption = None,
    attempts: AttemptsOption = None,
    most_seconds: MostOption = 300.0,
    srdf: SrdfOption = None,
    limits: LimitsOption = None,
    package_dir: PackageOption = None,
    exact_meshes: ExactOption = False,
    engine: EngineOption = EngineName.LOCAL,
    address: AddressOption = "",
    workers: WorkersOption = 0,
    as_json: JsonOption = False,
) -> None:
    """Plan every problem of a source and store a row for each.

    Exit status 0 if all have one, 130 interrupted, 2 bad input.
    """
    loaded = (
        None
        if robot is None
        else RobotSource(robot, srdf, limits, tuple(package_dir or ()), exact_meshes).load()
    )
    listed = [name for name in sets.split(",") if name]
    grid = {"x": x, "y": y, "yaw": yaw}
    found = Words(
        source, loaded, scene, tuple(request or ()), group, count, seed, shift, turn, grid, listed, limit
    ).made()
    options = [
        Options(method or None, improve, False, time_budget, work, attempts) for method in methods.split(",")
    ]
    begun = CampaignFolder.begin(Campaign(found.name, [found], options, most_seconds=most_seconds), out)
    planned(begun, engine_of(engine, address, workers), as_json=as_json)


@campaign.command()
def resume(
    folder: FolderArgument,
    engine: EngineOption = EngineName.LOCAL,
    address: AddressOption = "",
    workers: WorkersOption = 0,
    as_json: JsonOption = False,
) -> None:
    """Plan the problems without a row. Exit status 0 if all have one, 130 interrupted, 2 bad input."""
    planned(CampaignFolder.open(folder), engine_of(engine, address, workers), as_json=as_json)


@campaign.command()
def status(folder: FolderArgument, as_json: JsonOption = False) -> None:
    """Show the progress of a campaign. Exit status 0 if every problem has a row, else 1."""
    raise typer.Exit(0 if tell_status(CampaignFolder.open(folder), as_json=as_json) else 1)


for name, results in (
    ("report", report),
    ("extract", extract_rows),
    ("dataset", write_dataset),
    ("remember", remember_rows),
):
    campaign.command(name)(results)


def planned(folder: CampaignFolder, engine: Engine, *, as_json: bool) -> NoReturn:
    """Plan the problems without a row, with a progress bar, and end the command."""
    before = len(folder.done())
    said = Progress(before, folder.total)
    try:
        with terminated_as_interrupted(), quiet_bar() as bar:
            task = bar.add_task("planning", total=folder.total, completed=before)

            def tell(state: Progress) -> None:
                nonlocal said
                said = state
                bar.update(task, completed=state.done, description=f"planning, {in_words(state)}")

            resume_campaign(folder.path, engine, progress=tell)
    except KeyboardInterrupt:
        typer.echo(f"interrupted: {said.done} of {folder.total} rows in {folder.path}; go on with:", err=True)
        typer.echo(f"  trajopt campaign resume {folder.path}", err=True)
        raise typer.Exit(INTERRUPTED) from None
    tell_status(folder, as_json=as_json)
    raise typer.Exit(0)


def tell_status(folder: CampaignFolder, *, as_json: bool) -> bool:
    """Print the progress of a campaign and its counts of statuses; return whether it is complete."""
    statuses, shards = folder.statuses(), len(folder.shards)
    done = statuses.total()
    if as_json:
        facts = {"name": folder.name, "done": done, "total": folder.total, "shards": shards}
        typer.echo(json.dumps({**facts, "statuses": dict(statuses.most_common())}))
    else:
        typer.echo(f"{folder.name}: {done} of {folder.total} rows in {shards} files of {folder.path}")
        for name, times in statuses.most_common():
            typer.echo(f"  {times:8} {name}")
    return done == folder.total


def in_words(state: Progress) -> str:
    """Print the rate of a campaign."""
    left = "" if state.left is None else f", {state.left:.0f} s left"
    return f"{state.rate:.1f} rows a second{left}"


def engine_of(name: EngineName, address: str, workers: int) -> Engine:
    """Return the engine of a name.

    Raises:
        ProblemError: If an address is given to this machine.
    """
    match name:
        case EngineName.RAY:
            return Ray(address, workers)
        case EngineName.LOCAL if address:
            raise ProblemError("--address is of a cluster of Ray: add --engine ray")
        case EngineName.LOCAL:
            return Local(workers)


@contextmanager
def terminated_as_interrupted() -> Generator[None]:
    """Make SIGTERM, as from a batch system, end the command like Ctrl-C: workers first."""

    def interrupt(*_: object) -> NoReturn:
        raise KeyboardInterrupt

    before = signal.signal(signal.SIGTERM, interrupt)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)
