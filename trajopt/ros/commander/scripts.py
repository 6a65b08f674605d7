"""Unchanged scripts: while one runs, the names of ROS and MoveIt refer to the stand-ins."""

import builtins
import io
import logging
import re
import runpy
import sys
import traceback
from collections.abc import Callable, Generator, Sequence
from contextlib import contextmanager
from difflib import get_close_matches
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any, TextIO

from trajopt.files.messages import PACKAGES as MESSAGE_PACKAGES
from trajopt.ros.commander.move_group import MoveGroupCommander
from trajopt.ros.commander.planning_scene_interface import PlanningSceneInterface
from trajopt.ros.commander.robot import RobotCommander
from trajopt.ros.commander.world import World
from trajopt.server.move_group.outcome import MoveItCommanderException, NoStandIn
from trajopt.values.errors import FileFormatError, TrajoptError, shown

_LOG = logging.getLogger("trajopt.ros.commander")
HERE = "trajopt.ros.commander"
PACKAGES = {
    "moveit_commander": ("conversions", "move_group", "planning_scene_interface", "robot"),
    "rospy": (),
    "rclpy": (),
    "moveit": (
        "planning",
        "core",
        "core.kinematic_constraints",
        "core.planning_scene",
        "core.robot_model",
        "core.robot_state",
        "core.robot_trajectory",
        "task_constructor",
        "task_constructor.core",
        "task_constructor.stages",
    ),
    "tf": ("transformations",),
    **dict.fromkeys(MESSAGE_PACKAGES, ("msg",)),
}
"""Packages of ROS and MoveIt that have stand-ins, and their modules."""
ELSEWHERE = {
    "moveit_commander.exception": "trajopt.server.move_group.outcome",
    **dict.fromkeys(("rclpy.logging", "rclcpp", "py_binding_tools", "moveit.python_tools"), f"{HERE}.rclpy"),
}
"""Further modules of ROS and MoveIt, and the modules with their names."""
REASONS = {
    **dict.fromkeys(
        ("rospy.Subscriber", "rospy.wait_for_message"),
        "no messages arrive in a simulated world; query the commanders",
    ),
    **dict.fromkeys(
        ("rospy.Service", "rospy.ServiceProxy", "rospy.wait_for_service"),
        "there are no services in a simulated world; the commanders' methods do what MoveIt's services do",
    ),
    **dict.fromkeys(
        ("rclpy.create_node", "rclpy.node"),
        "there are no nodes in a simulated world; MoveItPy's methods do what MoveIt's services do",
    ),
    "moveit.task_constructor.stages.FixCollisionObjects": "move the object by PlanningSceneInterface",
    **dict.fromkeys(
        (
            f"moveit.task_constructor.core.{name}"
            for name in ("Generator", "MonitoringGenerator", "PropagatingEitherWay", "PropagatingForward")
        ),
        "a stage of one's own is a class with the members of trajopt.tasks.TaskStage",
    ),
    "rospy.Timer": "scripts run in one thread here; call the function in a loop with rospy.Rate",
    **dict.fromkeys(
        ("tf.TransformListener", "tf.TransformBroadcaster"),
        "frames are not broadcast here; RobotCommander.get_link(name).pose() returns the pose of a link",
    ),
}
"""Reasons why a name has no stand-in, and its replacement."""


class Answering(io.TextIOBase):
    """Answers every `input()` from a source, and then with Enter.

    Reading in other ways (`for line in sys.stdin`, `sys.stdin.read()`) ends with the source.
    """

    def __init__(self, source: TextIO | None = None) -> None:
        self._source = source

    def readable(self) -> bool:
        """Return True."""
        return True

    def readline(self, size: int | None = -1, /) -> str:  # type: ignore[override]
        """Return the next line, or an empty one."""
        line = self._line()
        if not line:
            sys.stdout.write("\n")  # As a terminal would show Enter, so that what follows has its own line.
        return line or "\n"

    def read(self, size: int | None = -1, /) -> str:
        return "" if self._source is None else self._source.read(-1 if size is None else size)

    def __next__(self) -> str:  # type: ignore[override]
        line = self._line()
        if not line:
            raise StopIteration
        return line

    def _line(self) -> str:
        return "" if self._source is None else self._source.readline()


def _or_warn(change: Callable[[], None], consequence: str) -> None:
    try:
        change()
    except MoveItCommanderException as error:
        _LOG.warning("%s; %s", error, consequence)


class UnchangedMoveGroup(MoveGroupCommander):
    """A group whose script may name OMPL's planners: they are not here, and trajopt's plans."""

    def set_planner_id(self, planner_id: str) -> None:
        choose = super().set_planner_id
        _or_warn(lambda: choose(planner_id), "trajopt's own plans")

    def set_planning_pipeline_id(self, planning_pipeline: str) -> None:
        choose = super().set_planning_pipeline_id
        _or_warn(lambda: choose(planning_pipeline), "trajopt's own plans")

    def execute(self, trajectory: Any, wait: bool = True) -> bool:
        return super().execute(trajectory[1] if isinstance(trajectory, tuple) else trajectory, wait)


class UnchangedRobot(RobotCommander):
    """A robot whose groups are `UnchangedMoveGroup`."""

    group_kind = UnchangedMoveGroup


