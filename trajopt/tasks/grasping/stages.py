"""Stages of a gripper: fingers move, pick, place."""

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from trajopt.geometry.geometry import distance_from, gap, supports
from trajopt.planning.status import Status
from trajopt.problem.problem import PathConstraint
from trajopt.problem.requirements import Requirement, frame_placement
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.scene import Scene
from trajopt.tasks.grasping.grasp import Grasp, Place, Straight
from trajopt.tasks.grasping.gripper import Gripper, gripper_of, joints_moving
from trajopt.tasks.grasping.straight import along_line, track_line, up, vector_of
from trajopt.tasks.result import Handling
from trajopt.tasks.search import Leg, TaskSearch, TaskState, Way, check_frames, held_objects
from trajopt.tasks.sequence import NO_NAMES, CandidateNames, StageRefusal
from trajopt.values.arrays import Floats, Value, number, one_of, several
from trajopt.values.errors import ProblemError, shown
from trajopt.values.errors.arguments import checked
from trajopt.values.placement import Placement
from trajopt.values.printed import in_length

LET_GO = 0.02
"""Default opening of the fingers at release, beyond the opening before [m]."""
PRESSED = 1e-3
"""Largest depth of the fingers in an object that they hold, as of other accepted contacts, and largest
tolerance of a place that counts as exact [m | rad].
"""
STILL = 1e-6
"""Fingers nearer than this to their opening are not moved [rad | m]."""
MET = "pick and place need an object at rest; reach it by plan, with a goal relative to it"
"""Remedy for dynamic obstacles."""


@checked
@dataclass(frozen=True, eq=False)
class SetGripper(Value):
    """The fingers of a gripper move to an opening.

    Attributes:
        opening: Between the pads [m].
    """

    opening: float
    gripper: Gripper | None = None
    name: str = ""
    default_name = "gripper"

    def held_after(self, scene: Scene, group: str, held: frozenset[str]) -> frozenset[str]:
        hand_of(scene, self.gripper, group).joints_at(self.opening)
        return held

    def ways(self, search: TaskSearch, state: TaskState) -> Iterator[Way]:
        gripper = hand_of(state.scene, self.gripper, search.group)
        moved, held = fingers(state, gripper, self.opening, self.name), between_fingers(state.scene, gripper)
        if held and (depth := -distance_from(state.scene, held, gripper.fingers, moved.positions)) > PRESSED:
            words = f"the fingers would be {in_length(depth)} inside {shown(held)}, which they hold"
            yield StageRefusal(self.name, Status.GRIPPER_CANNOT, words)
            return
        yield moved


