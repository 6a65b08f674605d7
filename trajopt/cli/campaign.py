"""`trajopt campaign`: thousands to millions of plans, resumable after an interruption."""

import json
import signal
from collections.abc import Generator, Sequence
from contextlib import contextmanager
from enum import Enum
from pathlib import Path
from typing import Annotated, NoReturn

import numpy as np
import typer

from trajopt.cli.options import JsonOption, RobotSource, read_files, robot_options
from trajopt.cli.progress import quiet_bar
from trajopt.files.moveit import read_scene
from trajopt.lab import campaign as campaigns
from trajopt.lab.campaign.page import lines, map_of, page
from trajopt.lab.suite import definitions
from trajopt.problem.problem import Problem
from trajopt.robot.robot import Robot
from trajopt.scene.scene import Scene
from trajopt.server.warehouse import Warehouse
from trajopt.values.documents.document import write_text
from trajopt.values.errors import CampaignError, NameNotFound, ProblemError

FolderArgument = Annotated[Path, typer.Argument(help="Folder of the campaign.")]
BesideOption = Annotated[
    Path | None, typer.Option("--beside", help="Folder of another campaign to compare with.")
]
HtmlOption = Annotated[Path | None, typer.Option("--html", help="Write a page with plots here.")]
PictureOption = Annotated[
    Path | None, typer.Option("--map", help="Write the map of base placements here (SVG).")
]
RowsArgument = Annotated[list[str], typer.Argument(help="Ids of rows, or prefixes of them.")]
BundlesOption = Annotated[Path, typer.Option("--out", help="Folder for the bundles.")]
TableOption = Annotated[Path, typer.Option("--out", help="Output data set (.npz).")]
KeptOption = Annotated[
    Path, typer.Option("--experience", help="Warehouse for the motions; created if missing.")
]
PointsOption = Annotated[int, typer.Option("--points", min=2, help="Number of points of each motion.")]
INTERRUPTED = 130
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
OutOption = Annotated[Path, typer.Option("--out", help="Folder of the campaign.")]
SceneOption = Annotated[
    Path | None, typer.Option("--scene", help="random, perturbed, placements: MoveIt PlanningScene in YAML.")
]
RequestsOption = Annotated[
    list[Path] | None,
    typer.Option(
        "--request", help="perturbed, placements: MoveIt MotionPlanRequest in YAML (placements: repeatable)."
    ),
]
GroupOption = Annotated[str, typer.Option("--group", help="random: planning group; default: the only one.")]
CountOption = Annotated[int, typer.Option("--count", min=1, help="Number of random problems.")]
SeedOption = Annotated[int, typer.Option("--seed", min=0, help="Seed of the random numbers.")]
ShiftOption = Annotated[
    float,
    typer.Option("--shift", min=0.0, help=r"perturbed: largest shift of objects along each axis \[m]."),
]
TurnOption = Annotated[
    float, typer.Option("--turn", min=0.0, help=r"perturbed: largest rotation of objects \[rad].")
]
XOption = Annotated[
    tuple[float, float, int],
    typer.Option("--x", metavar="FROM TO STEPS", help=r"placements: x of the base \[m]."),
]
YOption = Annotated[
    tuple[float, float, int],
    typer.Option("--y", metavar="FROM TO STEPS", help=r"placements: y of the base \[m]."),
]
YawOption = Annotated[
    tuple[float, float, int],
    typer.Option("--yaw", metavar="FROM TO STEPS", help=r"placements: yaw of the base \[rad]."),
]
SetsOption = Annotated[
    str, typer.Option("--sets", help="Of a folder: names of sets, separated by commas; default: all.")
]
LimitOption = Annotated[
    int | None, typer.Option("--limit", min=1, help="Of a folder: most problems of each set.")
]
MethodsOption = Annotated[
    str,
    typer.Option("--methods", help="Planning methods, separated by commas; each plans every problem."),
]
ImproveOption = Annotated[bool, typer.Option("--improve", help="Also search for shorter motions.")]
TimeBudgetOption = Annotated[
    float | None,
    typer.Option("--time-budget", metavar="S", help=r"CPU time limit of a problem \[s]."),
]
WorkOption = Annotated[
    int | None,
    typer.Option(
        "--work", min=1, help="Most configurations that a problem may evaluate: the same on any machine."
    ),
]
AttemptsOption = Annotated[
    int | None,
    typer.Option("--attempts", min=1, help="Most seeds per problem; 1 for the straight line alone."),
]
MostOption = Annotated[
    float,
    typer.Option(
        "--most-seconds", metavar="S", help=r"Wall-clock time after which a problem counts as hanging \[s]."
    ),
]
EngineOption = Annotated[
    EngineName, typer.Option("--engine", help="Planning processes: on this machine, or on a Ray cluster.")
]
AddressOption = Annotated[
    str,
    typer.Option("--address", help="Ray: address of the cluster (HOST:PORT or auto); default: this machine."),
]
WorkersOption = Annotated[
    int, typer.Option("--workers", min=0, help="Number of planning processes; 0 for one per core.")
]

