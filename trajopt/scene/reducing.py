"""Reduce a scene to a group's free joints, alone or among dynamic obstacles."""

import copyreg
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import permutations
from math import inf
from typing import Any

import numpy as np
import pinocchio as pin

from trajopt.robot.joints import WORLD_ANCHOR, Anchor, FixedBody, JointLimits
from trajopt.robot.loading.groups import Group
from trajopt.robot.loading.mimics import followed_limits
from trajopt.robot.loading.pinocchio_model import (
    ModelData,
    chain_lengths,
    distinct_links,
    model_data,
    model_of,
    named_again,
)
from trajopt.robot.robot import Robot
from trajopt.scene.clearances import (
    ROOM,
    AllowedCollisions,
    Clearances,
    ContactAllowance,
    PairKind,
    Part,
    kept,
)
from trajopt.scene.model_error import approaches
from trajopt.scene.reduced import BodyPairs, CollisionModel, DrivenJoints, ReducedModel, TimedModel
from trajopt.scene.scene import DEFAULT_MARGIN, Scene
from trajopt.scene.scene_object import AnchoredObject, SceneObject
from trajopt.scene.track import STEADY, Prediction, Timing, Track
from trajopt.values.arrays import Bools, Floats, Ints, Printed, readonly
from trajopt.values.cached import LruCache, cached_in_value, cached_per_value
from trajopt.values.errors import ModelError, shown
from trajopt.values.errors.arguments import checked
from trajopt.values.placement import IDENTITY, WORLD, Placement
from trajopt.values.shapes.shapes import Plane, bounding_sphere
from trajopt.values.trajectory import refined


@dataclass(frozen=True, eq=False)
class AddedJoints:
    """Joints added to a model, and the frame that each track moves, by its name."""

    joints: DrivenJoints
    anchors: Mapping[str, Anchor]


def add_driven(model: pin.Model, tracks: Mapping[str, Track]) -> AddedJoints:
    """Add joints to a model that move frames along tracks."""
    names: list[str] = []
    anchors: dict[str, Anchor] = {}
    moved: list[tuple[Floats, Floats]] = []
    for name, track in tracks.items():
        at, turned, angles = 0, pin.SE3(np.eye(3), np.zeros(3)), list[Floats]()
        for axis, direction in zip("xyz", np.eye(3).tolist(), strict=True):
            names.append(f"{name} along {axis}")
            at = model.addJoint(at, pin.JointModelPrismaticUnaligned(*direction), turned, names[-1])
        turned = pin.SE3(track.rotations[0], np.zeros(3))
        for piece, angle in _turns(track):
            names.append(f"{name} turning in piece {piece}")
            joint = pin.JointModelRevoluteUnaligned(*track.axes[piece].tolist())
            at = model.addJoint(at, joint, turned, names[-1])
            turned = pin.SE3(np.eye(3), np.zeros(3))
            angles.append(angle)
        anchors[name] = Anchor(at, Placement(readonly(turned.rotation.copy())))
        moved.append((track.times, _columns(track.coefficients, angles)))
    return AddedJoints(_joined(tuple(names), moved), anchors)


def _turns(track: Track) -> list[tuple[int, Floats]]:
    found: list[tuple[int, Floats]] = []
    lengths = np.diff(track.times)
    for piece, rate in enumerate(track.rates.tolist()):
        if abs(rate) <= STEADY:
            continue
        angle = np.zeros((2, len(lengths)))
        angle[0, piece] = rate
        angle[1, piece + 1 :] = rate * lengths[piece]
        found.append((piece, angle))
    return found


def _columns(slides: Floats, angles: list[Floats]) -> Floats:
    columns = [slides, *(angle[:, :, None] for angle in angles)]
    degree = max(len(column) for column in columns)
    return np.concatenate([np.pad(c, ((degree - len(c), 0), (0, 0), (0, 0))) for c in columns], axis=2)