@checked
@dataclass(frozen=True, eq=False)
class PickObject(Value):
    """The gripper picks an object up: reach, approach, close and lift.

    Attributes:
        grasps: In order of preference.
        constraints: Requirements while it is lifted.
    """

    object: str
    grasps: Sequence[Grasp]
    gripper: Gripper | None = None
    constraints: Sequence[PathConstraint] = ()
    name: str = ""

    def __post_init__(self) -> None:
        if not several("grasps", self.grasps, Grasp):
            raise ProblemError(
                f"name at least one grasp of {shown(self.object)}; `grasps_of` finds none if the object is "
                "wider or narrower than the gripper opens, or has no opposite sides"
            )

    @property
    def default_name(self) -> str:
        return f"pick {self.object}"

    def held_after(self, scene: Scene, group: str, held: frozenset[str]) -> frozenset[str]:
        scene.object(self.object)
        _check_moved(scene, hand_of(scene, self.gripper, group), group)
        for frame in (line.frame for grasp in self.grasps for line in (grasp.approach, grasp.lift)):
            scene.holder(frame)
        check_frames(scene, self.constraints)
        if self.object in held:
            raise ProblemError(f"object {shown(self.object)} is in a hand already: place or detach it first")
        if self.object in scene.changing:
            raise ProblemError(
                f"object {shown(self.object)} moves by itself, or is there for a time only; {MET}"
            )
        return held | {self.object}

    def ways(self, search: TaskSearch, state: TaskState) -> Iterator[Way]:
        gripper = hand_of(state.scene, self.gripper, search.group)
        if full := between_fingers(state.scene, gripper):
            words = f"the gripper holds {shown(full)} already: place or detach it first"
            yield StageRefusal(self.name, Status.GRIPPER_CANNOT, words)
            return
        for given in self.grasps:
            yield from self._by(given, gripper, search, state)

    def _by(self, given: Grasp, gripper: Gripper, search: TaskSearch, state: TaskState) -> Iterator[Way]:
        grasp = replace(given, approach=_blended(given.approach, search), lift=_blended(given.lift, search))
        scene, tool, names = state.scene, gripper.tool, CandidateNames(grasp.name, object=self.object)
        refused = partial(_refused, self.name, names)
        if grasp.opening > gripper.widest or grasp.width < gripper.narrowest or grasp.force > gripper.force:
            yield refused(
                "open",
                Status.GRIPPER_CANNOT,
                f"needs {grasp.opening * 1e3:.1f} mm, closing to {grasp.width * 1e3:.1f} mm with "
                f"{grasp.force:g} N; the gripper has {gripper.narrowest * 1e3:.1f} to "
                f"{gripper.widest * 1e3:.1f} mm and {gripper.force:g} N",
            )
            return
        start = gripper.opened(scene.robot, state.positions, grasp.opening)
        reduced = search.reduced(scene, start)
        stands = scene.placement_of(self.object, start)
        if meets := hand_meets(reduced, gripper.links, tool, stands * grasp.placement):
            words = f"{meets} at the object, wherever the arm is"
            yield refused("reach", Status.GOAL_IN_COLLISION, words)
            return
        closed = search.reduced(
            pressing(scene, gripper, self.object), gripper.opened(scene.robot, start, grasp.width)
        )
        if meets := hand_meets(closed, gripper.links, tool, stands * grasp.placement):
            yield refused("close", Status.GOAL_IN_COLLISION, f"{meets}, wherever the arm is")
            return
        goal = frame_placement(tool, stands * grasp.placement)
        found = search.configurations(reduced, (goal,), f"{self.name}: reach", names, same=(given,))
        if isinstance(found, StageRefusal):
            yield found
            return
        for at in found[: search.options.configurations]:
            there = reduced.all_positions(at)
            usual = scene.placement_of(tool, there).rotation @ gripper.approach
            way = vector_of(grasp.approach, scene, there, usual)
            approach = track_line(reduced, tool, at, -way, search.tracker)
            if approach.status is not None:
                yield refused("approach", approach.status, approach.reason)
                continue
            closed = gripper.opened(scene.robot, there, grasp.width)
            held = scene.attach(self.object, tool, at=closed, touch_links=gripper.links)
            carrying = search.reduced(held, closed)
            way = vector_of(grasp.lift, scene, there, up(scene))
            lift = track_line(carrying, tool, at, way, search.tracker)
            if lift.status is not None:
                yield refused("lift", lift.status, lift.reason)
                continue
            before, lifted = reduced.all_positions(approach.end), carrying.all_positions(lift.end)
            yield self._picked(grasp, gripper, search, state, held, before, there, lifted)

    def _picked(
        self,
        grasp: Grasp,
        gripper: Gripper,
        search: TaskSearch,
        state: TaskState,
        held: Scene,
        before: Floats,
        at: Floats,
        lifted: Floats,
    ) -> TaskState:
        scene, tool, names = state.scene, gripper.tool, CandidateNames(grasp.name, object=self.object)
        opened = fingers(state, gripper, grasp.opening, f"{self.name}: open", names=names)
        line = along_line(scene, before, at, tool, search.options)
        there = opened.to(Leg(f"{self.name}: reach", before, scene, names=names)).to(
            Leg(f"{self.name}: approach", at, scene, line, near=at, names=names)
        )
        rest, name = search.options.grip_time, f"{self.name}: close"
        closed = fingers(there, gripper, grasp.width, name, meets=self.object, rest=rest, names=names)
        stood_on = supports(scene, self.object, scene.placement_of(self.object, at))
        lifting = lifting_scene(held, self.object, stood_on, search.options.contact_time)
        line = along_line(held, closed.positions, lifted, tool, search.options)
        handling = Handling(scene, gripper, self.name, grasp)
        handled = {**state.handled, self.object: (*state.handled.get(self.object, ()), handling)}
        return replace(closed, scene=held, handled=handled).to(
            Leg(
                f"{self.name}: lift",
                lifted,
                lifting,
                (*line, *self.constraints),
                near=closed.positions,
                names=names,
            )
        )


