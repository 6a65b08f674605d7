"""Sources of a campaign's problems."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import product
from pathlib import Path

from trajopt.lab.campaign.columns import need_parquet, read_rows, size_of
from trajopt.lab.campaign.recipes import (
    BasePlaced,
    FromMessages,
    Installed,
    JointToJoint,
    Packer,
    Perturbed,
    RandomMotion,
    Recipe,
    Stated,
)
from trajopt.lab.suite import installed_definitions
from trajopt.lab.suite.instance import find_instances
from trajopt.problem.problem import Problem
from trajopt.problem.stated import only_group
from trajopt.robot.robot import Robot
from trajopt.scene.scene import Scene
from trajopt.values.arrays import number, one_of, several
from trajopt.values.documents.files import read_text
from trajopt.values.errors import FileFormatError, ProblemError, ShapeError, shown
from trajopt.values.errors.arguments import checked


@dataclass(frozen=True)
class Posed:
    """One problem of a campaign, before it is made; its robot's name is empty if unknown."""

    family: str
    number: int
    robot: str
    recipe: Recipe
    parameters: Mapping[str, float] = field(default_factory=dict[str, float])


@dataclass(frozen=True, eq=False)
class ProblemSource:
    """Some problems of a campaign; `pose` yields them reproducibly, with shared values packed."""

    name: str
    count: int
    pose: Callable[[Packer], Iterator[Posed]] = field(repr=False)


@checked
def from_problems(name: str, listed: Sequence[Problem]) -> ProblemSource:
    """Return a source of given problems, as plain data like in a bundle."""
    kept = several("listed", listed, Problem)

    def pose(packer: Packer) -> Iterator[Posed]:
        for count, item in enumerate(kept):
            yield Posed(name, count, item.scene.robot.name, Stated(packer.statement(item)))

    return ProblemSource(name, len(kept), pose)


@checked
def from_folder(
    path: Path | str, robot: Robot, *, sets: Sequence[str] = (), limit: int | None = None
) -> ProblemSource:
    """Return the problems of a folder of MoveIt files: DIR/<set>/sceneNNNN.yaml, requestNNNN.yaml."""
    found = find_instances(Path(path), robot, sets, limit=limit)

    def pose(packer: Packer) -> Iterator[Posed]:
        key = packer.key(robot)
        for item in found:
            family, count = item.name.rsplit("/", maxsplit=1)
            texts = dict(zip(("scene", "request", "motions"), map(read_text, item.files), strict=False))
            yield Posed(family, int(count), robot.name, FromMessages(robot=key, name=item.name, **texts))

    return ProblemSource(Path(path).name, len(found), pose)


@checked
def from_table(path: Path | str, around: Robot | Scene, *, group: str = "") -> ProblemSource:
    """Return the problems of a Parquet table, one per row.

    Its columns are `scene`, `request` and optionally `motions`: MoveIt's messages as text, YAML or JSON; or
    `start` and `goal`: positions of the group's joints [rad | m]. `family` and `number` define the set in the
    statistics; by default the file's name and the row.

    Args:
        around: The robot; or, for starts and goals, the scene.
        group: For starts and goals; optional if the robot has only one.

    Raises:
        MissingExtra: Without pyarrow.
        CampaignError: If the file cannot be read.
        FileFormatError: If it has neither kind of columns.
        ProblemError: If no group is named and the robot has several.
    """
    need_parquet()
    count, columns = size_of(Path(path))
    scene = Scene(around) if isinstance(around, Robot) else around
    messages = {"scene", "request"} <= columns
    if not messages and not {"start", "goal"} <= columns:
        raise FileFormatError(str(path), "has neither the columns scene and request, nor start and goal")
    moving = "" if messages else group or only_group(scene.robot)

    def pose(packer: Packer) -> Iterator[Posed]:
        key, robot = packer.key(scene.robot if messages else scene), scene.robot.name
        for place, row in enumerate(read_rows(Path(path))):
            family, stated = str(row.get("family") or Path(path).stem), row.get("number")
            each = place if stated is None else int(stated)
            if messages:
                texts = {name: str(row.get(name) or "") for name in ("scene", "request", "motions")}
                yield Posed(family, each, robot, FromMessages(robot=key, name=f"{family}/{each}", **texts))
            else:
                start, goal = tuple(row["start"] or ()), tuple(row["goal"] or ())
                yield Posed(family, each, robot, JointToJoint(key, moving, start, goal))

    return ProblemSource(Path(path).stem, count, pose)