def _joined(names: tuple[str, ...], moved: list[tuple[Floats, Floats]]) -> DrivenJoints:
    if not moved:
        return DrivenJoints(names, readonly(np.array((0.0, 1.0))), readonly(np.zeros((1, 1, 0))))
    times = np.unique(np.concatenate([track_times for track_times, _ in moved]))
    degree = max(len(coefficients) for _, coefficients in moved)
    columns = [refined(times, *each, degree) for each in moved]
    return DrivenJoints(names, readonly(times), readonly(np.concatenate(columns, axis=2)))


@dataclass(frozen=True, eq=False)
class ReducedRobot:
    """A robot with only one group's joints free.

    Attributes:
        anchors: Carrying joint and placement of links, tool frames and the world, by name.
        driven: Joints driven by time, which carry dynamic obstacles; None to leave these out.
    """

    model: pin.Model
    joint_names: tuple[str, ...]
    limits: JointLimits
    mimic_matrix: Floats
    mimic_offset: Floats
    anchors: Mapping[str, Anchor]
    bodies: tuple[FixedBody, ...]
    driven: DrivenJoints | None = None


def reduce_robot(robot: Robot, group: str, start: Floats) -> ReducedRobot:
    joints = robot.group(group).joints
    free = {*joints, *(name for name, mimic in robot.mimics.items() if mimic.source in joints)}
    locked = [place for place, name in enumerate(robot.joint_names) if name not in free]
    key = (group, tuple(start[locked].tolist()))
    return _reductions(robot).get(key, lambda: _reduced(robot, joints, locked, start))


@cached_per_value
def _reductions(robot: Robot) -> LruCache[tuple[str, tuple[float, ...]], ReducedRobot]:
    del robot
    return LruCache(8)


def _reduced(robot: Robot, joints: tuple[str, ...], locked: list[int], start: Floats) -> ReducedRobot:
    fixed = [place + 1 for place in locked]  # pinocchio counts the universe as joint 0
    whole = distinct_links(robot.model)  # Pinocchio looks frames up by name alone.
    model = named_again(pin.buildReducedModel(whole, fixed, robot.configuration(start)))
    names = tuple(model.names[1:])
    mimic_matrix, mimic_offset = np.zeros((len(names), len(joints))), np.zeros(len(names))
    for row, name in enumerate(names):
        if name in joints:
            mimic_matrix[row, joints.index(name)] = 1.0
        else:
            mimic = robot.mimics[name]
            mimic_matrix[row, joints.index(mimic.source)] = mimic.multiplier
            mimic_offset[row] = mimic.offset
    anchors = _anchors(model, robot)
    return ReducedRobot(
        model,
        joints,
        followed_limits(robot.limits, joints, robot.mimics),
        readonly(mimic_matrix),
        readonly(mimic_offset),
        anchors,
        tuple(
            FixedBody(body.name, body.owner, at.joint, at.placement * body.placement, body.shape)
            for body in robot.bodies
            for at in (anchors[body.frame],)
        ),
    )


def _anchors(model: pin.Model, robot: Robot) -> Mapping[str, Anchor]:
    anchors = {WORLD: WORLD_ANCHOR}
    for frame in model.frames:
        if frame.type == pin.FrameType.BODY:
            where = frame.placement
            anchors[frame.name] = Anchor(
                int(frame.parentJoint),
                Placement(readonly(where.rotation.copy()), readonly(where.translation.copy())),
            )
    for name, frame in robot.frames.items():
        link = anchors[frame.link]
        anchors[name] = Anchor(link.joint, link.placement * frame.placement)
    return anchors


def _pickled(reduced: ReducedModel) -> tuple[Callable[..., ReducedModel], tuple[Any, ...]]:
    robot = reduce_robot(reduced.scene.robot, reduced.group, reduced.start)
    loaded = None if reduced.model is robot.model else model_data(reduced.model)
    return _again, (reduced.scene, reduced.group, reduced.start, loaded)


def _again(scene: Scene, group: str, start: Floats, loaded: ModelData | None) -> ReducedModel:
    reduced = reduce_model(scene, group, start)
    return reduced if loaded is None else replace(reduced, model=model_of(loaded))


