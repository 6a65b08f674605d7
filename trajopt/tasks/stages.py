"""Stages of a task: motions, pauses, handling of objects, and choices between them."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from math import inf

import numpy as np

from trajopt.geometry.geometry import gap, supports
from trajopt.planning.infeasibility import reasons
from trajopt.planning.status import Status
from trajopt.problem.problem import PathConstraint
from trajopt.problem.requirements import FollowsCurve, Requirement
from trajopt.problem.stated import GoalLike, stated_goal
from trajopt.scene.reducing import reduce_model
from trajopt.scene.scene import Scene
from trajopt.tasks.cartesian.following import Begin, FollowOptions, follow
from trajopt.tasks.cartesian.result import Followed
from trajopt.tasks.grasping.stages import lifting_scene
from trajopt.tasks.grasping.straight import along_line, track_line
from trajopt.tasks.result import TaskSegment
from trajopt.tasks.search import (
    Item,
    Leg,
    TaskSearch,
    TaskStage,
    TaskState,
    Way,
    as_items,
    check_frames,
    choosing,
    held_after,
    in_sequence,
    later,
    refuse_changing,
)
from trajopt.tasks.sequence import StageRefusal
from trajopt.timing.time_scaling import travel_time
from trajopt.values.arrays import Floats, Value, at_least, function, not_negative, number, one_of, positive
from trajopt.values.errors import ProblemError, shown
from trajopt.values.errors.arguments import checked
from trajopt.values.placement import WORLD, Placement, PlacementLike, as_placement
from trajopt.values.printed import in_length
from trajopt.values.shapes.shapes import Shape, Sphere
from trajopt.verify import Judge, Moment


@checked
@dataclass(frozen=True, eq=False)
class MoveTo(Value):
    """The arm moves to a goal; it does not rest there unless the next stage needs it.

    Attributes:
        goal: A state of the group, joint positions, a placement of the tool, or requirements, as the goal of
            a problem.
        constraints: Requirements on the way.
        group: Part of the group of the task that moves; all of it if empty.
    """

    goal: GoalLike | Sequence[GoalLike]
    name: str = ""
    constraints: Sequence[PathConstraint] = ()
    group: str = ""

    @property
    def default_name(self) -> str:
        return f"move to {self.goal}" if isinstance(self.goal, str) else "move"

    def held_after(self, scene: Scene, group: str, held: frozenset[str]) -> frozenset[str]:
        if left_over := _joints(scene, self.group or group) - _joints(scene, group):
            joints = ", ".join(sorted(left_over))
            raise ProblemError(f"group {shown(self.group)} has joints that the task does not move: {joints}")
        check_frames(scene, (*self.requirements(scene, group), *self.constraints))
        return held

    def requirements(self, scene: Scene, group: str) -> tuple[Requirement, ...]:
        """Return the requirements at the goal.

        Raises:
            ProblemError: If the goal is a set, or has no accepted form.
        """
        stated = stated_goal(scene, self.group or group, self.goal, degrees=False)
        if isinstance(stated, dict):
            raise ProblemError("a set of goals is a choice: use OneOf with a stage for each goal")
        return stated

    def wanted(self, scene: Scene, group: str) -> tuple[Requirement, ...]:
        """Return the requirements at the goal and on the way."""
        kept = (item for item in self.constraints if isinstance(item, Requirement))
        return (*self.requirements(scene, group), *kept)

    def ways(self, search: TaskSearch, state: TaskState) -> Iterator[Way]:
        found = self.ends(search, state.scene, state.positions)
        if isinstance(found, StageRefusal):
            yield found
            return
        for positions in found:
            yield self.leg(state, positions)

    def ends(self, search: TaskSearch, scene: Scene, positions: Floats) -> Sequence[Floats] | StageRefusal:
        """Return positions of all joints (number of joints,) at the goal, the nearest first; or why not."""
        reduced = reduce_model(scene, self.group or search.group, positions)
        wanted = self.wanted(scene, search.group)
        found = search.configurations(reduced, wanted, self.name, same=(self,))
        if isinstance(found, StageRefusal):
            return found
        return [reduced.all_positions(each) for each in found[: search.options.configurations]]

    def leg(self, state: TaskState, goal: Floats) -> TaskState:
        """Return the state after a leg to a configuration of all joints."""
        return state.to(Leg(self.name, goal, state.scene, tuple(self.constraints)))


def _joints(scene: Scene, group: str) -> set[str]:
    return set(scene.robot.group(group).joints)


@checked
@dataclass(frozen=True, eq=False)
class FollowCurve(Value):
    """The arm moves to the beginning of a curve, and a frame follows it.

    Attributes:
        curve: The curve with its frame and tolerances: `follows_curve(...)`.
        options: Speeds of the process, and the reaction to obstacles.
        off: Length of a straight motion along z of the frame before the curve, and back after it [m].
    """

    curve: FollowsCurve
    options: FollowOptions = field(default_factory=partial(FollowOptions, begin=Begin.ANY_BRANCH))
    off: float = 0.0
    name: str = ""
    default_name = "follow"

    def __post_init__(self) -> None:
        not_negative("off", self.off)

    def held_after(self, scene: Scene, group: str, held: frozenset[str]) -> frozenset[str]:
        del group
        for frame in (self.curve.frame, self.curve.reference):
            scene.holder(frame)
        if not {self.curve.frame, self.curve.reference} & held and all(
            scene.holder(frame).link == WORLD for frame in (self.curve.frame, self.curve.reference)
        ):
            raise ProblemError(
                f"{shown(self.curve.frame)} is fixed in the world: follow the curve with a frame of the arm"
            )
        if scene.changing:
            names = ", ".join(map(shown, scene.changing))
            raise ProblemError(
                f"a task follows curves in static scenes only, and {names} changes: follow it with `follow`"
            )
        return held

    def ways(self, search: TaskSearch, state: TaskState) -> Iterator[Way]:
        options = replace(self.options, begin=Begin.ANY_BRANCH)
        found = followed(search, state, self.curve, options, group=search.group)
        if not found.complete:
            yield StageRefusal(self.name, found.status, found.reason, found.result)
            return
        segment = TaskSegment((self.name,), found.result)
        begun = self._led(search, state, segment.positions(0.0))
        if isinstance(begun, StageRefusal):
            yield begun
            return
        ended = begun.through(segment)
        if self.off > 0.0:
            away = self._beside(search, ended, ended.positions)
            if isinstance(away, StageRefusal):
                yield away
                return
            ended = ended.to(self._straight(search, ended, "retract", ended.positions, away))
        yield ended

    def _led(self, search: TaskSearch, state: TaskState, begin: Floats) -> Way:
        if self.off == 0.0:
            return state.to(Leg(f"{self.name}: reach", begin, state.scene))
        before = self._beside(search, state, begin)
        if isinstance(before, StageRefusal):
            return before
        reached = state.to(Leg(f"{self.name}: reach", before, state.scene))
        return reached.to(self._straight(search, state, "approach", before, begin))

    def _beside(self, search: TaskSearch, state: TaskState, at: Floats) -> Floats | StageRefusal:
        scene, frame = state.scene, self.curve.frame
        reduced = search.reduced(scene, at)
        away = -self.off * scene.placement_of(frame, at).rotation[:, 2]
        found = track_line(reduced, frame, search.arm(scene, at), away, search.tracker)
        if found.status is not None:
            return StageRefusal(self.name, found.status, f"off an end of the curve: {found.reason}")
        return reduced.all_positions(found.end)

    def _straight(self, search: TaskSearch, state: TaskState, name: str, begin: Floats, end: Floats) -> Leg:
        line = along_line(state.scene, begin, end, self.curve.frame, search.options)
        near = begin if name == "retract" else end
        return Leg(f"{self.name}: {name}", end, state.scene, line, near=near)


def followed(
    search: TaskSearch, state: TaskState, curve: FollowsCurve, options: FollowOptions, *, group: str
) -> Followed:
    """Follow a curve in the scene after a state, within the remaining budget."""
    found = follow(
        later(state.scene, state.time),
        curve,
        start=state.positions,
        group=group,
        options=options,
        rng=search.rng,
        budget=replace(search.tracker.remaining(), attempts=None),
        cancel=search.tracker.cancel,
        progress=search.tracker.progress,
    )
    search.tracker.add(found.counts, found.cpu_seconds)
    return found


@checked
@dataclass(frozen=True, eq=False)
class Dwell(Value):
    """The arm rests for some `seconds` [s]."""

    seconds: float
    name: str = ""
    default_name = "dwell"

    def __post_init__(self) -> None:
        positive("seconds", self.seconds)

    def held_after(self, scene: Scene, group: str, held: frozenset[str]) -> frozenset[str]:
        del scene, group
        return held

    def ways(self, search: TaskSearch, state: TaskState) -> Iterator[Way]:
        del search
        yield state.rest(self.seconds, self.name)


POINT = 1e-6
"""Radius of a frame as a shape [m]."""


@checked
@dataclass(frozen=True, eq=False)
class AttachObject(Value):
    """An object is attached to a link from now on, as by a suction cup switched on.

    The next motion may begin in contact with the objects that it stands on.

    Attributes:
        within: Largest distance of the object from the frame, from the bodies that move with it, and from the
            touch links [m]; inf if it may be anywhere.
    """

    object: str
    link: str
    touch_links: Sequence[str] = ()
    name: str = ""
    within: float = 0.05

    def __post_init__(self) -> None:
        not_negative("within", self.within, infinite=True)

    @property
    def default_name(self) -> str:
        return f"attach {self.object}"

    def held_after(self, scene: Scene, group: str, held: frozenset[str]) -> frozenset[str]:
        del group
        scene.object(self.object)
        for name in (self.link, *self.touch_links):
            scene.holder(name)
        if self.object in held:
            raise ProblemError(f"object {self.object!r} is attached already")
        if self.link not in held and scene.holder(self.link).link == WORLD:
            raise ProblemError(
                f"{shown(self.link)} is fixed in the world: attach the object to a link of the robot"
            )
        refuse_changing(scene, self.object)
        return held | {self.object}

    def ways(self, search: TaskSearch, state: TaskState) -> Iterator[Way]:
        scene, at = state.scene, state.positions
        away = self._distance(scene, at)
        if away > self.within:
            words = (
                f"{shown(self.object)} is {in_length(away)} away from {shown(self.link)}, farther than "
                f"{in_length(self.within)}: move there first, or state the distance as `within`"
            )
            yield StageRefusal(self.name, Status.GRIPPER_CANNOT, words)
            return
        held = scene.attach(self.object, self.link, at=at, touch_links=tuple(self.touch_links))
        stood_on = supports(scene, self.object, scene.placement_of(self.object, at))
        lifted = lifting_scene(held, self.object, stood_on, search.options.contact_time)
        yield replace(state.rest(name=self.name), scene=held, lifting=lifted.allowances)

    def _distance(self, scene: Scene, at: Floats) -> float:
        """Return the distance of the object from what holds it [m]."""
        holder, bodies = scene.holder(self.link).link, (*scene.robot.bodies, *scene.object_bodies())
        place = scene.placement_of(self.object, at)
        near: list[tuple[Placement, Shape]] = [(scene.placement_of(self.link, at), Sphere(POINT))]
        near += [
            (scene.placement_of(body.frame, at) * body.placement, body.shape)
            for body in bodies
            if body.owner != self.object and (body.frame == holder or body.owner in self.touch_links)
        ]
        parts = scene.object(self.object).parts
        gaps = (gap(place * where, shape, *other) for shape, where in parts for other in near)
        return max(min(gaps), 0.0)


@checked
@dataclass(frozen=True, eq=False)
class DetachObject(Value):
    """An attached object stays in place from now on."""

    object: str
    name: str = ""

    @property
    def default_name(self) -> str:
        return f"detach {self.object}"

    def held_after(self, scene: Scene, group: str, held: frozenset[str]) -> frozenset[str]:
        del group
        scene.object(self.object)
        if self.object not in held:
            raise ProblemError(f"object {self.object!r} is not attached: attach or pick it before")
        return held - {self.object}

    def ways(self, search: TaskSearch, state: TaskState) -> Iterator[Way]:
        del search
        yield replace(state.rest(name=self.name), scene=state.scene.detach(self.object, at=state.positions))


@checked
@dataclass(frozen=True, eq=False)
class MoveObject(Value):
    """An object is elsewhere from now on, as a door that a machine opens while the arm rests.

    Attributes:
        placement: Its new placement in its frame.
        seconds: Time that this takes, for which the arm rests [s].
    """

    object: str
    placement: PlacementLike
    seconds: float = 0.0
    name: str = ""

    def __post_init__(self) -> None:
        object.__setattr__(self, "placement", as_placement("placement", self.placement))
        not_negative("seconds", self.seconds)

    @property
    def default_name(self) -> str:
        return f"move object {self.object}"

    def held_after(self, scene: Scene, group: str, held: frozenset[str]) -> frozenset[str]:
        del group
        scene.object(self.object)
        if self.object in held:
            raise ProblemError(f"object {self.object!r} is attached: place or detach it before")
        refuse_changing(scene, self.object)
        return held

    def ways(self, search: TaskSearch, state: TaskState) -> Iterator[Way]:
        yield changed(
            search, state, lambda scene: scene.move(self.object, self.placement), self.name, self.seconds
        )


def changed(
    search: TaskSearch,
    state: TaskState,
    change: Callable[[Scene], Scene],
    name: str,
    seconds: float = 0.0,
) -> Way:
    """Return the state after a change of the scene, while the arm rests for some seconds [s]."""
    there = search.rested(state, seconds, name)
    if isinstance(there, StageRefusal):
        return there
    scene = change(there.scene)
    reduced = search.reduced(later(scene, there.time), there.positions)
    seen = Judge(reduced).examine(reduced.start_positions, moment=Moment.START)
    if not seen.collisions:
        return replace(there, scene=scene)
    words = f"the object meets the arm at rest: {reasons.collisions(seen)}"
    return StageRefusal(name, Status.START_IN_COLLISION, words)


Cost = Callable[[Sequence[TaskSegment]], float]
"""Returns the cost of the motions of an alternative; the smallest is preferred."""


def duration(segments: Sequence[TaskSegment]) -> float:
    """Return the duration of motions [s]."""
    return sum(segment.duration for segment in segments)


def joint_travel(segments: Sequence[TaskSegment]) -> float:
    """Return the sum over all motions and joints of the travelled way, from point to point [rad | m]."""
    return sum(float(np.abs(np.diff(segment.trajectory.positions, axis=0)).sum()) for segment in segments)


def least_clearance(segments: Sequence[TaskSegment]) -> float:
    """Return the least proven clearance of motions [m]; infinity without any."""
    return min((segment.result.require().certificate.clearance for segment in segments), default=inf)


@checked
@dataclass(frozen=True, kw_only=True)
class StageCost(Value):
    """A weighted sum as the cost of an alternative of `OneOf`.

    Attributes:
        duration: Weight of the duration [1/s].
        joint_travel: Weight of the travelled way of all joints [1/rad | 1/m].
        clearance: Weight of the least clearance, which is subtracted [1/m].
    """

    duration: float = 0.0
    joint_travel: float = 0.0
    clearance: float = 0.0

    def __post_init__(self) -> None:
        at_least(self, 0.0, "duration", "joint_travel", "clearance")

    @checked
    def __call__(self, segments: Sequence[TaskSegment]) -> float:
        clearance = self.clearance * least_clearance(segments) if self.clearance else 0.0
        return self.duration * duration(segments) + self.joint_travel * joint_travel(segments) - clearance


@checked
@dataclass(frozen=True, kw_only=True)
class StageLimits(Value):
    """Limits of the ways to do a stage, for `Within`.

    Attributes:
        duration: Longest duration, rests included [s].
        joint_travel: Longest travelled way of all joints [rad | m].
        clearance: Least proven clearance [m].
        joints: Joint -> lowest and highest position at all points of the motions [rad | m].
    """

    duration: float = inf
    joint_travel: float = inf
    clearance: float = -inf
    joints: Mapping[str, tuple[float, float]] = field(default_factory=dict[str, tuple[float, float]])

    def __post_init__(self) -> None:
        for name in ("duration", "joint_travel"):
            not_negative(name, getattr(self, name), infinite=True)
        number("clearance", self.clearance, infinite=True)
        for joint, bounds in self.joints.items():
            if not isinstance(bounds, list | tuple) or len(bounds) != 2:  # pyright: ignore[reportUnnecessaryIsInstance]
                raise ProblemError(
                    f"joints: {shown(joint)} needs the lowest and highest position, is {shown(bounds)}"
                )
            low, high = bounds
            if number("joints", low, infinite=True) > number("joints", high, infinite=True):
                raise ProblemError(f"joints: the range of {shown(joint)} is empty: {low:g} to {high:g}")

    def broken(self, segments: Sequence[TaskSegment], seconds: float) -> str:
        """Return the limit that motions of a duration exceed, "" if none."""
        if seconds > self.duration:
            return f"takes {seconds:.2f} s, longer than {self.duration:g} s"
        travel, clearance = joint_travel(segments), least_clearance(segments)
        if travel > self.joint_travel:
            return f"the joints travel {travel:.3g}, farther than {self.joint_travel:g}"
        if clearance < self.clearance:
            return f"has a clearance of {in_length(clearance)}, less than {in_length(self.clearance)}"
        return next((words for segment in segments if (words := self._left(segment))), "")

    def _left(self, segment: TaskSegment) -> str:
        rows = np.array([segment.positions(time) for time in segment.trajectory.times.tolist()])
        for joint, (low, high) in self.joints.items():
            at = rows[:, segment.scene.robot.index([joint])[0]]
            if at.min() < low or at.max() > high:
                return f"{joint} moves from {at.min():.3g} to {at.max():.3g}, out of {low:g} to {high:g}"
        return ""


def held_after_each(
    items: Sequence[Item], scene: Scene, group: str, held: frozenset[str]
) -> Iterator[frozenset[str]]:
    for item in as_items(items):
        yield held_after(item, scene, group, held)


def _in_order(items: Sequence[Item]) -> list[TaskStage]:
    return [stage for item in as_items(items) for stage in item]


def held_after_any(items: Sequence[Item], scene: Scene, group: str, held: frozenset[str]) -> frozenset[str]:
    after = set(held_after_each(items, scene, group, held))
    if len(after) > 1:
        names = " or ".join(sorted(", ".join(sorted(each)) or "nothing" for each in after))
        raise ProblemError(f"the alternatives end with different objects in the hand: {names}")
    return after.pop()


@dataclass(frozen=True, eq=False)
class OneOf(Value):
    """The cheapest of several alternatives that can be planned.

    Attributes:
        cost: Of the motions of an alternative: a `StageCost`, or a function.
        ways_each: Ways of each alternative that are compared, such as the grasps of a pick.
    """

    items: Sequence[Item]
    cost: Cost = duration
    name: str = ""
    ways_each: int = 1
    default_name = "one of"

    def __post_init__(self) -> None:
        object.__setattr__(self, "items", as_items(self.items))
        function("cost", self.cost)
        if type(self.ways_each) is not int or self.ways_each < 1:
            raise ProblemError(f"ways_each must be a whole number from 1, is {shown(self.ways_each)}")

    def held_after(self, scene: Scene, group: str, held: frozenset[str]) -> frozenset[str]:
        return held_after_any(self.items, scene, group, held)

    def ways(self, search: TaskSearch, state: TaskState) -> Iterator[Way]:
        found: list[tuple[float, int, TaskState]] = []
        for place, item in enumerate(as_items(self.items)):
            enough = len(found) + self.ways_each
            for way in in_sequence(item, search, state):
                ended = way if isinstance(way, StageRefusal) else search.rested(way)
                if isinstance(ended, StageRefusal):
                    yield ended
                    continue
                assert not isinstance(way, StageRefusal)
                cost = self.cost(ended.segments[len(state.segments) :])
                found.append((number("cost", cost, infinite=True), place, way))
                if len(found) == enough:
                    break
        ranked = sorted(found, key=lambda one: one[0])
        for rank, (cost, place, way) in enumerate(ranked):
            choices = [(other, "rejected") for other in range(len(self.items))]
            for before, (each, other, _) in reversed([(n < rank, one) for n, one in enumerate(ranked)]):
                choices[other] = other, f"{'no plan after it' if before else 'not chosen'}, cost {each:.4g}"
            choices[place] = place, f"chosen, cost {cost:.4g}"
            yield from choosing([way], self.name, choices)


@dataclass(frozen=True, eq=False)
class Fallback(Value):
    """The first of several alternatives that can be planned."""

    items: Sequence[Item]
    name: str = ""
    default_name = "fallback"

    def __post_init__(self) -> None:
        object.__setattr__(self, "items", as_items(self.items))

    def held_after(self, scene: Scene, group: str, held: frozenset[str]) -> frozenset[str]:
        return held_after_any(self.items, scene, group, held)

    def ways(self, search: TaskSearch, state: TaskState) -> Iterator[Way]:
        for place, item in enumerate(as_items(self.items)):
            words = ["rejected"] * place + ["chosen"] + ["not chosen"] * len(self.items)
            choices = list(enumerate(words[: len(self.items)]))
            yield from choosing(in_sequence(item, search, state), self.name, choices)


@dataclass(frozen=True, eq=False)
class ForEach(Value):
    """Items in order, as the parts of a tray; a driven task skips those whose object is missing."""

    items: Sequence[Item]
    name: str = ""
    default_name = "for each"

    def __post_init__(self) -> None:
        object.__setattr__(self, "items", as_items(self.items))

    def held_after(self, scene: Scene, group: str, held: frozenset[str]) -> frozenset[str]:
        return held_after(_in_order(self.items), scene, group, held)

    def ways(self, search: TaskSearch, state: TaskState) -> Iterator[Way]:
        yield from in_sequence(_in_order(self.items), search, state)


@dataclass(frozen=True, eq=False)
class Within(Value):
    """Items in order, in a way within limits; the arm rests before and after them."""

    items: Sequence[Item]
    limits: StageLimits
    name: str = ""
    default_name = "within"

    def __post_init__(self) -> None:
        object.__setattr__(self, "items", as_items(self.items))
        one_of("limits", self.limits, StageLimits)

    def held_after(self, scene: Scene, group: str, held: frozenset[str]) -> frozenset[str]:
        for joint in self.limits.joints:
            scene.robot.index([joint])
        return held_after(_in_order(self.items), scene, group, held)

    def ways(self, search: TaskSearch, state: TaskState) -> Iterator[Way]:
        begun = search.rested(state)
        if isinstance(begun, StageRefusal):
            yield begun
            return
        for way in in_sequence(_in_order(self.items), search, begun):
            ended = way if isinstance(way, StageRefusal) else search.rested(way)
            if isinstance(ended, StageRefusal):
                yield ended
                continue
            own = ended.segments[len(begun.segments) :]
            if words := self.limits.broken(own, ended.time - begun.time):
                yield StageRefusal(self.name, Status.STAGE_LIMITS, words)
            else:
                yield ended


@dataclass(frozen=True, eq=False)
class Together(Value):
    """Groups that move together, as the arms of a robot with two: one motion of the group of the task.

    Each item has moves of one group in order. They are passed in their own times, in the order of a bound of
    these; the last of all is reached last, and groups that are done earlier wait.
    """

    items: Sequence[Item]
    name: str = ""
    default_name = "together"

    def __post_init__(self) -> None:
        items = as_items(self.items)
        object.__setattr__(self, "items", items)
        for number_of_item, item in enumerate(items, start=1):
            for stage in item:
                if not isinstance(stage, MoveTo):
                    raise ProblemError(f"item {number_of_item}: groups that move together have MoveTo only")
                if not stage.group or stage.group != self._group(item):
                    raise ProblemError(
                        f"item {number_of_item}: give every MoveTo the group that it moves, such as "
                        "MoveTo(goal, group='left_arm'), the same in all of an item"
                    )

    def held_after(self, scene: Scene, group: str, held: frozenset[str]) -> frozenset[str]:
        taken: dict[str, str] = {}
        for item in as_items(self.items):
            for joint in sorted(_joints(scene, self._group(item))):
                if joint in taken:
                    both = f"groups {shown(taken[joint])} and {shown(self._group(item))}"
                    raise ProblemError(
                        f"{both} have joint {shown(joint)} in common: they cannot move together"
                    )
                taken[joint] = self._group(item)
            held_after(item, scene, group, held)
        return held

    def ways(self, search: TaskSearch, state: TaskState) -> Iterator[Way]:
        for attempt in range(search.options.configurations):
            tracks = self._tracks(search, state, attempt)
            if isinstance(tracks, StageRefusal):
                yield tracks
                return
            yield self._passed(state, sorted(tracks, key=lambda each: each.time))

    def _tracks(self, search: TaskSearch, state: TaskState, attempt: int) -> "list[_Passed] | StageRefusal":
        """Return all moves, with the n-th nearest configurations; each group ends clear of those before."""
        scene, robot, others = state.scene, state.scene.robot, state.positions
        passed: list[_Passed] = []
        for item in as_items(self.items):
            rows = robot.index(robot.group(self._group(item)).joints)
            at, time, after = others, 0.0, ""
            for stage in item:
                assert isinstance(stage, MoveTo)
                found = stage.ends(search, scene, at)
                if isinstance(found, StageRefusal):
                    return found
                begin, at = at, found[attempt % len(found)]
                limits = reduce_model(scene, stage.group, at).limits
                time += float(travel_time(begin[rows], at[rows], limits, rests=False))
                passed.append(_Passed(stage, at[rows], time, after))
                after = stage.name
            others = at
        return passed

    def _passed(self, state: TaskState, moves: "Sequence[_Passed]") -> TaskState:
        robot, first = state.scene.robot, state.steps[-1] if state.steps else None
        before = first.stage if isinstance(first, Leg) else ""
        for each in moves:
            goal = np.array(state.positions)
            goal[robot.index(robot.group(each.move.group).joints)] = each.positions
            state = state.to(
                Leg(
                    each.move.name,
                    robot.followed(goal),
                    state.scene,
                    tuple(each.move.constraints),
                    part=each.move.group,
                    after=each.after or before,
                )
            )
        return state

    @staticmethod
    def _group(item: Sequence[TaskStage]) -> str:
        return str(getattr(item[0], "group", ""))


@dataclass(frozen=True, eq=False)
class _Passed:
    """A move among other groups' moves.

    Attributes:
        positions: Of its group, at its end (n,) [rad | m].
        time: Bound of the time of its end [s].
        after: The move of its group before; empty if none.
    """

    move: MoveTo
    positions: Floats
    time: float
    after: str