@checked
@dataclass(frozen=True, eq=False)
class PlaceObject(Value):
    """The gripper puts the object in its hand down: carry, lower, release and retreat.

    Attributes:
        places: In order of preference.
        gripper: If None, the one that picked the object.
        constraints: Requirements while it is carried and lowered.
        opening: Of the fingers at release [m]; if None, as in the grasp, or 2 cm more than before the stage
            if the object was not grasped, or the largest possible.
    """

    object: str
    places: Place | Sequence[Place]
    gripper: Gripper | None = None
    constraints: Sequence[PathConstraint] = ()
    name: str = ""
    opening: float | None = None

    def __post_init__(self) -> None:
        given = (self.places,) if isinstance(self.places, Place) else several("places", self.places, Place)
        if not given:
            raise ProblemError(f"name at least one place to put {self.object}")
        object.__setattr__(self, "places", given)
        if self.opening is not None:
            number("opening", self.opening)

    @property
    def default_name(self) -> str:
        return f"place {self.object}"

    def held_after(self, scene: Scene, group: str, held: frozenset[str]) -> frozenset[str]:
        scene.object(self.object)
        if self.gripper is not None or self.object in held_objects(scene):
            _check_moved(scene, hand_of(scene, self.gripper, group), group)
        check_frames(scene, self.constraints)
        assert not isinstance(self.places, Place)
        for place in self.places:
            for frame in (place.frame, place.lower.frame, place.retreat.frame):
                scene.holder(frame)
            if place.frame == self.object:
                raise ProblemError(f"place {shown(place.name)} of {shown(self.object)} is on itself")
            if (carrier := scene.carrier(place.frame)) is not None:
                raise ProblemError(
                    f"place {shown(place.name)} is on {shown(carrier)}, which moves by itself; {MET}"
                )
        if self.object not in held:
            raise ProblemError(f"object {shown(self.object)} is not in a hand: pick it before, or attach it")
        return held - {self.object}

    def ways(self, search: TaskSearch, state: TaskState) -> Iterator[Way]:
        picked = _unfinished(state, self.object)[1]
        hand = picked.gripper if self.gripper is None and picked is not None else self.gripper
        gripper = hand_of(state.scene, hand, search.group)
        reduced, link = search.reduced(state.scene, state.positions), state.scene.holder(self.object).link
        beside = reduced.attachment(link)[0] == reduced.attachment(gripper.tool)[0]
        if not beside and link not in gripper.links:
            words = f"{shown(gripper.tool)} does not hold {shown(self.object)}: name the gripper that does"
            yield StageRefusal(self.name, Status.GRIPPER_CANNOT, words)
            return
        assert not isinstance(self.places, Place)
        for given in self.places:
            yield from self._at(given, gripper, search, state)

    def _at(self, given: Place, gripper: Gripper, search: TaskSearch, state: TaskState) -> Iterator[Way]:
        place = replace(given, lower=_blended(given.lower, search), retreat=_blended(given.retreat, search))
        held, start, tool = state.scene, state.positions, gripper.tool
        handling = replace(_handling(state, self.object, gripper), place=place)
        names = _names(handling, self.object)
        refused = partial(_refused, self.name, names)
        stands_on = supports(held, self.object, held.placement_of(place.frame, start) * place.placement)
        lowering = lowering_scene(held, self.object, stands_on, search.options.contact_time)
        reduced, carrying = search.reduced(lowering, start), search.reduced(held, start)
        kept = (item for item in self.constraints if isinstance(item, Requirement))
        wanted = (place.requirement(self.object), *kept)
        exact = max(np.max(wanted[0].position_tolerance), np.max(wanted[0].rotation_tolerance)) <= PRESSED
        there = held.placement_of(place.frame, start) * place.placement
        owners = {self.object, *gripper.links}
        if exact and (meets := hand_meets(reduced, owners, self.object, there)):
            yield refused("lower", Status.GOAL_IN_COLLISION, f"{meets} at the place, wherever the arm is")
            return
        in_hand = held if handling.grasp is None else handling.grasp.placement.homogeneous.tobytes()
        found = search.configurations(
            reduced, wanted, f"{self.name}: lower", names, same=(given, in_hand), moved=self.object
        )
        if isinstance(found, StageRefusal):
            yield found
            return
        opening = self._opening(gripper, handling, state)
        let_go = pressing(held.detach(self.object, at=start), gripper, self.object).move(self.object, there)
        released = search.reduced(let_go, gripper.opened(held.robot, start, opening))
        hand = there * held.placement_of(self.object, start).inverse() * held.placement_of(tool, start)
        if exact and (meets := hand_meets(released, gripper.links, tool, hand)):
            yield refused("release", Status.GOAL_IN_COLLISION, f"{meets}, wherever the arm is")
            return
        for at in found[: search.options.configurations]:
            there = reduced.all_positions(at)
            down = vector_of(place.lower, held, there, -up(held))
            lower = track_line(carrying, tool, at, -down, search.tracker)
            if lower.status is not None:
                yield refused("lower", lower.status, lower.reason)
                continue
            put = held.detach(self.object, at=there)
            opened = gripper.opened(held.robot, there, opening)
            leaving = search.reduced(put, opened)
            usual = -(put.placement_of(tool, opened).rotation @ gripper.approach)
            way = vector_of(place.retreat, put, opened, usual)
            retreat = track_line(leaving, tool, at, way, search.tracker)
            if retreat.status is not None:
                yield refused("retreat", retreat.status, retreat.reason)
                continue
            above, away = reduced.all_positions(lower.end), leaving.all_positions(retreat.end)
            rows = above, there, opened, away
            yield self._placed(place, gripper, search, state, (lowering, put), rows, opening)

    def _placed(
        self,
        place: Place,
        gripper: Gripper,
        search: TaskSearch,
        state: TaskState,
        scenes: tuple[Scene, Scene],
        rows: tuple[Floats, Floats, Floats, Floats],
        opening: float,
    ) -> TaskState:
        (lowering, put), (above, there, opened, away) = scenes, rows
        held, carried, options, tool = state.scene, tuple(self.constraints), search.options, gripper.tool
        handling = replace(_handling(state, self.object, gripper), place=place, placed=self.name)
        names = _names(handling, self.object)
        line = along_line(held, above, there, tool, options)
        lowered = (
            state.to(Leg(f"{self.name}: carry", above, held, carried, names=names))
            .to(Leg(f"{self.name}: lower", there, lowering, (*line, *carried), near=there, names=names))
            .rest(options.release_time)
        )
        before = _unfinished(state, self.object)[0]
        handled = {**state.handled, self.object: (*before, handling)}
        lowered = replace(lowered, scene=put, handled=handled)
        name = f"{self.name}: release"
        released = fingers(lowered, gripper, opening, name, meets=self.object, names=names)
        line = along_line(put, opened, away, tool, options)
        return released.to(Leg(f"{self.name}: retreat", away, put, line, near=opened, names=names))

    def _opening(self, gripper: Gripper, handling: Handling, state: TaskState) -> float:
        opening = self.opening
        if opening is None and handling.grasp is not None:
            opening = handling.grasp.opening
        if opening is None:
            opening = gripper.opening_at(state.scene.robot, state.positions) + LET_GO
        return min(opening, gripper.widest)