copyreg.pickle(ReducedModel, _pickled)


@checked
def reduce_model(scene: Scene, group: str, start: Floats) -> ReducedModel:
    """Fix every joint outside the group at its start position; mimic joints follow.

    Args:
        start: Positions of all joints, shape (number of joints,) [rad | m].

    Raises:
        GroupNotFound: If the robot has no such group.
        MimicOutOfRange: If no position of a joint keeps one that follows it within its limits.
    """
    start = scene.robot.followed(start)
    robot = reduce_robot(scene.robot, group, start)
    collision_model = collision_model_of(scene, robot)
    return ReducedModel(
        scene,
        group,
        start,
        robot.model,
        robot.joint_names,
        robot.limits,
        robot.mimic_matrix,
        robot.mimic_offset,
        collision_model,
        timed_model,
    )


def tool_frame(reduced: ReducedModel) -> str:
    """Return the name of the frame that represents the group's motion.

    A tool frame on the joint of the tip link if there is one: the last of the scene, else the first of the
    robot; else the link there whose origin is farthest from the joint. A group without a tip link ends at the
    body of its last joint.
    """
    tip = reduced.scene.robot.group(reduced.group).tip
    last = reduced.model.getJointId(reduced.joint_names[-1])
    return _tool_on(reduced, last if tip is None else reduced.attachment(tip)[0])


def tool_frames(reduced: ReducedModel) -> tuple[str, ...]:
    """Return one frame for each tool that a group moves: `tool_frame`, or one at the end of each branch."""
    if reduced.scene.robot.group(reduced.group).tip is not None:
        return (tool_frame(reduced),)
    joints = [reduced.model.getJointId(name) for name in reduced.joint_names]
    before: set[int] = set()
    for joint in joints:
        parent = int(reduced.model.parents[joint])
        while parent:
            before.add(parent)
            parent = int(reduced.model.parents[parent])
    return tuple(_tool_on(reduced, joint) for joint in joints if joint not in before)


def _tool_on(reduced: ReducedModel, carrier: int) -> str:
    robot = reduced.scene.robot
    tip = robot.group(reduced.group).tip
    for name in (*reversed(tuple(reduced.scene.tools)), *robot.frames):
        if reduced.attachment(name)[0] == carrier:
            return name
    reach: dict[str, float] = {}
    for name in (*((tip,) if tip is not None else ()), *robot.links):
        joint, where = reduced.attachment(name)
        if joint == carrier:
            # Of equals the first stays: the tip link.
            reach.setdefault(name, round(float(np.linalg.norm(where.translation)), 9))
    return max(reach, key=lambda name: reach[name])


def tool_point(reduced: ReducedModel, frame: str, positions: Floats) -> Floats:
    """Return the origin of a frame for the group's positions (n,), shape (3,) in the world [m]."""
    return reduced.scene.placement_of(frame, reduced.all_positions(positions)).translation


WHOLE = "all that is simulated"
"""Name of the temporary group."""


def driven_joints(robot: Robot) -> tuple[str, ...]:
    """Return the joints with motors: all that do not mimic another."""
    return tuple(name for name in robot.joint_names if name not in robot.mimics)


def whole_robot(scene: Scene, joints: tuple[str, ...], start: Floats) -> ReducedModel:
    """Return the reduced model with these joints of a robot free; start as for `reduce_model`."""
    robot = scene.robot
    if WHOLE in robot.groups:
        raise ModelError(f"robot {shown(robot.name)} has a group {shown(WHOLE)}, a reserved name; rename it")
    group = Group(WHOLE, joints, robot.links, None)
    wider = replace(robot, groups={**robot.groups, WHOLE: group})
    return reduce_model(replace(scene, robot=wider), WHOLE, start)


def timed_model(reduced: ReducedModel) -> TimedModel | None:
    scene = reduced.scene
    if not scene.changing:
        return None
    robot = reduce_robot(scene.robot, reduced.group, reduced.start)
    return _timed_models(scene).get(robot, lambda: _built(reduced, robot))


