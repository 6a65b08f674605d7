"""`trajopt warehouse`: list, show, add, remove, export and import entries of a warehouse."""

import json
from collections.abc import Sequence
from datetime import date, datetime, timedelta
from pathlib import Path
from typing import Annotated, Any, cast

import typer

from trajopt.cli.options import JsonOption, PackageOption, RobotSource, SrdfOption
from trajopt.cli.problems import is_bundle
from trajopt.files.bundle import Bundle
from trajopt.files.moveit import read_request, read_scene
from trajopt.files.moveit.constraints import read_constraints
from trajopt.files.moveit.frames import reading_at
from trajopt.files.moveit.scene_messages import checked_joint_positions, layered_positions
from trajopt.problem.problem import Problem
from trajopt.robot.robot import Robot
from trajopt.scene.scene import Scene
from trajopt.server.warehouse import Constraints, Entry, EntryKind, StoredState, Warehouse
from trajopt.tasks.cartesian import Followed
from trajopt.tasks.sequence import MotionSequence
from trajopt.values.documents.document import read_document
from trajopt.values.errors import FileFormatError, ModelError, shown
from trajopt.values.printed import aligned

warehouse = typer.Typer(
    help="Store robots, scenes, problems, plans, states and constraints in one file, by name and version.",
    no_args_is_help=True,
    rich_markup_mode="rich",
)

FileArgument = Annotated[Path, typer.Argument(help="Warehouse file.")]
NameArgument = Annotated[str, typer.Argument(help="Name of the entry.")]
KINDS = ", ".join(kind.name.lower() for kind in EntryKind)
KindOption = Annotated[str | None, typer.Option("--kind", help=f"One of {KINDS}.")]
VersionOption = Annotated[int | None, typer.Option("--version", min=1, help="Version; default: the latest.")]
OneVersionOption = Annotated[int | None, typer.Option("--version", min=1, help="Version; default: all.")]
RobotNameOption = Annotated[str, typer.Option("--robot", help="Name of the robot.")]
GoalOption = Annotated[str, typer.Option("--goal", help="Text of the goal.")]
SceneNameOption = Annotated[str, typer.Option("--scene", help="Name of the stored scene.")]
TextOption = Annotated[
    str, typer.Option("--text", help="Words that all occur in names, objects, reasons, notes or tags.")
]
TagsOption = Annotated[list[str] | None, typer.Option("--tag", help="Tag (repeatable).")]
SinceOption = Annotated[
    str, typer.Option("--since", help="Stored on this day or later: 2026-11-22, or 2026-11-22T14:30.")
]
UntilOption = Annotated[
    str, typer.Option("--until", help="Stored on this day or earlier; with a time, before it.")
]
SolvedOption = Annotated[
    bool | None, typer.Option("--solved/--failed", help="Whether planning found a motion.")
]
NewestOption = Annotated[bool, typer.Option("--newest", help="Only the latest version of each name.")]
NoteOption = Annotated[str, typer.Option("--note", help="Note on the entry.")]
TagOption = Annotated[list[str] | None, typer.Option("--tag", help="Tag for searches (repeatable).")]
BundleOption = Annotated[
    Path | None, typer.Option("--bundle", help="Store this bundle: a plan, a failure or a problem.")
]
RobotOption = Annotated[
    str | None,
    typer.Option(
        "--robot",
        help="Store this robot (panda, ur5, ..., or a description's file), or one of the following of it.",
    ),
]
SceneOption = Annotated[Path | None, typer.Option("--scene", help="MoveIt PlanningScene in YAML.")]
RequestOption = Annotated[
    Path | None, typer.Option("--request", help="With --scene: MoveIt MotionPlanRequest in YAML.")
]
StateOption = Annotated[Path | None, typer.Option("--state", help="MoveIt RobotState in YAML.")]
ConstraintsOption = Annotated[Path | None, typer.Option("--constraints", help="MoveIt Constraints in YAML.")]
SourcesArgument = Annotated[list[Path], typer.Argument(help="Warehouses and bundles to import.")]
TargetOption = Annotated[
    Path,
    typer.Option("--out", help="Bundle (x.trajopt), or warehouse that receives its missing entries."),
]
OptionalName = Annotated[str, typer.Argument(help="Name of the entry; default: all entries.")]