def between_fingers(scene: Scene, gripper: Gripper) -> str:
    """Return an attached object that all fingers of a gripper may touch, "" for none."""
    held = sorted(held_objects(scene))
    return next((name for name in held if scene.object(name).touch_links >= {*gripper.fingers}), "")


def lifting_scene(held: Scene, name: str, supports: Sequence[str], seconds: float) -> Scene:
    """Return the scene in which a held object may touch its supports at first, for a time [s]."""
    for support in supports:
        held = held.allow_contact(f"{name} stood on {support}", name, support, first=seconds)
    return held


def lowering_scene(held: Scene, name: str, supports: Sequence[str], seconds: float) -> Scene:
    """Return the scene in which a held object may touch its supports at last, for a time [s]."""
    for support in supports:
        held = held.allow_contact(f"{name} stands on {support}", name, support, last=seconds)
    return held


def pressing(scene: Scene, gripper: Gripper, name: str) -> Scene:
    """Return the scene in which the fingers may touch an object."""
    for finger in gripper.fingers:
        scene = scene.allow(finger, name)
    return scene


def hand_meets(reduced: ReducedModel, owners: Collection[str], frame: str, at: Placement) -> str:
    """Return which of the bodies fixed to a frame overlaps an object if the frame is at a placement.

    The arm is ignored; "" for none. Attached objects may be in contact.
    """
    scene = reduced.scene
    joint, held = reduced.attachment(frame)
    hand = at * held.inverse()
    links = [body for body in reduced.bodies if body.owner in owners and body.joint == joint]
    others = [body for body in reduced.bodies if body.joint == 0 and body.owner not in scene.robot.links]
    for body in sorted(links, key=lambda each: each.owner in scene.robot.links):  # attached objects first
        least = 0.0 if body.owner in scene.robot.links else -PRESSED
        for other in others:
            if scene.may_touch(body.owner, other.owner):
                continue
            if gap(hand * body.placement, body.shape, other.placement, other.shape) < least:
                return f"{body.owner} is inside {other.owner}"
    return ""