@cached_in_value
def _timed_models(scene: Scene) -> LruCache[ReducedRobot, TimedModel]:
    del scene  # the models refer to it
    return LruCache(4)


def _built(reduced: ReducedModel, robot: ReducedRobot) -> TimedModel:
    scene, model = reduced.scene, robot.model.copy()
    timings = {name: _timing(scene, name) for name in scene.changing}
    tracks = {
        name: motion.track for name in timings if (motion := scene.objects[name].timing.motion) is not None
    }
    drive = add_driven(model, tracks)
    extended = replace(
        robot,
        model=model,
        joint_names=(*robot.joint_names, *drive.joints.names),
        limits=_unlimited(robot.limits, drive.joints.names),
        mimic_matrix=_beside(robot.mimic_matrix, len(drive.joints.names)),
        mimic_offset=readonly(np.append(robot.mimic_offset, np.zeros(len(drive.joints.names)))),
        anchors={**robot.anchors, **drive.anchors},
        driven=drive.joints,
    )
    among = ReducedModel(
        scene,
        reduced.group,
        reduced.start,
        extended.model,
        extended.joint_names,
        extended.limits,
        extended.mimic_matrix,
        extended.mimic_offset,
        collision_model_of(scene, extended),
        _nothing_else,
    )
    return TimedModel(among, drive.joints, timings)


def _nothing_else(timed: ReducedModel) -> None:
    del timed


def _timing(scene: Scene, name: str) -> Timing:
    carrier = scene.carrier(name)
    motion: Prediction | None = None if carrier is None else scene.objects[carrier].timing.motion
    return replace(scene.objects[name].timing, motion=motion)


def _unlimited(limits: JointLimits, names: tuple[str, ...]) -> JointLimits:
    wide = np.full(len(names), np.inf)
    fields = ("upper", "velocity", "acceleration", "jerk", "effort")
    wider = {name: readonly(np.append(getattr(limits, name), wide)) for name in fields}
    lower = readonly(np.append(limits.lower, -wide))
    return replace(limits, joint_names=(*limits.joint_names, *names), lower=lower, **wider)


def _beside(matrix: Floats, count: int) -> Floats:
    rows, columns = matrix.shape
    whole = np.zeros((rows + count, columns + count))
    whole[:rows, :columns] = matrix
    whole[rows:, columns:] = np.eye(count)
    return readonly(whole)


@dataclass(frozen=True, eq=False)
class ChangingPairs(Printed):
    """The pairs with a dynamic obstacle; temporary contacts are left to the judge.

    Attributes:
        changes: Whether a body of the pair changes with time, shape (p,).
        required: Required clearance, shape (p,) [m].
        errors: Radius, velocity and acceleration of the error, shape (p, 3).
        appears: Time from which both exist, shape (p,) [s].
        expires: Time until which both exist, shape (p,) [s].
    """

    changes: Bools
    required: Floats
    errors: Floats
    appears: Floats
    expires: Floats

    @staticmethod
    def of(timed: TimedModel) -> "ChangingPairs":
        """Return the pairs of a timed model; computed once for each."""
        return _of(timed)

    def error_at(self, time: Floats | float, pair: Ints | slice) -> Floats:
        """Bound the errors of the tracks of pairs at times [m]."""
        radius, velocity, acceleration = self.errors[pair].T
        return radius + velocity * time + acceleration * np.square(time) / 2.0