@warehouse.command()
def ls(
    file: FileArgument,
    kind: KindOption = None,
    robot: RobotNameOption = "",
    goal: GoalOption = "",
    scene: SceneNameOption = "",
    text: TextOption = "",
    tag: TagsOption = None,
    since: SinceOption = "",
    until: UntilOption = "",
    solved: SolvedOption = None,
    newest: NewestOption = False,
    as_json: JsonOption = False,
) -> None:
    """List the entries, the latest first. Exit status 0, or 2 for bad input."""
    with Warehouse(file, create=False) as kept:
        found = kept.find(
            kind=_kind(kind), robot=robot, goal=goal, scene=scene, text=text, tags=tuple(tag or ()),
            since=_day(since), until=_day(until, end=True), solved=solved, newest=newest,
        )  # fmt: skip
    typer.echo(json.dumps([entry.as_dict() for entry in found]) if as_json else listing(found))


@warehouse.command()
def show(
    file: FileArgument,
    name: NameArgument,
    kind: KindOption = None,
    version: VersionOption = None,
    as_json: JsonOption = False,
) -> None:
    """Show an entry and its versions. Exit status 0, or 2 for bad input."""
    with Warehouse(file, create=False) as kept:
        entry = kept.entry(name, kind=_kind(kind), version=version)
        versions = kept.find(kind=entry.kind, name=name)
        words = _words(kept.load(entry))
    if as_json:
        numbers = sorted(each.version for each in versions)
        typer.echo(json.dumps({**entry.as_dict(), "versions": numbers, "shown": words}))
        return
    typer.echo(f"{entry}\n{entry.note}\n".rstrip() + f"\n\n{words}\n\n{listing(versions)}")


@warehouse.command()
def add(
    file: FileArgument,
    name: NameArgument,
    bundle: BundleOption = None,
    robot: RobotOption = None,
    scene: SceneOption = None,
    request: RequestOption = None,
    state: StateOption = None,
    constraints: ConstraintsOption = None,
    srdf: SrdfOption = None,
    package_dir: PackageOption = None,
    tag: TagOption = None,
    note: NoteOption = "",
    as_json: JsonOption = False,
) -> None:
    """Store an entry; earlier versions of its name remain. Exit status 0, or 2 for bad input."""
    tags = tuple(tag or ())
    if bundle is not None:
        if robot is not None:
            raise ModelError("a bundle has its robot: give --bundle or --robot")
        with Warehouse(file) as kept:
            entry = kept.add_bundle(bundle, name, tags=tags, note=note)
    else:
        options = robot, srdf, tuple(package_dir or ()), scene, request, state, constraints
        value = value_given(*options)
        with Warehouse(file) as kept:
            entry = kept.add(name, value, tags=tags, note=note)
    typer.echo(json.dumps(entry.as_dict()) if as_json else f"kept: {entry}")


@warehouse.command()
def rm(
    file: FileArgument,
    name: NameArgument,
    kind: KindOption = None,
    version: OneVersionOption = None,
    as_json: JsonOption = False,
) -> None:
    """Delete an entry permanently. Exit status 0, or 2 for bad input."""
    with Warehouse(file, create=False) as kept:
        gone = kept.remove(name, kind=_kind(kind), version=version)
    words = "\n".join(f"removed: {entry}" for entry in gone)
    typer.echo(json.dumps([entry.as_dict() for entry in gone]) if as_json else words)


@warehouse.command()
def export(
    file: FileArgument,
    out: TargetOption,
    name: OptionalName = "",
    kind: KindOption = None,
    version: VersionOption = None,
    as_json: JsonOption = False,
) -> None:
    """Write a bundle, or copy into another warehouse. Exit status 0, or 2 for bad input."""
    with Warehouse(file, create=False) as kept:
        if not name and (is_bundle(out) or version is not None):
            raise ModelError("name the entry: a bundle has one plan or problem")
        chosen = (
            (kept.entry(name, kind=_kind(kind), version=version),) if name else kept.find(kind=_kind(kind))
        )
        if is_bundle(out):
            kept.export(chosen[0], out)
        else:
            with Warehouse(out) as other:
                chosen = kept.copy_to(other, chosen)
    _say(chosen, f"written to {out}", as_json=as_json)