def fingers(
    state: TaskState,
    gripper: Gripper,
    opening: float,
    name: str,
    *,
    meets: str = "",
    rest: float = 0.0,
    names: CandidateNames = NO_NAMES,
) -> TaskState:
    """Return the state after the fingers moved to an opening [m], while the arm rests.

    Args:
        rest: Time after it, for which the arm rests too [s].
    """
    scene = state.scene
    goal = gripper.opened(scene.robot, state.positions, opening)
    if np.abs(goal - state.positions).max() < STILL:
        return state.rest(rest, name) if rest > 0.0 else state
    scene = pressing(scene, gripper, meets) if meets else scene
    scene = replace(scene, margin=0.0, pair_margins={}, kind_margins={})
    return state.rest().to(Leg(name, goal, scene, group=gripper.group, names=names)).rest(rest)


def _handling(state: TaskState, name: str, gripper: Gripper) -> Handling:
    begun = _unfinished(state, name)[1]
    return Handling(state.scene, gripper) if begun is None else begun


def _unfinished(state: TaskState, name: str) -> tuple[tuple[Handling, ...], Handling | None]:
    """Return how an object was handled before, and the pick without a place yet."""
    handled = state.handled.get(name, ())
    return (handled[:-1], handled[-1]) if handled and not handled[-1].placed else (handled, None)


def _names(handling: Handling, name: str) -> CandidateNames:
    grasp, place = handling.grasp, handling.place
    return CandidateNames("" if grasp is None else grasp.name, "" if place is None else place.name, name)


def _blended(line: Straight, search: TaskSearch) -> Straight:
    return replace(line, distance=max(line.distance - search.blend, 0.5 * line.distance))


def hand_of(scene: Scene, given: Gripper | None, group: str) -> Gripper:
    """Return a given gripper, or the one of the SRDF that a group moves."""
    if given is None:
        return gripper_of(scene, group=group)
    mimics = scene.robot.mimics
    for name in one_of("gripper", given, Gripper).joint_names:
        if name in mimics:
            raise ProblemError(
                f"joint {name} of the gripper follows {mimics[name].source} and has no motor: leave it out"
            )
    return given


def _check_moved(scene: Scene, gripper: Gripper, group: str) -> None:
    """Refuse a gripper that a group does not move."""
    robot, link = scene.robot, scene.holder(gripper.tool).link
    if group and not joints_moving(robot, link) & {*robot.group(group).joints}:
        raise ProblemError(
            f"no joint of group {shown(group)} moves {shown(gripper.tool)}, the gripper's tool"
        )


def _refused(stage: str, names: CandidateNames, step: str, status: Status, reason: str) -> StageRefusal:
    return StageRefusal(f"{stage}: {step}", status, reason, names=names)
