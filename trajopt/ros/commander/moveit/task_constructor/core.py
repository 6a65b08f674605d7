"""Stand-in for `moveit.task_constructor.core`."""

import logging
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from difflib import get_close_matches
from enum import Flag
from math import inf
from typing import Any, ClassVar

import numpy as np

from trajopt.files.messages import MoveItErrorCodes
from trajopt.planning.plan import plan
from trajopt.ros.commander.conversions import framed_placement
from trajopt.ros.commander.move_group import executed
from trajopt.ros.commander.moveit.core.robot_model import InPart, RobotModel
from trajopt.ros.commander.world import World, group_named, world_or_current
from trajopt.scene.group_tools import end_link
from trajopt.scene.scene import Scene
from trajopt.server.move_group.outcome import MoveItCommanderException, NoStandIn, speaks_moveit
from trajopt.tasks import stages as ours
from trajopt.tasks.grasping.grasp import GraspingOptions
from trajopt.tasks.grasping.gripper import Gripper
from trajopt.tasks.result import TaskResult
from trajopt.tasks.search import TaskStage
from trajopt.tasks.task import Task as Job
from trajopt.values.arrays import Floats
from trajopt.values.errors import shown
from trajopt.values.placement import IDENTITY

_LOG = logging.getLogger("trajopt.ros.commander")


class Property:
    """A value with a default and a description."""

    def __init__(self) -> None:
        self._value: Any = None
        self._default: Any = None
        self._description = ""

    def setValue(self, value: Any) -> None:
        self._value = self._default = value

    def setCurrentValue(self, value: Any) -> None:
        self._value = value

    def value(self) -> Any:
        return self._default if self._value is None else self._value

    def defaultValue(self) -> Any:
        return self._default

    def defined(self) -> bool:
        return self._value is not None

    def reset(self) -> None:
        self._value = self._default

    def description(self) -> str:
        return self._description

    def setDescription(self, desc: str) -> None:
        self._description = desc


class PropertyMap(dict[str, Any]):
    """Values of properties by name."""

    def __missing__(self, name: str) -> Any:
        raise MoveItCommanderException(unknown("a property", name, self))

    def property(self, name: str) -> Property:
        made = Property()
        made.setValue(self[name])
        return made

    def exposeTo(self, other: "PropertyMap", name: str | Iterable[str], other_name: str = "") -> None:
        for each in (name,) if isinstance(name, str) else name:
            other[other_name or each] = self[each]

    def configureInitFrom(self, sources: Any, names: Iterable[str] = ()) -> None:
        """Do nothing."""


def unknown(kind: str, name: str, known: Iterable[str]) -> str:
    near = get_close_matches(name, list(known), n=1)
    hint = f" (did you mean {shown(near[0])}?)" if near else ""
    return f"{shown(name)} is not {kind}{hint}; there are: {', '.join(known) or 'none'}"


class _WithProperties:
    declared: ClassVar[Mapping[str, Any]] = {}

    def __init__(self) -> None:
        self.properties = PropertyMap()
        for kind in reversed(type(self).__mro__):
            self.properties.update(vars(kind).get("declared", {}))

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_") or name == "properties":
            raise AttributeError(name)
        if name not in self.properties:
            methods = (each for each in dir(type(self)) if not each.startswith("_"))
            known = (*self.properties, *methods)
            raise NoStandIn(unknown(f"a member of {type(self).__name__} here", name, known))
        return self.properties[name]

    def __setattr__(self, name: str, value: Any) -> None:
        if name.startswith("_") or name in ("properties", "name"):
            object.__setattr__(self, name, value)
        elif name in self.properties:
            self.properties[name] = value
        else:
            raise NoStandIn(unknown(f"a property of {type(self).__name__} here", name, self.properties))


class PlannerInterface(_WithProperties):
    """A planner."""

    declared: ClassVar[Mapping[str, Any]] = dict.fromkeys(
        ("max_velocity_scaling_factor", "max_acceleration_scaling_factor"), 1.0
    )

    def speeds(self) -> tuple[float, float]:
        return self.max_velocity_scaling_factor, self.max_acceleration_scaling_factor


class PipelinePlanner(PlannerInterface):
    """Trajopt's planner, under any name."""

    declared: ClassVar[Mapping[str, Any]] = {"planner": "", "num_planning_attempts": 1}

    def __init__(self, *names: Any, **_: Any) -> None:
        super().__init__()


