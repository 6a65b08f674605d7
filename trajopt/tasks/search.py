"""Search for a plan of a task: stages in order, each in one of its ways, motions without needless rests."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Protocol, runtime_checkable

import numpy as np

from trajopt.geometry import WorkCounts, evaluator
from trajopt.optimise.kinematics.inverse import goal_candidates
from trajopt.optimise.terms.joint_positions import fixed_positions
from trajopt.planning.budget import BudgetTracker, Stopped
from trajopt.planning.infeasibility import reasons
from trajopt.planning.plan import plan
from trajopt.planning.result import Result
from trajopt.planning.status import Status
from trajopt.problem.problem import PathConstraint, Problem
from trajopt.problem.requirements import Requirement, during
from trajopt.scene.clearances import ContactAllowance
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.reducing import reduce_model
from trajopt.scene.scene import Scene
from trajopt.tasks.grasping.grasp import GraspingOptions
from trajopt.tasks.grasping.straight import to_configuration
from trajopt.tasks.grasping.task import ATTEMPTS, later
from trajopt.tasks.result import SETTLING, Handling, StageRefusal, StageRest, TaskSegment
from trajopt.tasks.tour import travel_time
from trajopt.values.arrays import Floats

DEAD_ENDS = 4
"""Number of times that all ways of a stage may fail before the search ends.