@cached_per_value
def _of(timed: TimedModel) -> ChangingPairs:
    pairs, bodies = timed.reduced.pairs, timed.reduced.bodies
    count = len(pairs.first)
    changes, errors = np.zeros(count, dtype=np.bool_), np.zeros((count, 3))
    appears, expires = np.full(count, -inf), np.full(count, inf)
    for pair, both in enumerate(zip(pairs.first.tolist(), pairs.second.tolist(), strict=True)):
        for body in both:
            timing = timed.timings.get(bodies[int(body)].owner)
            if timing is not None:
                changes[pair] = True
                errors[pair] += (0.0, 0.0, 0.0) if timing.motion is None else timing.motion.error
                appears[pair] = max(appears[pair], timing.appears)
                expires[pair] = min(expires[pair], timing.expires)
    changes[[pair for pair, _ in pairs.allowances]] = False
    for shared in (changes, errors, appears, expires):
        shared.setflags(write=False)
    return ChangingPairs(changes, pairs.required, errors, appears, expires)


@dataclass(frozen=True)
class ContactRules:
    """The contact rules of a scene.

    Attributes:
        touch_links: Links that may touch an object, by object; objects without any may be missing.
        kind_margins: Margins of kinds of pairs that differ [m].
        carriers: The link that carries each attached object, by object.
        parts: Role of each link and object; may be empty if no kind of pairs differs.
        robot_joints: Number of the robot's joints, the world included; the others are driven by time.
    """

    allowed: AllowedCollisions
    touch_links: Mapping[str, frozenset[str]]
    margin: float
    pair_margins: Mapping[frozenset[str], float]
    kind_margins: Mapping[PairKind, float]
    clearances: Clearances
    carriers: Mapping[str, str]
    parts: Mapping[str, Part]
    allowances: tuple[ContactAllowance, ...]
    robot_joints: int


def body_pairs(bodies: Sequence[FixedBody], links: Iterable[str], rules: ContactRules) -> BodyPairs:
    """List the pairs that must keep apart, ordered by their second body, then by the first."""
    owners = _Owners(bodies, frozenset(links), rules)
    part = owners.of_body
    rows = np.flatnonzero(owners.row[part] >= 0)
    own = owners.row[part[rows]]
    apart = ~owners.fixed & ~owners.excused
    # Between two owners that both have a row, each pair is met twice: it counts where it is in order.
    once = (owners.row[part] < 0)[None, :] | (rows[:, None] < np.arange(len(bodies)))
    at, other = np.nonzero(apart[own][:, part] & once)
    one = rows[at]
    first, second = np.minimum(one, other), np.maximum(one, other)
    order = np.argsort(second * len(bodies) + first)
    required, margin = (
        values[own[at], part[other]][order] for values in (owners.required(rules), owners.margins(rules))
    )
    margin = np.where(required > 0.0, np.maximum(margin, required + ROOM), margin)
    first, second = first[order], second[order]
    for array in (first, second):
        array.flags.writeable = False
    return BodyPairs(
        first,
        second,
        readonly(margin),
        readonly(required),
        readonly(np.zeros(len(first))),
        owners.allowances(rules.allowances, part[first], part[second]),
        owners.immobile(),
    )


