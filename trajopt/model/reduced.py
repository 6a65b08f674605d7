"""The robot with only a group's joints free: what planning, judging and simulating work on.

All other joints stand exactly where the start state has them, even outside their limits.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, TypeVar

import numpy as np
import pinocchio as pin

from trajopt.arrays import Floats, Ints, readonly
from trajopt.model.allowed_collisions import ContactAllowance
from trajopt.model.limits import JointLimits
from trajopt.model.placement import Placement
from trajopt.model.requirements import WORLD
from trajopt.model.robot import configuration
from trajopt.model.scene import Scene
from trajopt.model.shapes import Shape

T = TypeVar("T")


@dataclass(frozen=True, eq=False)
class FixedBody:
    """A collision body, by the joint that carries it.

    Attributes:
        name: The body's name.
        owner: The link or object it is part of.
        joint: Joint of the reduced model that carries it; 0 is the world.
        placement: Of the shape in that joint's frame.
        shape: The shape.
    """

    name: str
    owner: str
    joint: int
    placement: Placement
    shape: Shape


@dataclass(frozen=True, eq=False)
class BodyPairs:
    """Pairs of bodies that must keep apart and can move against each other.

    Attributes:
        first: Index of the first body of each pair, shape (p,).
        second: Index of the second, shape (p,).
        margin: Clearance to keep, shape (p,) [m].
        allowances: Allowances of meant contact, each with the index of its pair.
        immobile: Owner pairs that cannot move against each other and are left out.
    """

    first: Ints
    second: Ints
    margin: Floats
    allowances: tuple[tuple[int, ContactAllowance], ...]
    immobile: frozenset[frozenset[str]]


@dataclass(frozen=True, eq=False)
class ReducedModel:
    """A scene's robot with only one group's joints free.

    Attributes:
        scene: The scene.
        group: Name of the group.
        start: Positions of all joints at the start, shape (number of joints,) [rad | m].
        model: Pinocchio's model of the free joints and of those that mimic them; never changed.
        joint_names: The group's joints, n of them.
        limits: Their limits.
        expand: Matrix (model joints, n) that maps the group's positions to the model's.
        offset: Offsets of mimicking joints, shape (model joints,).
        bodies: Collision bodies of links and objects.
        pairs: Those that must keep apart.
    """

    scene: Scene
    group: str
    start: Floats
    model: pin.Model
    joint_names: tuple[str, ...]
    limits: JointLimits
    expand: Floats
    offset: Floats
    bodies: tuple[FixedBody, ...]
    pairs: BodyPairs
    _derived: dict[Callable[["ReducedModel"], Any], Any] = field(
        default_factory=dict[Callable[["ReducedModel"], Any], Any], init=False, repr=False
    )

    def derived(self, build: Callable[["ReducedModel"], T]) -> T:
        """Return what a function builds of this model, built at the first call and kept with the model."""
        if build not in self._derived:
            self._derived[build] = build(self)
        return self._derived[build]

    @property
    def start_positions(self) -> Floats:
        """The group's positions at the start, shape (n,) [rad | m]."""
        return readonly(self.start[self.scene.robot.index(self.joint_names)])

    def configuration(self, positions: Floats) -> Floats:
        """Return pinocchio's configuration of the group's positions, (n,) -> (nq,)."""
        return configuration(self.model, self.expand @ positions + self.offset)

    def all_positions(self, positions: Floats) -> Floats:
        """Return positions of all joints of the robot for the group's positions (n,)."""
        full = np.array(self.start)
        moved = self.expand @ positions + self.offset
        full[self.scene.robot.index(tuple(self.model.names[1:]))] = moved
        return full

    def owners(self, pair: int) -> tuple[str, str]:
        """Return the links or objects that the bodies of a pair are part of."""
        first, second = int(self.pairs.first[pair]), int(self.pairs.second[pair])
        return self.bodies[first].owner, self.bodies[second].owner

    def attachment(self, name: str) -> tuple[int, Placement]:
        """Return the joint (0: the world) that carries a frame or object, and where in it.

        Raises:
            FrameNotFound: If the name is no frame.
        """
        holder = self.scene.holder(name)
        if holder.link == WORLD:
            return 0, holder.placement
        joint, link = _link_in_joint(self.model, holder.link)
        return joint, link * holder.placement


def reduce_model(scene: Scene, group: str, start: Floats) -> ReducedModel:
    """Fix every joint outside the group where it is at the start.

    Args:
        scene: The scene.
        group: Name of the planning group.
        start: Positions of all joints, shape (number of joints,) [rad | m].

    Raises:
        GroupNotFound: If the robot has no such group.
    """
    robot = scene.robot
    joints = robot.group(group).joints
    followers = tuple(name for name, mimic in robot.mimics.items() if mimic.source in joints)
    free = frozenset((*joints, *followers))
    locked = [i for i, name in enumerate(robot.model.names) if i > 0 and name not in free]
    model = pin.buildReducedModel(robot.model, locked, robot.configuration(start))
    names = tuple(model.names[1:])
    expand, offset = np.zeros((len(names), len(joints))), np.zeros(len(names))
    for row, name in enumerate(names):
        if name in joints:
            expand[row, joints.index(name)] = 1.0
        else:
            mimic = robot.mimics[name]
            expand[row, joints.index(mimic.source)] = mimic.multiplier
            offset[row] = mimic.offset
    bodies: list[FixedBody] = []
    for body in (*robot.bodies, *scene.object_bodies()):
        joint, where = 0, body.placement
        if body.frame != WORLD:
            joint, link = _link_in_joint(model, body.frame)
            where = link * body.placement
        bodies.append(FixedBody(body.name, body.owner, joint, where, body.shape))
    index = robot.index(joints)
    return ReducedModel(
        scene,
        group,
        readonly(np.array(start)),
        model,
        joints,
        robot.limits.take(index),
        readonly(expand),
        readonly(offset),
        tuple(bodies),
        _pairs(scene, bodies),
    )


def _link_in_joint(model: pin.Model, link: str) -> tuple[int, Placement]:
    frame = model.frames[model.getFrameId(link, pin.FrameType.BODY)]
    where = frame.placement
    return int(frame.parentJoint), Placement(
        readonly(where.rotation.copy()), readonly(where.translation.copy())
    )


def _pairs(scene: Scene, bodies: list[FixedBody]) -> BodyPairs:
    first: list[int] = []
    second: list[int] = []
    margin: list[float] = []
    allowances: list[tuple[int, ContactAllowance]] = []
    immobile: set[frozenset[str]] = set()
    excused: dict[tuple[str, str], bool] = {}
    for j, b in enumerate(bodies):
        for i, a in enumerate(bodies[:j]):
            if a.owner == b.owner:
                continue
            owners = (a.owner, b.owner)
            if owners not in excused:
                excused[owners] = scene.may_touch(*owners)
            if excused[owners]:
                continue
            if a.joint == b.joint:
                if a.owner in scene.robot.links or b.owner in scene.robot.links or a.joint != 0:
                    immobile.add(frozenset(owners))
                continue
            meant = (item for item in scene.allowances if item.pair == frozenset(owners))
            allowances.extend((len(first), item) for item in meant)
            first.append(i)
            second.append(j)
            margin.append(scene.margin_of(*owners))
    return BodyPairs(
        np.array(first, dtype=np.int64),
        np.array(second, dtype=np.int64),
        readonly(np.array(margin, dtype=np.float64)),
        tuple(allowances),
        frozenset(immobile),
    )
