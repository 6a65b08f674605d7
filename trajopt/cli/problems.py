"""Problems and motions named on the command line: by files, or by a start and a goal."""

import atexit
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from shutil import rmtree
from tempfile import mkdtemp
from typing import Annotated, cast

import typer

from trajopt.cli.options import RobotSource, read_files
from trajopt.files.bundle import Bundle, read_bundle
from trajopt.files.bundle.bundle import SUFFIX
from trajopt.files.moveit import read_motions, read_scene
from trajopt.files.moveit.trajectories import FORMATS, read_trajectory
from trajopt.problem.problem import Problem, named_problem
from trajopt.scene.scene import Scene
from trajopt.values.documents.files import read_json
from trajopt.values.errors import FileFormatError, ProblemError, shown
from trajopt.values.placement import Placement, placement
from trajopt.values.trajectory import Trajectory

MotionArgument = Annotated[Path, typer.Argument(help=f"A bundle or a plan's JSON; with --robot: {FORMATS}.")]
OptionalScene = Annotated[Path | None, typer.Option("--scene", help="Scene, if the file does not name it.")]
OptionalRequest = Annotated[
    Path | None, typer.Option("--request", help="Request, if the file does not name it.")
]


def is_bundle(path: Path) -> bool:
    return path.suffix.lower() == SUFFIX


@cache
def bundle_in(path: Path) -> Bundle:
    folder = mkdtemp(prefix="trajopt-")
    atexit.register(rmtree, folder, ignore_errors=True)
    return read_bundle(path, meshes=folder)


def motion_in(path: Path) -> Trajectory:
    return bundle_in(path).require() if is_bundle(path) else read_trajectory(path)


def problem_of(
    motion: Path, source: RobotSource | None, scene: Path | None, request: Path | None, motions: Path | None
) -> Problem:
    """Return the problem of a motion's file.

    Args:
        source: The robot; None if the file, a bundle or a plan's, contains everything.

    Raises:
        FileFormatError: If something is missing or invalid.
    """
    if is_bundle(motion):
        if source is not None or motions is not None:
            raise FileFormatError(str(motion), "contains the whole problem: leave out --robot and --motions")
        return bundle_in(motion).problem
    if source is None:
        return _named_in(motion, motions)
    if scene is None or request is None:
        raise FileFormatError(str(motion), "with --robot give --scene and --request too")
    return read_files(source.load(), scene, request, motions)[1].problem()


def _named_in(plan: Path, motions: Path | None) -> Problem:
    document = read_json(plan) if plan.suffix == ".json" else None
    source = cast("dict[str, object]", document).get("source") if isinstance(document, dict) else None
    if not isinstance(source, dict):
        raise FileFormatError(str(plan), "names no scene; give --robot, --scene and --request")
    source = cast("dict[str, object]", source)
    if isinstance(source.get("problem"), str):
        if motions is not None:
            raise FileFormatError(str(plan), "is of an installed problem, which takes no --motions")
        return named_problem(str(source["problem"]))
    robot = RobotSource.from_dict(plan, source)
    scene, request = source.get("scene"), source.get("request")
    if ends := Ends.from_dict(source):
        moving = motions or (Path(str(source["motions"])) if "motions" in source else None)
        around, _ = scene_around(robot, Path(scene) if isinstance(scene, str) else None, moving)
        return ends.problem(around)
    if not isinstance(scene, str) or not isinstance(request, str):
        raise FileFormatError(str(plan), "names no scene; give --robot, --scene and --request")
    own = source.get("motions")
    moving = Path(own) if motions is None and isinstance(own, str) else motions
    return read_files(robot.load(), Path(scene), Path(request), moving)[1].problem()


POSE = 6
"""Numbers of a placement: x, y, z, roll, pitch, yaw."""


@dataclass(frozen=True)
class Ends:
    """Start and goal as written: a state, numbers of joints (rad or degrees), or joint=position."""

    start: str
    goal: str
    group: str = ""
    degrees: bool = False

    def problem(self, scene: Scene) -> Problem:
        numbers = _numbers(self.goal.split())
        goal: Placement | str | Sequence[float] | Mapping[str, float]
        if numbers is not None and len(numbers) == POSE:
            goal = placement(numbers[:3], rpy=numbers[3:], degrees=self.degrees)
        else:
            goal = _configuration("--goal", self.goal)
        start = _configuration("--start", self.start)
        return Problem(scene=scene, start=start, goal=goal, group=self.group, degrees=self.degrees)

    def as_dict(self) -> dict[str, object]:
        return {"start": self.start, "goal": self.goal, "group": self.group, "degrees": self.degrees}

    @staticmethod
    def from_dict(document: Mapping[str, object]) -> "Ends | None":
        start, goal = document.get("start"), document.get("goal")
        if not isinstance(start, str) or not isinstance(goal, str):
            return None
        return Ends(start, goal, str(document.get("group", "")), bool(document.get("degrees")))


def scene_around(source: RobotSource, scene: Path | None, motions: Path | None) -> tuple[Scene, list[str]]:
    robot = source.load()
    read = None if scene is None else read_scene(scene, robot)
    around = Scene(robot) if read is None else read.scene
    notes = [*robot.notes, *(() if read is None else read.notes)]
    return around if motions is None else read_motions(motions, around), notes


def _configuration(option: str, text: str) -> str | list[float] | dict[str, float]:
    words = text.split()
    if any("=" in word for word in words):
        return dict(_assigned(option, word) for word in words)
    numbers = _numbers(words)
    if numbers is not None:
        return numbers
    if len(words) != 1:
        raise ProblemError(
            f'{option} must be the name of a state, numbers ("0 0.5 ...") or joint=position, is {shown(text)}'
        )
    return text.strip()


def _assigned(option: str, word: str) -> tuple[str, float]:
    joint, _, value = word.partition("=")
    numbers = _numbers([value])
    if not joint or numbers is None:
        raise ProblemError(f"{option}: {shown(word)} is not joint=position, such as joint_1=0.5")
    return joint, numbers[0]


def _numbers(words: Sequence[str]) -> list[float] | None:
    try:
        return [float(word) for word in words] or None
    except ValueError:
        return None