@warehouse.command(name="import")
def take_in(file: FileArgument, sources: SourcesArgument, as_json: JsonOption = False) -> None:
    """Import other warehouses and bundles. Exit status 0, or 2 for bad input."""
    taken = list[Entry]()
    with Warehouse(file) as kept, kept.together():
        for source in sources:
            if is_bundle(source):
                taken.append(kept.add_bundle(source))
            else:
                with Warehouse(source, create=False) as other:
                    taken += other.copy_to(kept)
    _say(taken, f"kept in {file}", as_json=as_json)


def listing(entries: Sequence[Entry]) -> str:
    """Return a line for each entry, in columns."""
    if not entries:
        return "nothing"
    rows = [
        (
            entry.kind.name.lower(),
            entry.name,
            str(entry.version),
            entry.robot,
            entry.status,
            "" if entry.duration is None else f"{entry.duration:.3f} s",
            datetime.fromisoformat(entry.made).astimezone().strftime("%Y-%m-%d %H:%M"),
            " ".join(entry.tags),
        )
        for entry in entries
    ]
    table = [("kind", "name", "version", "robot", "status", "motion", "kept", "tags"), *rows]
    return "\n".join(aligned(table))


def _say(entries: Sequence[Entry], done: str, *, as_json: bool) -> None:
    words = f"{listing(entries)}\n\n{done}" if entries else f"nothing new: all was {done}"
    typer.echo(json.dumps([entry.as_dict() for entry in entries]) if as_json else words)


def _words(value: object) -> str:
    match value:
        case Bundle():
            return str(value)
        case StoredState():
            return "\n".join(f"  {joint:<24} {at:g}" for joint, at in value.positions.items())
        case Constraints():
            return "\n".join(f"  {each.in_full()}" for each in value.requirements)
        case MotionSequence() | Followed():
            return str(cast("MotionSequence[Any] | Followed", value).explain())
        case _:
            return str(value)


def _kind(name: str | None) -> EntryKind | None:
    if name is None:
        return None
    if name.upper() not in EntryKind.__members__:
        raise ModelError(f"--kind must be one of {KINDS}, is {shown(name)}")
    return EntryKind[name.upper()]


def _day(text: str, *, end: bool = False) -> datetime | None:
    if not text:
        return None
    try:
        when = datetime.fromisoformat(text)
        alone = len(text) == len(date.min.isoformat())
        return (when + timedelta(days=1) if end and alone else when).astimezone()
    except (ValueError, OverflowError) as error:
        raise ModelError(f"{shown(text)} is not a date: write 2026-11-22, or 2026-11-22T14:30") from error


def value_given(
    name: str | None,
    srdf: Path | None,
    packages: tuple[Path, ...],
    scene: Path | None,
    request: Path | None,
    state: Path | None,
    constraints: Path | None,
) -> Robot | Scene | Problem | StoredState | Constraints:
    """Return the value that options state."""
    if name is None:
        raise ModelError("give the entry: --bundle, or --robot, alone or with an option of its own")
    if sum(each is not None for each in (scene, state, constraints)) > 1 or (request and not scene):
        raise ModelError("give one of --scene (with or without --request), --state and --constraints")
    robot = RobotSource(name, srdf, None, packages).load()
    if scene is not None:
        around = read_scene(scene, robot)
        return around.scene if request is None else read_request(request, around).problem()
    if state is not None:
        return StoredState(robot.name, checked_joint_positions(read_document(state), robot))
    return robot if constraints is None else _constraints(constraints, robot)


def _constraints(path: Path, robot: Robot) -> Constraints:
    scene = Scene(robot)
    reading = reading_at(scene, layered_positions(robot))
    required, around = read_constraints(read_document(path), scene, reading)
    if not required:
        raise FileFormatError(str(path), "requires nothing")
    if around is not scene:
        raise FileFormatError(str(path), "needs a frame of its own: keep it as part of a problem")
    return Constraints(robot.name, required)
