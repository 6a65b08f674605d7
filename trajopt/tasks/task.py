"""Task: a whole job as a value, and its planning."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from itertools import accumulate, chain, count
from threading import Event
from typing import Any, cast

import numpy as np

from trajopt.planning.budget import Budget, BudgetTracker, Progress, Stop, Stopped
from trajopt.planning.plan import NO_BOUNDS
from trajopt.planning.search import ENDED
from trajopt.planning.status import Status
from trajopt.problem.problem import PathConstraint, Problem
from trajopt.problem.stated import only_group
from trajopt.robot.configuration import ConfigurationLike, stated_configuration
from trajopt.scene.scene import Scene
from trajopt.tasks.grasping.grasp import GraspingOptions
from trajopt.tasks.grasping.result import STAGES
from trajopt.tasks.grasping.straight import to_configuration
from trajopt.tasks.result import TaskResult
from trajopt.tasks.search import (
    Choices,
    Rest,
    StageWithItems,
    TaskSearch,
    TaskStage,
    TaskState,
    as_items,
    check_frames,
    flat,
    held_after,
    held_objects,
    in_sequence,
    is_step_of,
    later,
)
from trajopt.tasks.sequence import StageNode, StageRefusal
from trajopt.values.arrays import Floats, Value, name_of, not_negative, one_of, sequence, several, unless_none
from trajopt.values.errors import ProblemError, shown
from trajopt.values.errors.arguments import checked

STEPS = tuple(step.name.lower() for step in STAGES)
"""Steps of picking and placing."""
STARTS = (Status.START_IN_COLLISION, Status.START_OUT_OF_LIMITS, Status.START_CANNOT_BE_HELD)
"""Outcomes of a start that no motion leaves."""


@checked
@dataclass(frozen=True, eq=False, kw_only=True)
class Task(Value):
    """A job: stages in order, planned as motions that rest only if a stage needs it.

    Consecutive moves of the arm become one motion through their goals. The arm rests while fingers move, an
    object is attached, detached or moved, during a `Dwell`, and before and after a curve.

    Attributes:
        scene: Robot and environment before the task.
        start: Configuration before the task, in any form of the start of a problem.
        stages: Missing names are made from their kinds.
        group: Planning group of the arm; optional if the robot has one only.
        constraints: Path constraints of all motions of the arm.
        options: Speeds, tolerances and times of all stages.
        blend: Distance from the far end of a straight approach, lift, lowering or retreat within which the
            arm may leave the line, at most half of the line [m].
        stops: Whether the arm rests after each motion.
    """

    scene: Scene
    start: ConfigurationLike
    stages: Sequence[TaskStage]
    group: str = ""
    constraints: Sequence[PathConstraint] = ()
    options: GraspingOptions = field(default_factory=GraspingOptions)
    blend: float = 0.0
    stops: bool = False
    name: str = "task"
    _start: Floats = field(init=False, repr=False)

    def __post_init__(self) -> None:
        """Name the stages, and check each against the scene.

        Raises:
            ProblemError: If there is no stage, or one cannot be done: an unknown object, a place before its
                pick; or if its name begins with the name of another and ": ". The message names the stage.
        """
        robot = self.scene.robot
        name_of("name", self.name)
        group = self.group or only_group(robot)
        start = stated_configuration(robot, "start", self.start, group=group)
        stages = several("stages", self.stages, TaskStage)
        if not stages:
            raise ProblemError("a task needs at least one stage, such as MoveTo(goal)")
        names: set[str] = set()
        named = tuple(_named(stages, names))
        _check_steps(names)
        for attribute, value in (("group", group), ("stages", named), ("start", start), ("_start", start)):
            object.__setattr__(self, attribute, value)
        not_negative("blend", self.blend)
        object.__setattr__(self, "constraints", tuple(sequence("constraints", self.constraints)))
        check_frames(self.scene, self.constraints)
        held_after(named, self.scene, group, held_objects(self.scene))

    @property
    def start_positions(self) -> Floats:
        """Positions of all joints before the task, shape (number of joints,) [rad | m]."""
        return self._start

    def planned(
        self,
        *,
        improve: bool = False,
        rng: np.random.Generator | None = None,
        budget: Budget = NO_BOUNDS,
        cancel: Event | None = None,
        progress: Progress | None = None,
    ) -> TaskResult:
        """Plan the task; `trajopt.plan(task)` calls this.

        Raises:
            ProblemError: If the budget requests improvement.
        """
        if one_of("budget", budget, Budget).improve:
            raise ProblemError(
                "a task takes the first verified plan, so its budget cannot improve; "
                "use plan(task, improve=True), or Budget(improve=True) for a problem"
            )
        given, improves = unless_none("rng", rng, np.random.Generator), one_of("improve", improve, bool)
        tracker = BudgetTracker(budget, cancel, progress)
        search = TaskSearch(
            group=self.group,
            constraints=tuple(self.constraints),
            options=self.options,
            rng=given or np.random.default_rng(0),
            tracker=tracker,
            blend=self.blend,
            improve=improves,
            stops=self.stops,
        )
        refusals: list[StageRefusal] = []
        try:
            return self._result(search, self._searched(search, refusals), refusals, None)
        except Stopped as ended:
            return self._result(search, None, refusals, ended.stop)

    def _searched(self, search: TaskSearch, refusals: list[StageRefusal]) -> TaskState | None:
        begin = TaskState(self.scene, self._start, self._start)
        for way in in_sequence((*self.stages, Rest()), search, begin):
            if not isinstance(way, StageRefusal):
                return way
            if (cause := self._refused_start(search, way)) is not None:
                refusals[:] = [cause]
                return None
            refusals.append(way)
        return None

    def _refused_start(self, search: TaskSearch, refusal: StageRefusal) -> StageRefusal | None:
        """Return a refusal by the start of the task itself, from which no other way can begin either.

        The motion that was refused may have begun with other positions of the fingers.
        """
        if refusal.status not in STARTS or refusal.result is None:
            return None
        begun = refusal.result.problem.reduced.start
        if not np.array_equal(search.arm(self.scene, begun), search.arm(self.scene, self._start)):
            return None
        goal = to_configuration(self.scene, self.group, self._start)
        rest = Problem(scene=self.scene, group=self.group, start=self._start, goal=goal)
        result = search.plan(rest)
        if result.status is not refusal.status:
            return None
        words = result.reason.removeprefix(f"{result.status.name}: ")
        return replace(refusal, result=result, reason=words)

    def _result(
        self,
        search: TaskSearch,
        ended: TaskState | None,
        refusals: Sequence[StageRefusal],
        stopped: Stop | None,
    ) -> TaskResult:
        farthest = None if ended is not None else max(refusals, key=self._progress, default=None)
        status = Status.SOLVED if ended is not None or farthest is None else farthest.status
        return TaskResult(
            name=self.name,
            scene=self.scene,
            final_scene=self.scene if ended is None else later(ended.scene, ended.time),
            start=self._start,
            status=status if stopped is None else ENDED[stopped],
            segments=() if ended is None else ended.segments,
            handled={} if ended is None else ended.handled,
            group=self.group,
            refusals=tuple(refusals),
            failed="" if farthest is None else farthest.stage,
            counts=dict(search.tracker.counts),
            cpu_seconds=dict(search.tracker.seconds),
            stopped=stopped,
            outline=tuple(_node(stage, ended) for stage in self.stages),
        )

    def _progress(self, refusal: StageRefusal) -> tuple[int, int]:
        """Return the places of the refused stage in the task, and of the step in the stage."""
        for place, stage in enumerate(flat(self.stages)):
            if is_step_of(refusal.stage, stage):
                step = refusal.stage.removeprefix(f"{stage.name}: ")
                return place, STEPS.index(step) if step in STEPS else -1
        return -1, -1


def _node(stage: TaskStage, ended: TaskState | None, choice: str = "") -> StageNode:
    """Return a stage with its items, those in any order as the arm does them."""
    items = as_items(stage.items) if isinstance(stage, StageWithItems) else ()
    choices: Choices = [(place, "") for place in range(len(items))]
    if ended is not None:
        choices = ended.choices.get(stage.name, choices)
    below: list[StageNode] = []
    for place, words in choices:
        item = items[place]
        single = len(item) == 1
        nodes = [_node(each, ended, words if single else "") for each in item]
        name = ", ".join(each.name for each in item)
        below += nodes if single or not words else [StageNode(name, words, tuple(nodes))]
    return StageNode(stage.name, choice, tuple(below))


def _named(stages: Sequence[TaskStage], taken: set[str]) -> list[TaskStage]:
    found: list[TaskStage] = []
    for stage in stages:
        name = stage.name or stage.default_name
        numbered = (f"{name} ({number})" for number in count(2))
        unique = next(each for each in chain((name,), numbered) if each not in taken)
        taken.add(unique)
        changes: dict[str, Any] = {"name": unique}
        if isinstance(stage, StageWithItems):
            changes["items"] = [_named(item, taken) for item in as_items(stage.items)]
        found.append(cast("TaskStage", replace(cast("Any", stage), **changes)))
    return found


def _check_steps(names: set[str]) -> None:
    for name in sorted(names):
        for owner in accumulate(name.split(": ")[:-1], "{}: {}".format):
            if owner in names:
                raise ProblemError(
                    f"stage {shown(name)}: such names are those of the steps of stage {shown(owner)}; "
                    f"choose another that does not begin with {shown(owner + ': ')}"
                )
