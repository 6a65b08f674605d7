"""Tasks in YAML."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from trajopt.problem.requirements import follows_curve
from trajopt.problem.tool_speed import tool_speed
from trajopt.robot.configuration import ConfigurationLike
from trajopt.scene.scene import Scene
from trajopt.tasks.any_order import AnyOrder
from trajopt.tasks.cartesian.curves import polyline, pose_of, read_poses
from trajopt.tasks.cartesian.following import Begin, FollowOptions
from trajopt.tasks.grasping.grasp import Place, grasps_of
from trajopt.tasks.grasping.gripper import Gripper, gripper_of
from trajopt.tasks.grasping.stages import PickObject, PlaceObject, SetGripper
from trajopt.tasks.search import TaskStage
from trajopt.tasks.stages import (
    AttachObject,
    DetachObject,
    Dwell,
    Fallback,
    FollowCurve,
    ForEach,
    MoveObject,
    MoveTo,
    OneOf,
    StageCost,
    StageLimits,
    Together,
    Within,
    duration,
)
from trajopt.tasks.task import Task
from trajopt.values.documents.document import Node, read_document
from trajopt.values.errors import TrajoptError
from trajopt.values.placement import Placement, placement

UPRIGHT = placement().rotation
"""Orientation of a pose without one."""


def read_task(path: Path | str, scene: Scene) -> Task:
    """Read a task from YAML, for a scene.

    The file has `start` and `stages`, and optionally `group`, `blend`, `name` and `masses` (object -> [kg]),
    which MoveIt's scenes lack. A pose is a mapping of `position` [m] and optionally `rpy` [rad] or
    `quaternion`. Each stage is a mapping with one of these keys, and optionally `name`:

    - `move_to`: a state, joint -> position [rad | m], or a pose of the tool; optionally `group`,
    - `dwell` [s], `gripper` (opening [m]), `pick` (an object, with proposed grasps), `place` with `at`; the
      last three optionally with the gripper's `end_effector`,
    - `attach` with `link` and optionally `touch_links` (a list) and `within` [m], `detach`,
    - `move_object` with `to` and optionally `seconds`,
    - `follow` (a frame) with `poses` or `file`, optionally `blend`, `speed` [m/s], `steady`, `off` [m],
    - `any_order` (optionally with `then`), `for_each`, `one_of` (optionally with `cost` and `ways_each`),
      `fallback`, `together`, and `within` with `limits`: each item is a stage or a list of stages. `cost`
      and `limits` are mappings of the members of `StageCost` and `StageLimits`.

    Raises:
        FileFormatError: If the file is missing or invalid.
        ProblemError: If a stage cannot be done.
    """
    document = read_document(path)
    if not document.has("start"):
        raise document["start"].error("is missing: name a state, or joint -> position")
    start = _configuration(document["start"])
    return task_in(document, scene, start=start, name=Path(path).stem, folder=Path(path).parent)


def task_in(
    document: Node, scene: Scene, *, start: ConfigurationLike, name: str = "task", folder: Path | None = None
) -> Task:
    """Return the task of a document, as `read_task` does.

    Args:
        start: Start, if the document has none; likewise `name`.
        folder: Folder of the files of curves; None refuses them.
    """
    document.only(("start", "stages", "group", "blend", "name", "masses"))
    for item, mass in document["masses"].members().items():
        try:
            scene = scene.with_mass(item, mass.number())
        except TrajoptError as error:
            raise mass.error(str(error)) from error
    group = document["group"].text(default="")
    cell = _Cell(scene, folder, group)
    return Task(
        scene=scene,
        start=_configuration(document["start"]) if document.has("start") else start,
        stages=[_stage(node, cell) for node in document["stages"].elements()],
        group=group,
        blend=document["blend"].number(default=0.0),
        name=document["name"].text(default=name),
    )


@dataclass(frozen=True, eq=False)
class _Cell:
    scene: Scene
    folder: Path | None
    group: str

    def gripper(self, node: Node) -> Gripper | None:
        """Return the gripper of a stage's end effector; None if it names none."""
        named = node["end_effector"].text(default="")
        return gripper_of(self.scene, end_effector=named) if named else None


def _stage(node: Node, cell: _Cell) -> TaskStage:
    kinds = [key for key in node.keys() if key in _READERS]
    if len(kinds) != 1:
        keys = ", ".join(node.keys())
        raise node.error(f"needs one of the keys {', '.join(_READERS)}; has {keys}")
    others, read = _READERS[kinds[0]]
    node.only((kinds[0], "name", *others))
    try:
        return read(node, node[kinds[0]], cell, node["name"].text(default=""))
    except TrajoptError as error:
        if node.path in str(error):
            raise
        raise node.error(str(error)) from error


def _configuration(node: Node) -> str | Mapping[str, float]:
    if isinstance(node.value, str):
        return node.text()
    return {name: value.number() for name, value in node.members().items()}


def _pose(node: Node) -> Placement:
    return pose_of(node, UPRIGHT, degrees=False)


def _move_to(node: Node, goal: Node, cell: _Cell, name: str) -> TaskStage:
    del cell
    group = node["group"].text(default="")
    pose = not isinstance(goal.value, str) and goal.has("position")
    return MoveTo(_pose(goal) if pose else _configuration(goal), name=name, group=group)


