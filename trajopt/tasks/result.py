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
from trajopt.values.errors import NameNotFound, shown
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

    @property
    def duration(self) -> float:
        return self.trajectory.duration + self.rest

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


@dataclass(frozen=True)
class CandidateNames:
    """Names of the grasp and the place that a motion belongs to; empty for none."""

    grasp: str = ""
    place: str = ""


NO_NAMES = CandidateNames()


def step_of(name: str) -> Stage:
    return Stage[name.rpartition(": ")[2].upper()]


def _stage_of(name: str) -> str:
    return name.rpartition(": ")[0] or " "


@dataclass(frozen=True, eq=False)
class StageRefusal(Value):
    """The reason why one way to do a stage was rejected.

    Attributes:
        result: The planning result; None if no motion was planned.
        names: The rejected grasp and place.
    """

    stage: str
    status: Status
    reason: str
    result: Result | None = None
    names: CandidateNames = NO_NAMES

    def __str__(self) -> str:
        which = ", ".join(name for name in (self.names.grasp, self.names.place) if name)
        return ": ".join(part for part in (self.stage, which, self.reason) if part)


@dataclass(frozen=True, eq=False, kw_only=True)
class TaskResult(MotionSequence[TaskSegment]):
    """A planned task, or why there is no plan.

    Attributes:
        final_scene: The scene after, with the clock at the end of the task; the scene before without a plan.
        start: Positions of all joints before, shape (number of joints,) [rad | m].
        status: Without a plan, of the stage that failed last in the task.
        segments: The motions, in order; empty without a plan.
        refusals: The rejected ways to do stages, with reasons, in the order of the search.
        cpu_seconds: Process time of each stage of planning [s].
        handled: Picked object -> how it was handled each time, in order.
        stopped: The cause of an early end of planning; None without one.
    """

    segments: tuple[TaskSegment, ...]
    refusals: tuple[StageRefusal, ...]
    handled: Mapping[str, tuple[Handling, ...]] = field(default_factory=dict[str, tuple[Handling, ...]])

    @property
    def duration(self) -> float:
        return sum(segment.duration for segment in self.require())

    @property
    def stages(self) -> tuple[StageTime, ...]:
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
        """Execute the task as `simulate_task` does; `trajopt.simulate(result)` calls this."""
        from trajopt.tasks.grasping.simulation import simulate_task

        return simulate_task(self, options=options)

    @property
    def reason(self) -> str:
        """The outcome in a sentence."""
        if self.verified:
            return f"{shown(self.name)} takes {self.duration:.2f} s in {len(self.segments)} motions"
        if not self.refusals:
            return f"{self.status.name}: nothing was attempted"
        last = self.refusals[-1].stage
        return f"{self.status.name}: {next(item for item in self.refusals if item.stage == last)}"

    def _details(self) -> tuple[str, tuple[str, ...]]:
        details = tuple(map(str, self.stages)) if self.verified else self.causes
        return f"{len(self.refusals)} ways", details

    @property
    def causes(self) -> tuple[str, ...]:
        """The rejected ways with their reasons, in words; ways of a stage with the same status together."""
        found: dict[tuple[str, Status], list[StageRefusal]] = {}
        for item in self.refusals:
            found.setdefault((item.stage, item.status), []).append(item)
        return tuple(
            f"{items[0]}{f' ({len(items)} ways)' if len(items) > 1 else ''}" for items in found.values()
        )

    def as_dict(self) -> dict[str, object]:
        """Return plain JSON data: motions, cycle times, and rejected ways."""
        return {
            "task": self.name,
            "status": self.status.name,
            "verified": self.verified,
            "message": str(self.explain()),
            "stages": [
                {"name": item.name, "begin": item.begin, "end": item.end}
                for item in (self.stages if self.verified else ())
            ],
            "segments": [
                {"stages": list(item.stages), "rest": item.rest, **item.result.as_dict()}
                for item in self.segments
            ],
            "refusals": [
                {"stage": item.stage, "status": item.status.name, "reason": item.reason}
                for item in self.refusals
            ],
            "counts": dict(self.counts),
            "cpu_seconds": {**self.cpu_seconds, "total": sum(self.cpu_seconds.values())},
            "stopped": None if self.stopped is None else self.stopped.name,
        }