class _Owners:
    """Links and objects that own bodies; a row for each paired with all others."""

    def __init__(self, bodies: Sequence[FixedBody], links: frozenset[str], rules: ContactRules) -> None:
        self._links = links
        joints = {body.owner: body.joint for body in bodies}
        self.names = tuple(joints)
        self._index = {name: place for place, name in enumerate(self.names)}
        self.of_body = np.array([self._index[body.owner] for body in bodies], dtype=np.int64)
        joint = np.array(list(joints.values()), dtype=np.int64)
        carried = (joint != 0) & (joint < rules.robot_joints)
        active = carried | np.array([name in links for name in self.names], dtype=np.bool_)
        self._of_row: Ints = np.flatnonzero(active)
        self.row: Ints = np.where(active, np.cumsum(active) - 1, -1)
        self.fixed: Bools = joint[self._of_row][:, None] == joint
        self.excused = self._excused(rules)

    def margins(self, rules: ContactRules) -> Floats:
        return self._entered(self._by_kind(rules.margin, rules.kind_margins, rules), rules.pair_margins)

    def _by_kind(self, every: float, kinds: Mapping[PairKind, float], rules: ContactRules) -> Floats:
        if not kinds:
            return np.full(self.excused.shape, every)
        order = tuple(Part)
        table = np.array([[kept(every, kinds, one, other) for other in order] for one in order])
        code = np.array([order.index(rules.parts[name]) for name in self.names], dtype=np.int64)
        return table[code[self._of_row]][:, code]

    def required(self, rules: ContactRules) -> Floats:
        clearances = rules.clearances
        values = self._by_kind(clearances.everywhere, clearances.kinds, rules)
        holders = [name if name in self._links else rules.carriers.get(name, WORLD) for name in self.names]
        least = np.array([clearances.links.get(holder, 0.0) for holder in holders])
        standing = np.array([holder == WORLD for holder in holders], dtype=np.bool_)
        values[:, standing] = np.maximum(values[:, standing], least[self._of_row][:, None])
        return self._entered(values, clearances.pairs)

    def allowances(
        self, allowances: tuple[ContactAllowance, ...], first: Ints, second: Ints
    ) -> tuple[tuple[int, ContactAllowance], ...]:
        found: list[tuple[int, ContactAllowance]] = []
        for item in allowances:
            a, b = self._index.get(item.a, -1), self._index.get(item.b, -1)
            meant = ((first == a) & (second == b)) | ((first == b) & (second == a))
            found.extend((int(place), item) for place in np.flatnonzero(meant))
        return tuple(sorted(found, key=lambda entry: entry[0]))

    def immobile(self) -> frozenset[frozenset[str]]:
        rows, others = np.nonzero(self.fixed & ~self.excused)
        mine, theirs = map(int, self._of_row[rows]), map(int, others)
        names = self.names
        return frozenset(frozenset((names[a], names[b])) for a, b in zip(mine, theirs, strict=True) if a != b)

    def _excused(self, rules: ContactRules) -> Bools:
        defaults = rules.allowed.defaults
        stated = np.array([name in defaults for name in self.names], dtype=np.bool_)
        granted = np.array([defaults.get(name, True) for name in self.names], dtype=np.bool_)
        rows = self._of_row
        excused = (stated[rows][:, None] | stated) & granted[rows][:, None] & granted
        for name in [self.names[int(place)] for place in rows]:
            for other, allowed in rules.allowed.entries_of(name).items():
                self._enter(excused, name, other, allowed)
                self._enter(excused, other, name, allowed)
        for name, links in rules.touch_links.items():
            for link in links:
                self._enter(excused, name, link, True)
                self._enter(excused, link, name, True)
        return excused

    def _entered(self, values: Floats, single: Mapping[frozenset[str], float]) -> Floats:
        for pair, value in single.items():
            for one, other in permutations(pair, 2):
                self._enter(values, one, other, value)
        return values

    def _enter(self, matrix: Bools | Floats, one: str, other: str, value: float) -> None:
        place, column = self._index.get(one), self._index.get(other)
        if place is not None and column is not None and self.row[place] >= 0:
            matrix[self.row[place], column] = value


def collision_model_of(scene: Scene, robot: ReducedRobot) -> CollisionModel:
    """Fix a scene's bodies to the joints of its reduced robot.

    Dynamic obstacles are included only if the robot has joints driven by time.
    """
    return _collision_models(scene).get(robot, lambda: _new_collision_model(scene, robot))


@cached_per_value
def _collision_models(scene: Scene) -> LruCache[ReducedRobot, CollisionModel]:
    del scene
    return LruCache(4)


@cached_per_value
def _pairs(robot: ReducedRobot) -> LruCache[object, BodyPairs]:
    del robot
    return LruCache(4)


@cached_per_value
def _places(item: SceneObject) -> LruCache[Anchor, AnchoredObject]:
    del item
    return LruCache(2)


def _anchored(item: SceneObject, frame: Anchor) -> AnchoredObject:
    return _places(item).get(frame, lambda: item.anchored(frame))