def _gripper(node: Node, opening: Node, cell: _Cell, name: str) -> TaskStage:
    return SetGripper(opening.number(), cell.gripper(node), name=name)


def _pick(node: Node, picked: Node, cell: _Cell, name: str) -> TaskStage:
    gripper = cell.gripper(node)
    grasps = grasps_of(cell.scene, picked.text(), gripper or gripper_of(cell.scene, group=cell.group))
    return PickObject(picked.text(), grasps, gripper, name=name)


def _place(node: Node, placed: Node, cell: _Cell, name: str) -> TaskStage:
    return PlaceObject(placed.text(), Place(placement=_pose(node["at"])), cell.gripper(node), name=name)


def _follow(node: Node, frame: Node, cell: _Cell, name: str) -> TaskStage:
    if node.has("file"):
        if cell.folder is None:
            raise node["file"].error("is for tasks in files: state the poses as `poses`")
        poses = read_poses(cell.folder / node["file"].text())
    else:
        poses = tuple(_pose(item) for item in node["poses"].elements())
    curve = polyline(poses, blend=node["blend"].number(default=0.0))
    speeds = ()
    if node.has("steady") and not node.has("speed"):
        raise node["steady"].error("needs a speed beside it")
    if node.has("speed"):
        steady = node["steady"].number(default=np.inf, infinite=True)
        speeds = (tool_speed(frame.text(), linear=node["speed"].number(), steady=steady),)
    options = FollowOptions(begin=Begin.ANY_BRANCH, tool_speed=speeds)
    off = node["off"].number(default=0.0)
    return FollowCurve(follows_curve(frame.text(), curve), options=options, off=off, name=name)


def _items(listed: Node, cell: _Cell) -> list[list[TaskStage]]:
    return [
        [_stage(stage, cell) for stage in (item.elements() if isinstance(item.value, list) else [item])]
        for item in listed.elements()
    ]


def _any_order(node: Node, listed: Node, cell: _Cell, name: str) -> TaskStage:
    then = _configuration(node["then"]) if node.has("then") else None
    return AnyOrder(_items(listed, cell), name=name, then=then)


def _attach(node: Node, attached: Node, _: _Cell, name: str) -> TaskStage:
    touch = tuple(link.text() for link in node["touch_links"].elements()) if node.has("touch_links") else ()
    within = {"within": node["within"].number(infinite=True)} if node.has("within") else {}
    return AttachObject(attached.text(), node["link"].text(), touch_links=touch, name=name, **within)


def _move_object(node: Node, moved: Node, _: _Cell, name: str) -> TaskStage:
    seconds = node["seconds"].number(default=0.0)
    return MoveObject(moved.text(), _pose(node["to"]), seconds=seconds, name=name)


def _one_of(node: Node, listed: Node, cell: _Cell, name: str) -> TaskStage:
    weights = node["cost"].only(("duration", "joint_travel", "clearance")).members()
    cost = StageCost(**{key: each.number() for key, each in weights.items()}) if weights else duration
    ways = node["ways_each"].number(default=1.0)
    if not ways.is_integer():
        raise node["ways_each"].error(f"must be a whole number, is {ways:g}")
    return OneOf(_items(listed, cell), cost=cost, name=name, ways_each=int(ways))


def _within(node: Node, listed: Node, cell: _Cell, name: str) -> TaskStage:
    limits = node["limits"].only(("duration", "joint_travel", "clearance", "joints"))
    joints = {joint: _range(each) for joint, each in limits["joints"].members().items()}
    bounds = {key: each.number() for key, each in limits.members().items() if key != "joints"}
    return Within(_items(listed, cell), StageLimits(**bounds, joints=joints), name=name)


def _range(node: Node) -> tuple[float, float]:
    numbers = node.numbers()
    if len(numbers) != 2:
        raise node.error("must be the lowest and the highest position")
    return numbers[0], numbers[1]


Read = Callable[[Node, Node, _Cell, str], TaskStage]
_READERS: Mapping[str, tuple[tuple[str, ...], Read]] = {
    "move_to": (("group",), _move_to),
    "dwell": ((), lambda _, value, __, name: Dwell(value.number(), name=name)),
    "gripper": (("end_effector",), _gripper),
    "pick": (("end_effector",), _pick),
    "place": (("at", "end_effector"), _place),
    "attach": (("link", "touch_links", "within"), _attach),
    "detach": ((), lambda _, value, __, name: DetachObject(value.text(), name=name)),
    "move_object": (("to", "seconds"), _move_object),
    "follow": (("poses", "file", "speed", "steady", "blend", "off"), _follow),
    "any_order": (("then",), _any_order),
    "for_each": ((), lambda _, value, cell, name: ForEach(_items(value, cell), name=name)),
    "one_of": (("cost", "ways_each"), _one_of),
    "together": ((), lambda _, value, cell, name: Together(_items(value, cell), name=name)),
    "within": (("limits",), _within),
    "fallback": ((), lambda _, value, cell, name: Fallback(_items(value, cell), name=name)),
}
"""Key of each kind of stage -> its other keys, and the function that reads it."""