class UnchangedScene(PlanningSceneInterface):
    """A scene whose script may remove missing objects, as many scripts do first."""

    def remove_world_object(self, name: str | None = None) -> None:
        remove = super().remove_world_object
        _or_warn(lambda: remove(name), "nothing is removed")

    def remove_attached_object(self, link: str | None = None, name: str | None = None) -> None:
        remove = super().remove_attached_object
        _or_warn(lambda: remove(link, name), "nothing is detached")


UNCHANGED = {
    "MoveGroupCommander": UnchangedMoveGroup,
    "PlanningSceneInterface": UnchangedScene,
    "RobotCommander": UnchangedRobot,
}
"""Classes that unchanged scripts import under MoveIt's names."""


class StandIn(ModuleType):
    """A module under its ROS name, with the contents of its stand-in."""

    def __init__(self, name: str, source: ModuleType) -> None:
        super().__init__(name, source.__doc__)
        self.__path__ = []
        for key, value in vars(source).items():
            home = HERE if isinstance(value, ModuleType) else "trajopt"
            foreign = not getattr(value, "__module__", getattr(value, "__name__", home)).startswith(home)
            if not key.startswith("_") and not foreign:
                setattr(self, key, value)

    def __getattr__(self, name: str) -> object:
        if name.startswith("__"):
            raise AttributeError(name)
        raise NoStandIn(missing(self, name))


def missing(module: ModuleType, name: str) -> str:
    whole = f"{module.__name__}.{name}"
    if whole in REASONS:
        return f"{whole} has no stand-in: {REASONS[whole]}"
    there = sorted(key for key in vars(module) if not key.startswith("_"))
    near = get_close_matches(name, there, n=1)
    hint = f"did you mean {shown(near[0])}?" if near else f"there are: {', '.join(there)}"
    return f"{whole} has no stand-in; {hint}"


def stand_ins() -> dict[str, ModuleType]:
    """Return the stand-in modules by their import names."""
    sources: dict[str, str] = {}
    for package, modules in PACKAGES.items():
        sources[package] = HERE if package == "moveit_commander" else f"{HERE}.{package}"
        sources.update({f"{package}.{module}": f"{sources[package]}.{module}" for module in modules})
    found: dict[str, ModuleType] = {}
    for name, source in {**sources, **ELSEWHERE}.items():
        found[name] = StandIn(name, import_module(source))
        parent, _, last = name.rpartition(".")
        if parent:
            setattr(found[parent], last, found[name])
    if find_spec("six") is None:  # Old scripts import it; the real one is as good where it is installed.
        found |= _six()
    for module in (found[name] for name in found if name.startswith("moveit_commander")):
        for key, kind in UNCHANGED.items():
            if key in vars(module):
                setattr(module, key, kind)
    # Many scripts end with moveit_commander.os._exit(0), which must not end the process that runs them.
    found["moveit_commander"].__dict__["os"] = SimpleNamespace(_exit=sys.exit)
    return found


def _six() -> dict[str, ModuleType]:
    six, moves = ModuleType("six"), ModuleType("six.moves")
    vars(six).update(
        PY2=False, PY3=True, string_types=(str,), integer_types=(int,), text_type=str, moves=moves
    )
    vars(moves).update({name: vars(builtins)[name] for name in ("input", "range", "zip", "map", "filter")})
    return {"six": six, "six.moves": moves}


@contextmanager
def _stood_in(folder: Path) -> Generator[None]:
    ours = stand_ins()
    before, path = dict(sys.modules), list(sys.path)
    sys.modules.update(ours)
    sys.path.insert(0, str(folder))
    try:
        yield
    finally:
        sys.path[:] = path
        for name, module in list(sys.modules.items()):
            file = getattr(module, "__file__", None)
            its_own = name not in before and file is not None and Path(file).is_relative_to(folder)
            if name in ours or its_own:
                del sys.modules[name]
        sys.modules.update({name: before[name] for name in ours if name in before})


@contextmanager
def _called(words: Sequence[str], stdin: TextIO | None) -> Generator[None]:
    before = sys.argv, sys.stdin
    sys.argv, sys.stdin = list(words), stdin or sys.stdin
    try:
        yield
    finally:
        sys.argv, sys.stdin = before


def run_script(
    path: Path, arguments: Sequence[str] = (), *, world: World, stdin: TextIO | None = None
) -> None:
    """Run an unchanged script that imports `moveit_commander`, `rospy` and ROS messages.

    Args:
        arguments: Without its name.
        stdin: Its standard input; the one of this process when None.
    """
    if not path.is_file():
        raise FileFormatError(str(path), "is not a file")
    whole = path.resolve()
    with _stood_in(whole.parent), _called([str(path), *arguments], stdin), world:
        try:
            runpy.run_path(str(whole), run_name="__main__")
        except TrajoptError as error:
            raise MoveItCommanderException(f"{_line(error, whole)}: {error}") from error
        except ImportError as error:
            raise MoveItCommanderException(f"{_line(error, whole)}: {_not_imported(error)}") from error


def _line(error: BaseException, path: Path) -> str:
    frames = traceback.extract_tb(error.__traceback__)
    numbers = [frame.lineno for frame in frames if frame.filename == str(path)]
    return f"{path.name}, line {numbers[-1]}" if numbers else path.name


def _not_imported(error: ImportError) -> str:
    module = sys.modules.get(error.name or "")
    name = re.match("cannot import name '(.+)' from", str(error))  # `name_from` since Python 3.12 only.
    if isinstance(module, StandIn) and name is not None:
        return missing(module, name[1])
    told = str(error).removesuffix(" (unknown location)")
    return f"{told}; stand-ins exist for {', '.join(PACKAGES)}"