Each time an earlier stage was done in another way, which is rarely the remedy.
"""


@dataclass(frozen=True, eq=False)
class Leg:
    """A motion of the arm to a configuration that is not planned yet.

    Attributes:
        goal: Positions of all joints at its end [rad | m].
        scene: Scene of this leg, with its margins and allowed contacts.
    """

    stage: str
    goal: Floats
    scene: Scene
    constraints: tuple[PathConstraint, ...] = ()


@dataclass(frozen=True, eq=False)
class TaskState:
    """State of a task after some of its stages.

    Attributes:
        scene: The scene, with the clock of the beginning of the task.
        positions: Of all joints, at the end of the legs [rad | m].
        rested: Of all joints, at the end of the planned motions [rad | m].
        legs: Legs after them, which are planned together when something needs a rest.
        handled: How each object was picked and placed last.
        lifting: Contacts with supports that the next motion may begin with.
    """

    scene: Scene
    positions: Floats
    rested: Floats
    segments: tuple[TaskSegment, ...] = ()
    legs: tuple[Leg, ...] = ()
    handled: Mapping[str, Handling] = field(default_factory=dict[str, Handling])
    lifting: tuple[ContactAllowance, ...] = ()

    @property
    def time(self) -> float:
        """End of the planned motions [s]."""
        return sum(segment.duration for segment in self.segments)

    def after(self, segment: TaskSegment) -> "TaskState":
        return replace(
            self,
            positions=segment.end,
            rested=segment.end,
            segments=(*self.segments, segment.settled()),
            legs=(),
            lifting=(),
        )

    def to(self, leg: Leg) -> "TaskState":
        return replace(self, positions=leg.goal, legs=(*self.legs, leg))


Way = TaskState | StageRefusal
"""A way to do a stage: the state after it, or the reason why it is rejected."""


@runtime_checkable
class TaskStage(Protocol):
    """A stage of a task."""

    @property
    def name(self) -> str:
        """Its name, unique in the task."""
        ...

    @property
    def default_name(self) -> str:
        """Name if none is given."""
        ...

    def held_after(self, scene: Scene, group: str, held: frozenset[str]) -> frozenset[str]:
        """Check the stage against the scene before the task, and return the objects that are held after it.

        Args:
            scene: The scene before the task.
            held: Objects that are attached before the stage.

        Raises:
            TrajoptError: If the stage cannot be done.
        """
        ...

    def ways(self, search: "TaskSearch", state: TaskState) -> Iterator[Way]:
        """Yield the ways to do the stage from a state, the preferred first."""
        ...


def in_sequence(stages: Sequence[TaskStage], search: "TaskSearch", state: TaskState) -> Iterator[Way]:
    """Yield the ways to do stages one after the other, by depth-first search over the ways of each."""
    if not stages:
        yield state
        return
    dead_ends = [0] * len(stages)
    reached = False
    trail = [stages[0].ways(search, state)]
    while trail:
        way = next(trail[-1], None)
        if way is None:
            depth = len(trail) - 1
            trail.pop()
            dead_ends[depth] += not reached
            if dead_ends[depth] >= DEAD_ENDS:
                return
        elif isinstance(way, StageRefusal):
            reached = False
            yield way
        elif len(trail) == len(stages):
            reached = True
            yield way
        else:
            trail.append(stages[len(trail)].ways(search, way))


@dataclass(frozen=True, eq=False, kw_only=True)
class TaskSearch:
    """The data shared by all stages of one call of planning.

    Attributes:
        rng: Draws the starts of inverse kinematics, and the bends of seeds.
        tracker: Counts work and time, and ends the search when the budget is used up.
        blend: Distance from the end of a straight motion within which the arm may leave the line [m].
        improve: Whether shape and time of each motion are optimised together.
    """

    group: str
    constraints: tuple[PathConstraint, ...]
    options: GraspingOptions
    rng: np.random.Generator
    tracker: BudgetTracker
    blend: float = 0.0
    improve: bool = False

    def reduced(self, scene: Scene, positions: Floats) -> ReducedModel:
        return reduce_model(scene, self.group, positions)

    def configurations(
        self, reduced: ReducedModel, goals: Sequence[Requirement], stage: str
    ) -> Sequence[Floats] | StageRefusal:
        """Return configurations (n,) that meet goals and path constraints, the nearest first; or why not."""
        wanted = (*goals, *(item for item in self.constraints if isinstance(item, Requirement)))
        counts = WorkCounts()
        query = evaluator(reduced, counts)
        with self.tracker.stage("inverse kinematics"):
            try:
                found = goal_candidates(query, wanted, rng=self.rng, check=lambda: self.tracker.check(counts))
            finally:
                self.tracker.count_work(counts)
        if found.free:
            fixed = fixed_positions(goals, reduced)
            return found.free if fixed is None else (fixed,)
        status = Status.NO_INVERSE_KINEMATICS if found.blocking is None else Status.GOAL_IN_COLLISION
        return StageRefusal(stage, status, reasons.no_goal_configuration(reduced, found, wanted))

    def rested(self, state: TaskState, rest: float = 0.0, name: str = "") -> Way:
        """Plan the legs of a state as one motion, and rest at their end for a time [s].

        If that fails, the motion rests in the middle of them, and so on.

        Args:
            name: TaskStage that the rest is counted to; the last leg's if empty.
        """
        pause = StageRest(name, rest)
        if not state.legs:
            return self._waited(state, pause) if rest > 0.0 else state
        return self._planned(replace(state, legs=()), state.legs, pause)

    def _waited(self, state: TaskState, pause: StageRest) -> Way:
        last = next(reversed(state.segments), None)
        if last is None or state.scene.changing:
            still = Leg(pause.stage, state.positions, state.scene)
            return self._planned(state, (still,), pause)
        longer = replace(last, pauses=(*last.pauses, pause))
        return replace(state, segments=(*state.segments[:-1], longer))

    def _planned(self, state: TaskState, legs: tuple[Leg, ...], pause: StageRest) -> Way:
        problem = self._problem(state, legs, pause.seconds)
        result = self.plan(problem)
        if result.verified:
            segment = TaskSegment(tuple(leg.stage for leg in legs), result, (pause,))
            return self._faster_with_rests(state, legs, pause, state.after(segment))
        if len(legs) == 1:
            return StageRefusal(legs[0].stage, result.status, result.reason, result)
        middle = len(legs) // 2
        half = self._planned(state, legs[:middle], StageRest("", 0.0))
        return half if isinstance(half, StageRefusal) else self._planned(half, legs[middle:], pause)

    def _faster_with_rests(
        self, state: TaskState, legs: tuple[Leg, ...], pause: StageRest, passing: TaskState
    ) -> TaskState:
        """Return the state after a motion through the ends of legs, or with rests there if that is faster.

        Around a sharp corner the arm slows down nearly to a rest, and farther away from it.
        """
        rows = np.array([self.arm(state.scene, at) for at in (state.rested, *(leg.goal for leg in legs))])
        limits = passing.segments[-1].result.problem.limits
        bound = float(travel_time(rows[:-1], rows[1:], limits, rests=True).sum())
        if len(legs) == 1 or passing.segments[-1].trajectory.duration <= bound:
            return passing
        resting = state
        for leg in legs:
            last = leg is legs[-1]
            way = self._planned(replace(resting, legs=()), (leg,), pause if last else StageRest("", 0.0))
            if isinstance(way, StageRefusal) or way.time > passing.time:
                return passing
            resting = way
        return resting

    def arm(self, scene: Scene, positions: Floats) -> Floats:
        return positions[scene.robot.index(scene.robot.group(self.group).joints)]

    def _problem(self, state: TaskState, legs: tuple[Leg, ...], rest: float) -> Problem:
        margins: dict[frozenset[str], float] = {}
        for pair, gap in (item for leg in legs for item in leg.scene.pair_margins.items()):
            margins[pair] = min(gap, margins.get(pair, gap))
        contacts = (*state.lifting, *(item for leg in legs for item in leg.scene.allowances))
        scene = replace(
            state.scene,
            pair_margins=margins,
            allowances=tuple({item.name: item for item in contacts}.values()),
        )
        names = [leg.stage for leg in legs[:-1]]
        goals = [to_configuration(scene, self.group, leg.goal) for leg in legs]
        parts = [
            during(item, after=after, until=until) if names else item
            for leg, after, until in zip(legs, (None, *names), (*names, None), strict=True)
            for item in leg.constraints
        ]
        options = self.options
        return Problem(
            scene=later(scene, state.time),
            group=self.group,
            start=state.rested,
            goal=goals[-1],
            waypoints=dict(zip(names, goals[:-1], strict=True)),
            constraints=(*self.constraints, *parts),
            velocity_scaling=options.velocity_scaling,
            acceleration_scaling=options.acceleration_scaling,
            tool_speed=options.tool_speed,
            dwell=max(rest, SETTLING) if scene.changing else 0.0,
            name=legs[-1].stage,
        )

    def plan(self, problem: Problem) -> Result:
        """Plan one motion within the remaining budget.

        Raises:
            Stopped: If the budget ends.
        """
        tracker, left = self.tracker, self.tracker.remaining()
        result = plan(
            problem,
            method=None if self.improve else self.options.method,
            improve=self.improve,
            rng=self.rng,
            budget=replace(left, attempts=left.attempts or ATTEMPTS),
            cancel=tracker.cancel,
            progress=tracker.progress,
        )
        tracker.add(result.counts, result.cpu_seconds)
        if result.stopped is not None and not result.verified:
            raise Stopped(result.stopped)
        return result