campaign = typer.Typer(
    help="Plan thousands to millions of problems: run, resume, inspect and compare.",
    no_args_is_help=True,
)


@campaign.command()
@robot_options
def run(
    source: SourceArgument,
    out: OutOption,
    robot: RobotSource | None = None,
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
    engine: EngineOption = EngineName.LOCAL,
    address: AddressOption = "",
    workers: WorkersOption = 0,
    as_json: JsonOption = False,
) -> None:
    """Plan every problem of a source and store a row for each.

    Exit status 0 if all have one, 130 interrupted, 2 bad input.
    """
    loaded = None if robot is None else robot.load()
    listed = [name for name in sets.split(",") if name]
    if Path(source).is_dir():
        found = campaigns.from_folder(source, _needed(loaded, source), sets=listed, limit=limit)
    elif Path(source).suffix == TABLE:
        found = campaigns.from_table(source, _around(loaded, source, scene), group=group)
    elif source == Generated.RANDOM.value:
        around = _around(loaded, source, scene)
        found = campaigns.random_motions(around, count, group=group, seed=seed)
    elif source == Generated.PERTURBED.value:
        problem, *more = _problems(loaded, source, scene, request)
        if more:
            raise ProblemError(f"{source} takes 1 --request, {1 + len(more)} are given")
        found = campaigns.perturbed(problem, count, shift=shift, turn=turn, seed=seed)
    elif source == Generated.PLACEMENTS.value:
        tasks = _problems(loaded, source, scene, request)
        found = campaigns.base_placements(tasks, x=steps(*x), y=steps(*y), yaw=steps(*yaw))
    else:
        known = [item.name for item in definitions()]
        if source not in known:
            names = [*(each.value for each in Generated), *known]
            raise NameNotFound("folder, generator or installed problem", source, names)
        found = campaigns.installed(source, count)
    options = [
        campaigns.Options(method or None, improve, False, time_budget, work, attempts)
        for method in methods.split(",")
    ]
    begun = campaigns.CampaignFolder.begin(
        campaigns.Campaign(found.name, [found], options, most_seconds=most_seconds), out
    )
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
    planned(campaigns.CampaignFolder.open(folder), engine_of(engine, address, workers), as_json=as_json)


@campaign.command()
def status(folder: FolderArgument, as_json: JsonOption = False) -> None:
    """Show the progress of a campaign. Exit status 0 if every problem has a row, else 1."""
    raise typer.Exit(0 if tell_status(campaigns.CampaignFolder.open(folder), as_json=as_json) else 1)


@campaign.command()
def report(
    folder: FolderArgument,
    beside: BesideOption = None,
    html: HtmlOption = None,
    picture: PictureOption = None,
    as_json: JsonOption = False,
) -> None:
    """Summarise the present results, and compare them with another campaign. Exit status 0 or 2."""
    opened = campaigns.CampaignFolder.open(folder)
    found = campaigns.summary(opened)
    compared = (
        None if beside is None else campaigns.compare_campaigns(campaigns.CampaignFolder.open(beside), opened)
    )
    if html is not None:
        write_text(html, page(found, compared))
    if picture is not None:
        if found.places is None:
            raise CampaignError(f"{folder} does not vary the place of a base: there is no map to draw")
        write_text(picture, map_of(found.places))
    if as_json:
        beside_it = None if compared is None else compared.as_dict()
        typer.echo(json.dumps({**found.as_dict(), "beside": beside_it}))
    else:
        typer.echo("\n".join(lines(found, compared)))


