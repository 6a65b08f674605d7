"""Result of a task."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from trajopt.planning.result import Result
from trajopt.planning.status import Status
from trajopt.scene.scene import Scene
from trajopt.simulation import SimulationOptions
from trajopt.tasks.grasping.grasp import Grasp, Place
from trajopt.tasks.grasping.gripper import Gripper
from trajopt.tasks.grasping.result import PickPlaceResult, Segment, Stage
from trajopt.tasks.sequence import MotionSequence, PlannedSegment, StageTime
from trajopt.timing.time_scaling import JOLT
from trajopt.values.arrays import Value
from trajopt.values.errors import NameNotFound
from trajopt.values.errors.arguments import checked
from trajopt.values.placement import WORLD

if TYPE_CHECKING:
    from trajopt.tasks.grasping.simulation import TaskRollout

SETTLING = 2.0 * JOLT
"""Rest between two motions in which accelerations at their ends decay and build up [s]."""


@dataclass(frozen=True)
class StageRest:
    """A rest at the end of a motion.

    Attributes:
        stage: Stage that it is counted to; empty for the stage that ends with the motion.
        seconds: Duration [s].
    """

    stage: str
    seconds: float


@dataclass(frozen=True, eq=False)
class TaskSegment(PlannedSegment, Value):
    """One motion of a task from rest to rest, through the ends of its stages.

    Attributes:
        stages: Names of the stages that it moves through, in order; the last one ends with it.
        pauses: Rests at its end before the next motion.
        after: Stage of a group among others -> the stage with whose end it begins, empty for the begin of
            the motion; other stages begin when the one before ends.
    """

    stages: tuple[str, ...]
    result: Result
    pauses: tuple[StageRest, ...] = ()
    after: Mapping[str, str] = field(default_factory=dict[str, str])

    @property
    def title(self) -> str:
        return ", ".join(self.stages)

    def holds(self, name: str) -> bool:
        """Return whether an object is attached to the robot."""
        return self.scene.holder(name).link != WORLD

    @property
    def rest(self) -> float:
        return sum(pause.seconds for pause in self.pauses)

    def settled(self) -> "TaskSegment":
        """Return the motion with a rest of at least `SETTLING`, if the robot has joints without a jerk limit.

        These end braking, and begin the next motion accelerating.
        """
        missing = SETTLING - self.rest
        if missing <= 0.0 or np.isfinite(self.result.problem.scene.robot.limits.jerk).all():
            return self
        return replace(self, pauses=(StageRest("", missing), *self.pauses))

    @property
    def ends(self) -> tuple[tuple[str, float], ...]:
        """Stages and pauses with their end times since the beginning of the motion [s]."""
        passing = self.result.require().certificate.passing_time
        on_the_way = [passing(stage) or 0.0 for stage in self.stages[:-1]]
        ends = dict(zip(self.stages, (*on_the_way, self.trajectory.duration), strict=True))
        for pause in self.pauses:
            stage = pause.stage or self.stages[-1]
            ends[stage] = max(ends.values()) + pause.seconds
        return tuple(ends.items())


@dataclass(frozen=True, eq=False)
class Handling(Value):
    """How an object was picked and placed.

    Attributes:
        picked: Name of the stage that picks it; empty if it was in the hand.
        placed: Name of the stage that places it; empty if it stays in the hand.
    """

    scene: Scene
    gripper: Gripper
    picked: str = ""
    grasp: Grasp | None = None
    place: Place | None = None
    placed: str = ""

    def stage(self, segment: TaskSegment) -> Stage | None:
        found = [step_of(name) for name in segment.stages if _stage_of(name) in {self.picked, self.placed}]
        return found[-1] if found else None


def step_of(name: str) -> Stage:
    return Stage[name.rpartition(": ")[2].upper()]


def _stage_of(name: str) -> str:
    return name.rpartition(": ")[0] or " "


@dataclass(frozen=True, eq=False, kw_only=True)
class TaskResult(MotionSequence[TaskSegment]):
    """A planned task, or why there is no plan.

    Attributes:
        handled: Picked object -> how it was handled each time, in order.
    """

    segments: tuple[TaskSegment, ...]
    handled: Mapping[str, tuple[Handling, ...]] = field(default_factory=dict[str, tuple[Handling, ...]])

    @property
    def stages(self) -> tuple[StageTime, ...]:
        """Begin and end of each stage, in order."""
        found: dict[str, StageTime] = {}
        for begin, segment in zip(self.begins.tolist(), self.segments, strict=True):
            since = begin
            for name, end in segment.ends:
                other = segment.after.get(name)
                known = found.get(other or "")
                own = since if other is None else begin if known is None else known.end
                found[name] = StageTime(name, own, begin + end)
                since = begin + end
        return tuple(found.values())

    @property
    def missing(self) -> str:
        """The end of a pick or place, or the last stage, if no motion has it."""
        done = {name for segment in self.segments for name, _ in segment.ends}
        items = [item for each in self.handled.values() for item in each]
        due = [f"{item.picked}: lift" for item in items if item.picked]
        due += [f"{item.placed}: retreat" for item in items if item.placed]
        last = [name for node in self.outline for name in node.taken][-1:]
        if self.segments and not any(f"{name}: ".startswith(f"{end}: ") for end in last for name in done):
            due += last
        return next((name for name in due if name not in done), "")

    def handling(self, name: str) -> PickPlaceResult:
        """Return the part of the task in which an object is picked and placed last, for `simulate_handling`.

        Raises:
            PlanningFailed: Without a plan.
            NameNotFound: If no stage picks the object.
        """
        self.require()
        if name not in self.handled:
            raise NameNotFound("picked object", name, self.handled)
        return self.part(name, self.handled[name][-1])[1]

    def part(self, name: str, item: Handling) -> tuple[range, PickPlaceResult]:
        """Return the part of the task in which an object is handled once, and the indices of its motions."""
        segments = self.require()
        stages = [item.stage(segment) for segment in segments]
        own = [index for index, stage in enumerate(stages) if stage is not None]
        end = own[-1] + 1
        while not item.placed and end < len(segments) and segments[end].holds(name):
            end += 1
        part: list[Segment] = []
        for index in range(own[0], end):
            before = part[-1].stage if part else Stage.REACH
            # Motions of other stages: the object is in the hand if it was before them.
            other = Stage.CARRY if before.holds or before is Stage.CLOSE else before
            part.append(Segment(stages[index] or other, segments[index].result, segments[index].rest))
        return range(own[0], end), PickPlaceResult(
            name=name,
            scene=item.scene,
            final_scene=self.final_scene,
            start=part[0].positions(0.0),
            group=self.group,
            gripper=item.gripper,
            status=Status.SOLVED,
            grasp=item.grasp,
            place=item.place,
            segments=tuple(part),
            refusals=(),
            counts={},
            cpu_seconds={},
        )

    @checked
    def simulated(self, options: SimulationOptions | None = None) -> "TaskRollout":
        from trajopt.tasks.grasping.simulation import simulate_task

        return simulate_task(self, options=options)
