"""Problems and motions named on the command line: by files, or by a start and a goal."""

import atexit
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from shutil import rmtree
from tempfile import mkdtemp
from typing import TYPE_CHECKING, Annotated, Any, TypeAlias, cast

import typer

from trajopt.cli.options import RobotSource, read_files
from trajopt.files.bundle import Bundle
from trajopt.files.bundle.bundle import SUFFIX, read_saved
from trajopt.files.moveit import read_motions, read_scene
from trajopt.files.moveit.trajectories import FORMATS, read_trajectory
from trajopt.problem.problem import Problem, named_problem
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.scene import Scene
from trajopt.values.documents.files import read_json
from trajopt.values.errors import FileFormatError, ProblemError, shown
from trajopt.values.placement import Placement, placement
from trajopt.values.trajectory import Trajectory

if TYPE_CHECKING:
    from trajopt.tasks.cartesian import Followed
    from trajopt.tasks.grasping.result import PickPlaceResult
    from trajopt.tasks.result import TaskResult
    from trajopt.tasks.sequence import MotionSequence

MotionArgument = Annotated[Path, typer.Argument(help=f"A bundle or a plan's JSON; with --robot: {FORMATS}.")]
OptionalScene = Annotated[Path | None, typer.Option("--scene", help="Scene, if the file does not name it.")]
OptionalRequest = Annotated[
    Path | None, typer.Option("--request", help="Request, or a bundle, if the file names none.")
]


def is_bundle(path: Path) -> bool:
    return path.suffix.lower() == SUFFIX


Saved: TypeAlias = "Bundle | Followed | MotionSequence[Any]"
"""Content of a file that `save` wrote."""


@cache
def saved_in(path: Path) -> Saved:
    from trajopt.tasks.cartesian import Followed  # slow to import
    from trajopt.tasks.sequence import MotionSequence

    folder = mkdtemp(prefix="trajopt-")
    atexit.register(rmtree, folder, ignore_errors=True)
    saved = read_saved(path, meshes=folder)
    if not isinstance(saved, Bundle | Followed | MotionSequence):
        raise FileFormatError(str(path), f"holds no plan, problem or result, but {shown(saved)}")
    return cast("Saved", saved)


def motions_in(path: Path) -> "TaskResult | PickPlaceResult | None":
    from trajopt.tasks.grasping.result import PickPlaceResult  # slow to import
    from trajopt.tasks.result import TaskResult

    saved = saved_in(path) if is_bundle(path) else None
    return saved if isinstance(saved, TaskResult | PickPlaceResult) else None


def _one_motion(path: Path) -> "Bundle | Followed":
    from trajopt.tasks.sequence import MotionSequence  # slow to import

    saved = saved_in(path)
    if isinstance(saved, MotionSequence):
        raise FileFormatError(
            str(path),
            "is the result of several motions, and this command reads one: view, check, simulate, "
            "report and export read several",
        )
    return saved


def motion_in(path: Path) -> Trajectory:
    if not is_bundle(path):
        return read_trajectory(path)
    saved = _one_motion(path)
    return saved.require() if isinstance(saved, Bundle) else saved.result.require().trajectory


def model_and_motion(
    motion: Path, source: RobotSource | None, scene: Path | None, request: Path | None, motions: Path | None
) -> tuple[ReducedModel, Trajectory]:
    trajectory = motion_in(motion)
    reduced = problem_of(motion, source, scene, request, motions).reduced
    return reduced, trajectory.ordered(reduced.joint_names)


def nothing_beside(path: Path, source: RobotSource | None, *files: Path | None) -> None:
    if source is not None or any(file is not None for file in files):
        raise FileFormatError(
            str(path), "contains the whole problem: leave out --robot, --scene, --request and --motions"
        )


def problem_of(
    motion: Path, source: RobotSource | None, scene: Path | None, request: Path | None, motions: Path | None
) -> Problem:
    """Return the problem of a motion's file.

    Args:
        source: The robot; None if the file, a bundle or a plan's, or a bundle as request contains everything.

    Raises:
        FileFormatError: If something is missing or invalid.
    """
    if is_bundle(motion):
        nothing_beside(motion, source, scene, request, motions)
        return _one_motion(motion).problem
    if request is not None and is_bundle(request):
        nothing_beside(request, source, scene, motions)
        return _one_motion(request).problem
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
        assigned = [_assigned(option, word) for word in words]
        if len(dict(assigned)) < len(assigned):
            raise ProblemError(f"{option} has two positions of one joint: {shown(text)}")
        return dict(assigned)
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