@campaign.command("extract")
def extract_rows(folder: FolderArgument, rows: RowsArgument, out: BundlesOption = Path()) -> None:
    """Plan rows again and write bundles. Exit status 0 if the results match, 1 if not, 2 bad input."""
    opened = campaigns.CampaignFolder.open(folder)
    found = [campaigns.extract(opened, row, out / f"{row}.trajopt") for row in rows]
    words = {True: "as in the row", False: "NOT as in the row", None: "the problem alone"}
    for each in found:
        typer.echo(f"{each.path}: {words[each.same]}")
    raise typer.Exit(1 if any(each.same is False for each in found) else 0)


@campaign.command("dataset")
def write_dataset(folder: FolderArgument, out: TableOption, points: PointsOption = 64) -> None:
    """Write the verified motions as arrays of one shape, for training. Exit status 0 or 2."""
    found = campaigns.dataset(campaigns.CampaignFolder.open(folder), points)
    found.write(out)
    typer.echo(f"{len(found)} motions of {len(found.joint_names)} joints at {points} points each: {out}")


@campaign.command("remember")
def remember_rows(folder: FolderArgument, experience: KeptOption) -> None:
    """Store the verified motions as experience for plan and bench. Exit status 0 or 2."""
    opened = campaigns.CampaignFolder.open(folder)
    with Warehouse(experience) as kept:
        remembered = kept.experience()
        count = campaigns.remember(opened, remembered)
        typer.echo(f"{count} motions more, {len(remembered)} are remembered in {experience}")


def planned(folder: campaigns.CampaignFolder, engine: campaigns.Engine, *, as_json: bool) -> NoReturn:
    """Plan the problems without a row, with a progress bar, and end the command."""
    before = len(folder.done())
    said = campaigns.Progress(before, folder.total)
    try:
        with terminated_as_interrupted(), quiet_bar() as bar:
            task = bar.add_task("planning", total=folder.total, completed=before)

            def tell(state: campaigns.Progress) -> None:
                nonlocal said
                said = state
                bar.update(task, completed=state.done, description=f"planning, {in_words(state)}")

            campaigns.resume_campaign(folder.path, engine, progress=tell)
    except KeyboardInterrupt:
        typer.echo(f"interrupted: {said.done} of {folder.total} rows in {folder.path}; go on with:", err=True)
        typer.echo(f"  trajopt campaign resume {folder.path}", err=True)
        raise typer.Exit(INTERRUPTED) from None
    tell_status(folder, as_json=as_json)
    raise typer.Exit(0)


def tell_status(folder: campaigns.CampaignFolder, *, as_json: bool) -> bool:
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


def in_words(state: campaigns.Progress) -> str:
    left = "" if state.left is None else f", {state.left:.0f} s left"
    return f"{state.rate:.1f} rows a second{left}"


def engine_of(name: EngineName, address: str, workers: int) -> campaigns.Engine:
    match name:
        case EngineName.RAY:
            return campaigns.Ray(address, workers)
        case EngineName.LOCAL if address:
            raise ProblemError("--address is of a cluster of Ray: add --engine ray")
        case EngineName.LOCAL:
            return campaigns.Local(workers)


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


TABLE = ".parquet"


class Generated(Enum):
    """Names of sources that generate problems, in addition to installed problems."""

    RANDOM = "random"
    PERTURBED = "perturbed"
    PLACEMENTS = "placements"


def _needed(robot: Robot | None, source: str) -> Robot:
    if robot is None:
        raise ProblemError(f"{source} needs a robot: name one with --robot")
    return robot


def _around(robot: Robot | None, source: str, scene: Path | None) -> Scene:
    known = _needed(robot, source)
    return Scene(known) if scene is None else read_scene(scene, known).scene


def _problems(
    robot: Robot | None, source: str, scene: Path | None, requests: Sequence[Path] | None
) -> list[Problem]:
    if scene is None or not requests:
        raise ProblemError(f"{source} needs a problem: give --scene and --request")
    known = _needed(robot, source)
    return [read_files(known, scene, each)[1].problem() for each in requests]


def steps(first: float, last: float, count: int) -> tuple[float, ...]:
    if count < 1:
        raise ProblemError(f"a grid needs at least one step, {count} are given")
    return tuple(float(value) for value in np.linspace(first, last, count))