class JointInterpolationPlanner(PlannerInterface):
    """Trajopt's planner."""

    declared: ClassVar[Mapping[str, Any]] = {"max_step": 0.1}


class CartesianPath(PlannerInterface):
    """A straight line of a link."""

    declared: ClassVar[Mapping[str, Any]] = {"step_size": 0.01, "jump_threshold": 0.0, "min_fraction": 1.0}


class MultiPlanner(PlannerInterface):
    """Several planners, of which the first plans."""

    def __init__(self) -> None:
        super().__init__()
        self._planners: list[PlannerInterface] = []

    def add(self, *planners: PlannerInterface) -> None:
        self._planners += planners

    def speeds(self) -> tuple[float, float]:
        return self._planners[0].speeds() if self._planners else super().speeds()


@dataclass(eq=False)
class StageContext:
    """The data shared by the stages of a task.

    Attributes:
        positions: Of all joints before the task [rad | m].
        speeds: Smallest factors on velocity and acceleration.
        merged: Groups that move together.
        on_the_way: Path constraints of the last Connect.
    """

    scene: Scene
    positions: Floats
    speeds: tuple[float, float] = (1.0, 1.0)
    groups: list[str] = field(default_factory=list[str])
    merged: list[str] = field(default_factory=list[str])
    grippers: dict[str, Gripper] = field(default_factory=dict[str, Gripper])
    on_the_way: Any = None

    def moves(self, group: str, planner: PlannerInterface | None = None) -> str:
        """Add a group that moves; return its full name."""
        name = group_named(self.scene.robot, group).name
        self.groups.append(name)
        velocity, acceleration = (1.0, 1.0) if planner is None else planner.speeds()
        self.speeds = min(self.speeds[0], velocity), min(self.speeds[1], acceleration)
        return name

    def tool(self, frame: Any, group: str = "") -> str:
        """Return the name of a frame; a PoseStamped becomes a tool of the scene."""
        if frame is None or isinstance(frame, str):
            return frame or end_link(self.scene.robot, group)
        where, link = framed_placement(frame, "")
        if np.allclose(where.homogeneous, IDENTITY.homogeneous):
            return link
        for name, tool in self.scene.tools.items():
            if tool.frame == link and np.allclose(tool.placement.homogeneous, where.homogeneous):
                return name
        name = f"ik_frame {len(self.scene.tools) + 1} on {link}"
        self.scene = self.scene.with_tool(name, on=link, placement=where)
        return name

    def taken_on_the_way(self) -> Any:
        taken, self.on_the_way = self.on_the_way, None
        return taken

    @property
    def group(self) -> str:
        """The smallest group with the joints of the largest one and of all that move together."""
        groups = self.scene.robot.groups
        sizes = {name: len(groups[name].joints) for name in (*self.groups, *groups)}
        largest = max(self.groups, key=sizes.__getitem__, default=next(iter(groups)))
        joints = {joint for name in (largest, *self.merged) for joint in groups[name].joints}
        whole = [name for name in sizes if joints <= set(groups[name].joints)]
        if not whole:
            names = ", ".join(map(shown, self.merged))
            raise NoStandIn(f"Merger: no group of the robot has the joints of all of {names}")
        return min(whole, key=sizes.__getitem__)


class StandInStage(_WithProperties):
    """A stage of a task."""

    declared: ClassVar[Mapping[str, Any]] = {"timeout": inf, "marker_ns": "", "forwarded_properties": ()}

    class PropertyInitializerSource(Flag):
        """Has no effect."""

        PARENT = 1
        INTERFACE = 2

    def __init__(self, name: str) -> None:
        super().__init__()
        self.name = name
        self._given: Any = None

    def _translated(self, context: StageContext) -> list[TaskStage]:
        raise self._refusal("is not planned alone: put it into Pick or Place")

    def _merged(self, context: StageContext) -> ours.MoveTo:
        raise self._refusal("cannot be in a Merger: use MoveTo with joint positions")

    def _required(self) -> Any:
        if self._given is None:
            setter = next(name for name in dir(self) if name.startswith("set"))
            raise self._refusal(f"is incomplete: call {setter}")
        return self._given

    def _refusal(self, words: str) -> NoStandIn:
        return NoStandIn(f"stage {shown(self.name)}: {type(self).__name__} {words}")


Stage = StandInStage
"""Its name in the Task Constructor."""