@checked
def random_motions(
    scene: Scene, count: int, *, group: str = "", seed: int = 0, name: str = "random motions"
) -> ProblemSource:
    """Return motions between random free configurations in one scene.

    Args:
        seed: Of the random generator; the first thousand are the same for any count.

    Raises:
        GroupNotFound: If there is no such group.
        ProblemError: If no group is named and the robot has several, or the count is not positive.
    """
    moving = group or only_group(scene.robot)
    scene.robot.group(moving)
    total = _count(count)

    def pose(packer: Packer) -> Iterator[Posed]:
        key = packer.key(scene)
        for each in range(total):
            yield Posed(name, each, scene.robot.name, RandomMotion(key, moving, seed, each))

    return ProblemSource(name, total, pose)


@checked
def perturbed(
    problem: Problem, count: int, *, shift: float, turn: float = 0.0, seed: int = 0
) -> ProblemSource:
    """Return variants of a problem: objects displaced by up to `shift` [m] and `turn` [rad]."""
    total = _count(count)
    for label, value in (("shift", shift), ("turn", turn)):
        if number(label, value) < 0.0:
            raise ShapeError(label, f"is negative: {value:g}")

    def pose(packer: Packer) -> Iterator[Posed]:
        key = packer.key(problem)
        for each in range(total):
            recipe = Perturbed(key, seed, each, float(shift), float(turn))
            yield Posed(problem.name, each, problem.scene.robot.name, recipe)

    return ProblemSource(f"{problem.name}, perturbed", total, pose)


@checked
def base_placements(
    tasks: Sequence[Problem],
    *,
    x: Sequence[float],
    y: Sequence[float],
    z: Sequence[float] = (0.0,),
    yaw: Sequence[float] = (0.0,),
) -> ProblemSource:
    """Return problems for every placement of the robot's base on a grid, to find the best one.

    Goals and objects stay in the world, the start stays in joint space.

    Args:
        x: Places of its root in the world [m], as `y` and `z`.
        yaw: Angles about the vertical [rad].

    Raises:
        ProblemError: If there is no task or no placement, or a robot has a moving base.
        ShapeError: If a number is not finite.
    """
    kept = several("tasks", tasks, Problem)
    axes = {"x": x, "y": y, "z": z, "yaw": yaw}
    at = {name: tuple(number(name, float(value)) for value in values) for name, values in axes.items()}
    for name, values in {"tasks": kept, **at}.items():
        if not values:
            raise ProblemError(f"{name} is empty: there is nothing to plan")
    for task in kept:
        if task.scene.robot.base.joints:
            raise ProblemError(f"the base of {task.scene.robot.name} moves by itself")
    grid = list(product(at["x"], at["y"], at["z"], at["yaw"]))

    def pose(packer: Packer) -> Iterator[Posed]:
        keys = [packer.key(task) for task in kept]
        for count, where in enumerate(grid):
            parameters = dict(zip(axes, where, strict=True))
            for task, key in zip(kept, keys, strict=True):
                recipe = BasePlaced(key, where)
                yield Posed(task.name, count, task.scene.robot.name, recipe, parameters)

    return ProblemSource("base placements", len(grid) * len(kept), pose)


@checked
def installed(name: str, count: int = 1) -> ProblemSource:
    """Return instances of an installed problem: the fixed one, then random ones."""
    definition, total = installed_definitions((name,))[0], _count(count)
    if total > 1:
        definition.instance(1)  # says so where there is none

    def pose(packer: Packer) -> Iterator[Posed]:
        del packer
        for draw in range(total):
            yield Posed(name, draw, "", Installed(name, draw))

    return ProblemSource(name, total, pose)


def _count(count: int) -> int:
    if one_of("count", count, int) < 1:
        raise ProblemError(f"count must be positive, is {shown(count)}")
    return count
