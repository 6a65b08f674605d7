"""Pairs of bodies that must keep apart; their number grows linearly with the objects.

Only links and attached objects are paired with everything, never two objects of the world.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import permutations

import numpy as np

from trajopt.robot.joints import Anchor, FixedBody
from trajopt.scene.clearances import (
    ROOM,
    AllowedCollisions,
    Clearances,
    ContactAllowance,
    PairKind,
    Part,
    kept,
)
from trajopt.scene.reduced import BodyPairs, CollisionModel
from trajopt.scene.reduced_robot import ReducedRobot
from trajopt.scene.scene import Scene
from trajopt.scene.scene_object import AnchoredObject, SceneObject
from trajopt.values.arrays import Bools, Floats, Ints, readonly
from trajopt.values.cached import LruCache, cached_per_value
from trajopt.values.placement import IDENTITY, WORLD


@dataclass(frozen=True)
class ContactRules:
    """The contact rules of a scene.

    Attributes:
        touch_links: Links that may touch an object, by object; objects without any may be missing.
        margin: Default margin of the optimiser [m].
        pair_margins: Margins of single pairs that differ [m].
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
    """List the pairs that must keep apart, ordered by their second body, then by the first.

    Args:
        bodies: All bodies; those of one owner are carried by the same joint.
        links: Names of the robot's links; bodies that cannot move relative to them are listed as immobile.
    """
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
        owners.allowances(rules.allowances, part[first], part[second]),
        owners.immobile(),
    )


class _Owners:
    """Links and objects that own bodies; a row for each that is paired with all others.

    Attributes:
        names: Names of the owners, o of them.
        row: Row of each owner, shape (o,); -1 for objects in the world.
        excused: Whether two owners may touch, shape (rows, o).
        fixed: Whether they cannot move relative to each other, shape (rows, o).
    """

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
        """Return a distance of all owner pairs that depends on their kind, shape (rows, o)."""
        if not kinds:
            return np.full(self.excused.shape, every)
        order = tuple(Part)
        table = np.array([[kept(every, kinds, one, other) for other in order] for one in order])
        code = np.array([order.index(rules.parts[name]) for name in self.names], dtype=np.int64)
        return table[code[self._of_row]][:, code]

    def required(self, rules: ContactRules) -> Floats:
        """Return the required clearance of all owner pairs, shape (rows, o) [m]."""
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

    Dynamic obstacles are included only if the robot has joints that are driven by time. An edited scene
    shares the bodies of all unchanged objects with its predecessor, and the pairs if the edit does not affect
    them.
    """
    return _collision_models(scene).get(robot, lambda: _built(scene, robot))


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


def _built(scene: Scene, robot: ReducedRobot) -> CollisionModel:
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
    return CollisionModel(
        anchors,
        tuple(bodies),
        _pairs(robot).get(key, lambda: body_pairs(bodies, scene.robot.links, _rules(scene, robot))),
    )


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


def _rules(scene: Scene, robot: ReducedRobot) -> ContactRules:
    touched = {name: item.touch_links for name, item in scene.objects.items() if item.touch_links}
    carriers = {name: scene.holder(name).link for name in scene.objects} if scene.clearances.links else {}
    apart = scene.kind_margins or scene.clearances.kinds
    return ContactRules(
        allowed=scene.allowed,
        touch_links=touched,
        margin=scene.margin,
        pair_margins=scene.pair_margins,
        kind_margins=scene.kind_margins,
        clearances=scene.clearances,
        carriers=carriers,
        parts={name: scene.part(name) for name in (*scene.robot.links, *scene.objects)} if apart else {},
        allowances=scene.allowances,
        robot_joints=robot.model.njoints - (0 if robot.driven is None else len(robot.driven.names)),
    )