def _new_collision_model(scene: Scene, robot: ReducedRobot) -> CollisionModel:
    anchors = dict(robot.anchors)
    still = robot.driven is None
    for name in scene.placed:
        if not (still and scene.carrier(name)):
            _anchor(name, scene, anchors)
    bodies = list(robot.bodies)
    left_out = scene.changing if still else ()
    present = [item for item in scene.objects.values() if item.name not in left_out]
    for item in present:
        bodies.extend(_bodies(item, anchors))
    objects = tuple(item.contact_traits for item in present)
    tools = tuple((item.name, item.frame) for item in scene.tools.values())  # objects may be on them
    margins = (scene.margin, scene.pair_margins, scene.kind_margins)
    key = (objects, tools, scene.allowed, margins, scene.clearances, scene.allowances)
    pairs = _pairs(robot).get(key, lambda: body_pairs(bodies, scene.robot.links, _rules(scene, robot)))
    return CollisionModel(anchors, tuple(bodies), _with_model_error(pairs, scene, bodies))


def _with_model_error(pairs: BodyPairs, scene: Scene, bodies: Sequence[FixedBody]) -> BodyPairs:
    if not scene.model_error.displaces:
        return pairs
    carried = scene.carried_bodies()
    error = approaches(scene.model_error, scene.robot, carried, bodies, pairs.first, pairs.second)
    required = pairs.required + error
    margin = np.where(error > 0.0, np.maximum(pairs.margin, required + ROOM), pairs.margin)
    return replace(pairs, margin=readonly(margin), required=readonly(required), error=error)


def _bodies(item: SceneObject, anchors: Mapping[str, Anchor]) -> tuple[FixedBody, ...]:
    if item.timing.motion is None:
        return _anchored(item, anchors[item.frame]).bodies
    # What moves by itself is placed by the joint that time drives.
    return replace(item, placement=IDENTITY).anchored(anchors[item.name]).bodies


def _anchor(name: str, scene: Scene, anchors: dict[str, Anchor]) -> Anchor:
    found = anchors.get(name)
    if found is None:
        item = scene.placed[name]
        found = anchors[name] = _anchored(item, _anchor(item.frame, scene, anchors)).anchor
    return found


NEAR = 0.02
"""Largest default margin as a share of the reach: links of hands are less than a centimetre apart."""


@cached_per_value
def _reach(robot: ReducedRobot) -> float:
    """Bound the distance of bodies from the first joint that moves them [m]; inf if none moves."""
    model, limits = robot.model, robot.limits
    ranges = dict(zip(limits.joint_names, limits.upper - limits.lower, strict=True))
    joints = zip(model.names, model.joints, strict=True)
    slides = {name: ranges.get(name, 0.0) for name, each in joints if "JointModelP" in each.shortname()}
    far, reach = chain_lengths(model, slides), 0.0
    for body in robot.bodies:
        if body.joint and not isinstance(body.shape, Plane):
            centre, radius = bounding_sphere(body.shape)
            reach = max(reach, far[body.joint] + float(np.linalg.norm(body.placement * centre)) + radius)
    return reach or inf


def _rules(scene: Scene, robot: ReducedRobot) -> ContactRules:
    touched = {name: item.touch_links for name, item in scene.objects.items() if item.touch_links}
    carriers = {name: scene.holder(name).link for name in scene.objects} if scene.clearances.links else {}
    apart = scene.kind_margins or scene.clearances.kinds

    def usual(margin: float) -> float:
        return margin if margin > DEFAULT_MARGIN else min(margin, NEAR * _reach(robot))

    return ContactRules(
        allowed=scene.allowed,
        touch_links=touched,
        margin=usual(scene.margin),
        pair_margins={pair: usual(margin) for pair, margin in scene.pair_margins.items()},
        kind_margins={kind: usual(margin) for kind, margin in scene.kind_margins.items()},
        clearances=scene.clearances,
        carriers=carriers,
        parts={name: scene.part(name) for name in (*scene.robot.links, *scene.objects)} if apart else {},
        allowances=scene.allowances,
        robot_joints=robot.model.njoints - (0 if robot.driven is None else len(robot.driven.names)),
    )