class SerialContainer(StandInStage):
    """Stages in order."""

    def __init__(self, name: str = "") -> None:
        super().__init__(name or type(self).__name__)
        self._children: list[StandInStage] = []

    def add(self, *stages: StandInStage) -> None:
        self._children += stages

    def insert(self, stage: StandInStage, before: int = -1) -> None:
        self._children.insert(len(self._children) if before == -1 else before, stage)

    def clear(self) -> None:
        self._children = []

    def __len__(self) -> int:
        return len(self._children)

    def __iter__(self) -> Iterator[StandInStage]:
        return iter(self._children)

    def __getitem__(self, which: str | int) -> StandInStage:
        if isinstance(which, int):
            return self._children[which]
        named = {stage.name: stage for stage in self}
        if which not in named:
            raise MoveItCommanderException(unknown(f"a stage of {shown(self.name)}", which, named))
        return named[which]

    def _translated(self, context: StageContext) -> list[TaskStage]:
        return [each for stage in self for each in stage._translated(context)]


class Alternatives(SerialContainer):
    """The stage of least duration."""

    def _translated(self, context: StageContext) -> list[TaskStage]:
        return [ours.OneOf([stage._translated(context) for stage in self], name=self.name)]


class Fallbacks(SerialContainer):
    """The first stage that can be planned."""

    def _translated(self, context: StageContext) -> list[TaskStage]:
        return [ours.Fallback([stage._translated(context) for stage in self], name=self.name)]


class Merger(SerialContainer):
    """Moves of several groups at the same time."""

    def _translated(self, context: StageContext) -> list[TaskStage]:
        moves = [stage._merged(context) for stage in self]
        context.merged += [move.group for move in moves]
        return [ours.Together([[move] for move in moves], name=self.name)]


@dataclass(frozen=True, eq=False)
class Solution(InPart):
    """A plan of a task, or the reason of a rejected way; its cost is the duration [s]."""

    result: TaskResult
    cost: float
    comment: str


@speaks_moveit
class Task(SerialContainer):
    """A task of stages."""

    def __init__(self, ns: str = "", introspection: bool = True, *, world: World | None = None) -> None:
        super().__init__(ns or "task")
        self._world = world_or_current(world)
        self._planned_in: Scene | None = None
        self.reset()

    @property
    def solutions(self) -> list[Solution]:
        """The plan, if any."""
        return self._solutions

    @property
    def failures(self) -> list[Solution]:
        """The rejected ways."""
        return self._failures

    def loadRobotModel(self, *_: Any, **__: Any) -> None:
        """Do nothing."""

    def getRobotModel(self) -> RobotModel:
        """Return the robot of the world."""
        return RobotModel.of(self._world.robot, self._world.rng)

    def enableIntrospection(self, enabled: bool = True) -> None:
        """Do nothing."""

    def reset(self) -> None:
        self._solutions: list[Solution] = []
        self._failures: list[Solution] = []

    def init(self) -> None:
        """Check all stages."""
        self._job()

    def plan(self, max_solutions: int = 0) -> bool:
        """Plan the task and verify it; return whether there is a plan."""
        self._planned_in, result = self._world.scene, plan(self._job())
        _LOG.info("task: %s", result.reason)
        self._failures = [Solution(result, inf, cause) for cause in result.causes]
        self._solutions = [Solution(result, result.duration, result.reason)] if result.verified else []
        return result.verified

    def publish(self, solution: Solution) -> None:
        """Log the times of all stages."""
        _LOG.info("%s: %s", self.name, solution.result.explain())

    def execute(self, solution: Solution) -> MoveItErrorCodes:
        """Execute a solution; the world gets its final scene."""
        world, result = self._world, solution.result
        if world.scene is not self._planned_in:
            changed = MoveItErrorCodes.MOTION_PLAN_INVALIDATED_BY_ENVIRONMENT_CHANGE
            return MoveItErrorCodes(changed, "the scene was changed after plan()", "execution")
        tools = world.scene.tools
        if not executed(result.require(), world, end_link(world.robot, result.group)):
            assert world.outcome is not None
            return world.outcome.error_code
        world.edit(lambda _: replace(result.final_scene, tools=tools))
        return MoveItErrorCodes(MoveItErrorCodes.SUCCESS, result.reason, "execution")

    def _job(self) -> Job:
        context = StageContext(self._world.scene, self._world.positions)
        stages = self._translated(context)
        velocity, acceleration = context.speeds
        return Job(
            scene=context.scene,
            start=context.positions,
            stages=stages,
            group=context.group,
            options=GraspingOptions(velocity_scaling=velocity, acceleration_scaling=acceleration),
            name=self.name,
        )
