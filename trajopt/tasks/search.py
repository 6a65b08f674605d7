"""Search for a plan of a task."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Protocol, runtime_checkable

import numpy as np

from trajopt.geometry import WorkCounts, evaluator
from trajopt.geometry.geometry import TOUCHING, distance_from
from trajopt.optimise.kinematics.inverse import goal_candidates
from trajopt.optimise.terms.joint_positions import fixed_positions
from trajopt.planning.budget import BudgetTracker, Stopped
from trajopt.planning.infeasibility import out_of_reach, reasons
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
from trajopt.tasks.grasping.straight import KNOTS, to_configuration, with_room
from trajopt.tasks.result import SETTLING, Handling, StageRest, TaskSegment
from trajopt.tasks.sequence import NO_NAMES, CandidateNames, StageRefusal
from trajopt.timing.time_scaling import travel_time
from trajopt.values.arrays import Floats, sequence, several
from trajopt.values.errors import ProblemError, TrajoptError, shown
from trajopt.values.placement import WORLD

ATTEMPTS = 16
"""Default number of seeds for each motion."""
DEAD_ENDS = 4
"""Number of times that all ways of a stage may lead to nothing before the search ends."""
RELEASED = 1e-3
"""Distance from an object at which fingers that moved away no longer hold it [m]."""


@dataclass(frozen=True, eq=False)
class Leg:
    """A motion to a configuration that is not planned yet.

    Attributes:
        goal: Positions of all joints at its end [rad | m].
        scene: Scene of this leg, with its margins and allowed contacts.
        near: Positions of all joints at the object, for a straight leg that begins or ends there [rad | m].
        group: Group that moves; the arm if empty.
        names: The grasp and the place that it belongs to.
        part: Group that must be at its goal when it is passed; all that moves if empty.
        after: Stage with whose end it begins: empty for the begin of the motion, None for the leg before.
    """

    stage: str
    goal: Floats
    scene: Scene
    constraints: tuple[PathConstraint, ...] = ()
    near: Floats | None = None
    group: str = ""
    names: CandidateNames = NO_NAMES
    part: str = ""
    after: str | None = None


@dataclass(frozen=True, eq=False)
class TaskRest:
    """A rest of the arm.

    Attributes:
        stage: Stage that it is counted to; as the leg before if empty.
    """

    scene: Scene
    stage: str = ""
    seconds: float = 0.0


Choices = Sequence[tuple[int, str]]

Step = Leg | TaskRest | TaskSegment
"""A motion to plan, a rest, or a motion that is planned."""


@dataclass(frozen=True, eq=False)
class TaskState:
    """State of a task after some of its stages.

    The steps are planned later, but their ends are known exactly.

    Attributes:
        scene: The scene after the steps, with the clock of the beginning of the task.
        positions: Of all joints, after the steps [rad | m].
        rested: Of all joints, at the end of the planned motions [rad | m].
        steps: Steps after the planned motions. Legs without a rest between them become one motion.
        handled: Object -> how it was picked and placed each time.
        lifting: Contacts with supports that the next motion may begin with.
        loose: Attached objects that fingers have let go of.
        choices: Stage with alternatives, or in any order -> the places of its items in the order of the plan,
            each with words: whether it was chosen, and its cost.
    """

    scene: Scene
    positions: Floats
    rested: Floats
    segments: tuple[TaskSegment, ...] = ()
    steps: tuple[Step, ...] = ()
    handled: Mapping[str, tuple[Handling, ...]] = field(default_factory=dict[str, tuple[Handling, ...]])
    lifting: tuple[ContactAllowance, ...] = ()
    loose: frozenset[str] = frozenset()
    choices: Mapping[str, Choices] = field(default_factory=dict[str, Choices])

    @property
    def time(self) -> float:
        """Duration of the planned motions [s]."""
        return sum(segment.duration for segment in self.segments)

    def to(self, leg: Leg) -> "TaskState":
        """Return the state after a leg."""
        if self.lifting:
            leg = replace(leg, scene=replace(leg.scene, allowances=(*leg.scene.allowances, *self.lifting)))
        return replace(self, positions=leg.goal, steps=(*self.steps, leg), lifting=())

    def rest(self, seconds: float = 0.0, name: str = "") -> "TaskState":
        return replace(self, steps=(*self.steps, TaskRest(self.scene, name, seconds)))

    def through(self, segment: TaskSegment) -> "TaskState":
        """Return the state after a planned motion, with a rest before it."""
        return replace(self, positions=segment.end, steps=(*self.steps, TaskRest(self.scene), segment))

    def moved(self, segment: TaskSegment) -> "TaskState":
        """Return the state with one more planned motion."""
        return replace(self, rested=segment.end, segments=(*self.segments, segment.settled()))


Way = TaskState | StageRefusal
"""A way to do a stage: the state after it, or why it is rejected."""


def choosing(ways: Iterable[Way], stage: str, choices: Choices) -> Iterator[Way]:
    for way in ways:
        yield way if isinstance(way, StageRefusal) else replace(way, choices={**way.choices, stage: choices})


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
        """Check the stage against the scene before the task, and return the objects held after it.

        Args:
            held: Objects attached before the stage.

        Raises:
            TrajoptError: If the stage cannot be done.
        """
        ...

    def ways(self, search: "TaskSearch", state: TaskState) -> Iterator[Way]:
        """Yield the ways to do the stage from a state, the preferred first."""
        ...


Item = TaskStage | Sequence[TaskStage]
"""One stage or several in sequence."""


@runtime_checkable
class StageWithItems(TaskStage, Protocol):
    """A stage that consists of items."""

    @property
    def items(self) -> Sequence[Item]:
        """The items, each a stage or several in sequence."""
        ...


def as_items(items: Sequence[Item]) -> tuple[tuple[TaskStage, ...], ...]:
    found: list[tuple[TaskStage, ...]] = []
    for item in sequence("items", items):
        found.append(several("items", item if isinstance(item, Sequence) else (item,), TaskStage))
    if not all(found) or not found:
        raise ProblemError("name at least one stage in each item")
    return tuple(found)


def is_step_of(step: str, stage: TaskStage) -> bool:
    """Return whether a stage has a step of that name."""
    return step == stage.name or step.startswith(f"{stage.name}: ")


def flat(stages: Sequence[TaskStage]) -> Iterator[TaskStage]:
    """Yield all stages in order, one with items after these."""
    for stage in stages:
        if isinstance(stage, StageWithItems):
            for item in as_items(stage.items):
                yield from flat(item)
        yield stage


def held_after(stages: Iterable[TaskStage], scene: Scene, group: str, held: frozenset[str]) -> frozenset[str]:
    """Check stages in order as `TaskStage.held_after` does; the message names the stage."""
    for stage in stages:
        try:
            held = stage.held_after(scene, group, held)
        except TrajoptError as error:
            raise ProblemError(f"stage {shown(stage.name)}: {error}") from error
    return held


def check_frames(scene: Scene, required: Iterable[object]) -> None:
    for item in required:
        for name in item.frames if isinstance(item, Requirement) else ():
            scene.holder(name)


def refuse_changing(scene: Scene, name: str) -> None:
    if name in scene.changing:
        raise ProblemError(
            f"object {shown(name)} moves by itself, or is there for a time only: tasks handle objects at rest"
        )


class Rest:
    """The end of a task: the arm rests."""

    name = default_name = ""

    def held_after(self, scene: Scene, group: str, held: frozenset[str]) -> frozenset[str]:
        del scene, group
        return held

    def ways(self, search: "TaskSearch", state: TaskState) -> Iterator[Way]:
        yield search.rested(state)


@dataclass(eq=False)
class _Level:
    """A stage of the sequence; `followed` if a way of it was followed by the next stage."""

    begin: TaskState
    ways: Iterator[Way]
    followed: bool = False


def in_sequence(stages: Sequence[TaskStage], search: "TaskSearch", state: TaskState) -> Iterator[Way]:
    """Yield the ways to do stages in order, by depth-first search over the ways of each.

    The motions before a stage are planned when the stage has a way.
    """
    begin = search.planned(state)
    if isinstance(begin, StageRefusal) or not stages:
        yield begin
        return
    dead_ends = [0] * len(stages)
    trail = [_Level(begin, stages[0].ways(search, begin))]
    while trail:
        level, depth = trail[-1], len(trail) - 1
        way = next(level.ways, None)
        if way is None:
            trail.pop()
            dead_ends[depth] += level.followed
            if dead_ends[depth] >= DEAD_ENDS:
                return
            continue
        if not isinstance(way, StageRefusal):
            way = search.holding(level.begin, way, stages[depth].name)
        if not isinstance(way, StageRefusal):
            way = search.continued(level.begin, way)
            if isinstance(way, StageRefusal):
                trail.pop()
        if isinstance(way, StageRefusal) or len(trail) == len(stages):
            yield way
        else:
            level.followed = True
            trail.append(_Level(way, stages[len(trail)].ways(search, way)))


def held_objects(scene: Scene) -> frozenset[str]:
    """Return the objects attached to links."""
    return frozenset(name for name in scene.objects if scene.holder(name).link != WORLD)


def _placed(name: str, state: TaskState) -> Floats:
    return state.scene.placement_of(name, state.positions).homogeneous


def _let_go(name: str, before: TaskState, after: TaskState, loose: frozenset[str]) -> frozenset[str]:
    """Return the loose objects with or without one, if fingers that may touch it have moved."""
    scene = after.scene
    held = [(state.positions, scene.placement_of(name, state.positions)) for state in (before, after)]
    for link in sorted(scene.object(name).touch_links & {*scene.robot.links}):
        first, last = (place.inverse() * scene.placement_of(link, at) for at, place in held)
        if np.allclose(first.homogeneous, last.homogeneous):
            continue
        was, now = (distance_from(scene, name, (link,), at) for at, _ in held)
        if was < TOUCHING and now > max(was, RELEASED):
            return loose | {name}
        if now <= RELEASED:
            loose -= {name}
    return loose


def later(scene: Scene, time: float) -> Scene:
    return scene.at(time) if scene.changing else scene


@dataclass(frozen=True, eq=False, kw_only=True)
class TaskSearch:
    """The data shared by all stages of one call of planning.

    Attributes:
        blend: Distance from the end of a straight motion within which the arm may leave the line [m].
    """

    group: str
    constraints: tuple[PathConstraint, ...]
    options: GraspingOptions
    rng: np.random.Generator
    tracker: BudgetTracker
    blend: float = 0.0
    improve: bool = False
    stops: bool = False
    _refused_before: dict[tuple[object, ...], StageRefusal] = field(
        init=False, default_factory=dict[tuple[object, ...], StageRefusal]
    )
    _planned_before: dict[TaskState, Way] = field(init=False, default_factory=dict[TaskState, Way])

    def reduced(self, scene: Scene, positions: Floats) -> ReducedModel:
        return reduce_model(scene, self.group, positions)

    def configurations(
        self,
        reduced: ReducedModel,
        goals: Sequence[Requirement],
        stage: str,
        names: CandidateNames = NO_NAMES,
        *,
        same: tuple[object, ...] = (),
        moved: str = "",
    ) -> Sequence[Floats] | StageRefusal:
        """Return configurations (n,) that meet goals and path constraints, the nearest first; or why not.

        A refusal holds for all postures of the arm before: it is not searched for again.

        Args:
            same: The candidate on which the goals depend, beyond the other joints and objects.
            moved: Object whose place the candidate implies.
        """
        robot, objects = reduced.scene.robot, reduced.scene.objects
        others = np.delete(reduced.start, robot.index(robot.group(reduced.group).joints))
        around = frozenset(item for name, item in objects.items() if name != moved)
        key = (stage, *same, around, others.tobytes())
        if key not in self._refused_before:
            found = self._configurations(reduced, goals, stage, names)
            if not isinstance(found, StageRefusal):
                return found
            self._refused_before[key] = found
        return self._refused_before[key]

    def _configurations(
        self, reduced: ReducedModel, goals: Sequence[Requirement], stage: str, names: CandidateNames
    ) -> Sequence[Floats] | StageRefusal:
        wanted = (*goals, *(item for item in self.constraints if isinstance(item, Requirement)))
        for item in wanted:
            if far := out_of_reach(item, reduced):
                return StageRefusal(stage, Status.NO_INVERSE_KINEMATICS, far, names=names)
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
        return StageRefusal(stage, status, reasons.no_goal_configuration(reduced, found, wanted), names=names)

    def rested(self, state: TaskState, rest: float = 0.0, name: str = "") -> Way:
        """Plan all steps of a state, with a rest after them [s]."""
        return self.planned(state.rest(rest, name))

    def planned(self, state: TaskState) -> Way:
        """Plan the steps of a state up to its last rest; legs after it remain."""
        if state not in self._planned_before:
            self._planned_before[state] = self._with_steps(state)
        return self._planned_before[state]

    def continued(self, before: TaskState, way: TaskState) -> Way:
        """Return a way with the motions planned for the state before it."""
        if way.segments != before.segments:
            return way
        begun = self.planned(before)
        if isinstance(begun, StageRefusal):
            return begun
        steps = (*begun.steps, *way.steps[len(before.steps) :])
        return replace(way, segments=begun.segments, rested=begun.rested, steps=steps)

    def holding(self, before: TaskState, way: TaskState, stage: str) -> Way:
        """Return a way with the objects that fingers let go of; refused if it carries one of them."""
        for name in sorted(before.loose & way.loose):
            if not np.allclose(*(_placed(name, state) for state in (before, way)), atol=RELEASED):
                words = f"the fingers have let go of {shown(name)}: detach it or close them on it"
                return StageRefusal(stage, Status.GRIPPER_CANNOT, f"{words} before the arm moves")
        held, loose = held_objects(way.scene), way.loose
        for name in held:
            if way.scene.objects[name] is before.scene.objects.get(name):
                loose = _let_go(name, before, way, loose)
        return replace(way, loose=loose & held)

    def _with_steps(self, state: TaskState) -> Way:
        done, legs = replace(state, steps=()), tuple[Leg, ...]()
        for step in (*state.steps, *([TaskRest(state.scene)] if self.stops else [])):
            if isinstance(step, TaskSegment):
                done = done.moved(step)
                continue
            if isinstance(step, Leg) and not (self.stops and legs):
                legs = (*legs, step)
                continue
            after = self._after(done, legs, step if isinstance(step, TaskRest) else TaskRest(state.scene))
            if isinstance(after, StageRefusal):
                return after
            done, legs = after, (step,) if isinstance(step, Leg) else ()
        return replace(done, steps=legs)

    def _after(self, state: TaskState, legs: tuple[Leg, ...], pause: TaskRest) -> Way:
        if legs:
            return self._moved(state, legs, StageRest(pause.stage, pause.seconds))
        return self._waited(state, pause) if pause.seconds > 0.0 or pause.stage else state

    def _waited(self, state: TaskState, pause: TaskRest) -> Way:
        last, rest = next(reversed(state.segments), None), StageRest(pause.stage, pause.seconds)
        if pause.seconds > 0.0 and (last is None or pause.scene.changing):
            return self._moved(state, (Leg(pause.stage, state.rested, pause.scene),), rest)
        if last is None:
            return state
        longer = replace(last, pauses=(*last.pauses, rest))
        return replace(state, segments=(*state.segments[:-1], longer))

    def _moved(self, state: TaskState, legs: tuple[Leg, ...], pause: StageRest) -> Way:
        """Plan legs as one motion; if that fails, the motion rests in the middle of them, and so on."""
        problem = self._problem(state, legs, pause.seconds)
        result = self.plan(problem)
        if result.verified:
            after = {leg.stage: leg.after for leg in legs if leg.after is not None}
            segment = TaskSegment(tuple(leg.stage for leg in legs), result, (pause,), after)
            return self._faster_with_rests(state, legs, pause, state.moved(segment))
        if len(legs) == 1:
            leg = legs[0]
            words = result.reason.removeprefix(f"{result.status.name}: ")
            return StageRefusal(leg.stage, result.status, words, result, leg.names)
        middle = len(legs) // 2
        half = self._moved(state, legs[:middle], StageRest("", 0.0))
        return half if isinstance(half, StageRefusal) else self._moved(half, legs[middle:], pause)

    def _faster_with_rests(
        self, state: TaskState, legs: tuple[Leg, ...], pause: StageRest, passing: TaskState
    ) -> TaskState:
        """Rest at the ends of legs if that is faster: around a sharp corner the arm nearly rests anyway."""
        if len(legs) == 1:
            return passing
        rows = np.array([self.arm(state.scene, at) for at in (state.rested, *(leg.goal for leg in legs))])
        limits = passing.segments[-1].result.problem.limits
        bound = float(travel_time(rows[:-1], rows[1:], limits, rests=True).sum())
        if passing.segments[-1].trajectory.duration <= bound:
            return passing
        resting = state
        for leg in legs:
            last = leg is legs[-1]
            way = self._moved(resting, (leg,), pause if last else StageRest("", 0.0))
            if isinstance(way, StageRefusal) or way.time > passing.time:
                return passing
            resting = way
        return resting

    def arm(self, scene: Scene, positions: Floats) -> Floats:
        """Return the positions of the group of the task."""
        return positions[scene.robot.index(scene.robot.group(self.group).joints)]

    def _problem(self, state: TaskState, legs: tuple[Leg, ...], rest: float) -> Problem:
        scenes = [self._with_margins(leg, state.time) for leg in legs]
        margins: dict[frozenset[str], float] = {}
        for pair, gap in (item for scene in scenes for item in scene.pair_margins.items()):
            margins[pair] = min(gap, margins.get(pair, gap))
        contacts = {item.name: item for scene in scenes for item in scene.allowances}
        scene = replace(scenes[0], pair_margins=margins, allowances=tuple(contacts.values()))
        group = legs[0].group or self.group
        of_arm = group == self.group
        names = [leg.stage for leg in legs[:-1]]
        goals = [to_configuration(scene, leg.part or group, leg.goal) for leg in legs[:-1]]
        parts = [
            during(item, after=after, until=until) if names else item
            for leg, before, until in zip(legs, (None, *names), (*names, None), strict=True)
            for after in (before if leg.after is None else leg.after if leg.after in names else None,)
            for item in leg.constraints
        ]
        options = self.options
        straight = len(legs) == 1 and legs[0].near is not None
        return Problem(
            scene=scene,
            group=group,
            start=state.rested,
            goal=to_configuration(scene, group, legs[-1].goal),
            waypoints=dict(zip(names, goals, strict=True)),
            constraints=(*self.constraints, *parts) if of_arm else (),
            velocity_scaling=options.velocity_scaling,
            acceleration_scaling=options.acceleration_scaling,
            tool_speed=options.tool_speed if of_arm else (),
            dwell=max(rest, SETTLING) if scene.changing else 0.0,
            knots=KNOTS if straight else 0,
            name=legs[-1].stage,
        )

    def _with_margins(self, leg: Leg, time: float) -> Scene:
        scene = later(leg.scene, time)
        if leg.near is None:
            return scene
        return with_room(self.reduced(scene, leg.near), self.arm(scene, leg.near))

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
