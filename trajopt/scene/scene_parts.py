"""What a scene is made of, and what its names mean: the read-only half of `Scene`."""

from collections.abc import Iterable, Mapping, Sized
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Self, cast

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from trajopt.robot.bodies import CollisionBody
from trajopt.robot.configuration import ConfigurationLike, stated_configuration
from trajopt.robot.frame_attachment import FrameAttachment
from trajopt.robot.loading.pinocchio_model import link_frame, link_placement, links_of_the_world
from trajopt.robot.robot import Robot
from trajopt.scene.collisions.allowed_collisions import AllowedCollisions, ContactAllowance
from trajopt.scene.collisions.clearances import PAIRS_DIFFER, ROOM, Clearances, PairKind, Part, in_kinds, kept
from trajopt.scene.scene_object import SceneObject
from trajopt.values.arrays import Floats, Value, floats, number, one_of, several
from trajopt.values.cached import cached_per_value
from trajopt.values.errors import FrameNotFound, ModelError, ObjectNotFound, ShapeError, shown
from trajopt.values.likely_units import warn_of_far_apart
from trajopt.values.placement import IDENTITY, WORLD, Placement
from trajopt.values.printed import in_short

DEFAULT_MARGIN = 0.01
"""Default clearance that the optimiser aims at from everything [m]."""

FROM_SRDF = AllowedCollisions()
"""Stands for the pairs that the robot's description disables, unless another matrix is given."""


COPY = "added to a copy of this scene, which `scene = scene.add(..)` keeps"
"""Why a scene lacks what was added: it is a value."""


@dataclass(frozen=True, eq=False)
class SceneParts(Value):
    """The fields of a scene, which `Scene` says more of, and what can be asked of them.

    Attributes:
        robot: The robot.
        objects: Objects by id.
        allowed: Pairs that may touch; starts with the robot's disabled pairs.
        margin: Clearance that the optimiser keeps from everything where it can [m].
        pair_margins: The same of single pairs of links and objects, where it differs [m].
        clearances: Clearance that is required: no motion is verified that undercuts it.
        allowances: Intended contacts, for a time.
        tools: Frames of the tools that the robot has in this scene, by name, as objects without a shape.
        kind_margins: The margin of kinds of pairs, where it differs from that of everything [m].
    """

    robot: Robot
    objects: Mapping[str, SceneObject] = field(default_factory=dict[str, SceneObject])
    allowed: AllowedCollisions = FROM_SRDF
    margin: float = DEFAULT_MARGIN
    pair_margins: Mapping[frozenset[str], float] = field(default_factory=dict[frozenset[str], float])
    clearances: Clearances = field(default_factory=Clearances)
    allowances: tuple[ContactAllowance, ...] = ()
    tools: Mapping[str, SceneObject] = field(default_factory=dict[str, SceneObject])
    kind_margins: Mapping[PairKind, float] = field(default_factory=dict[PairKind, float])

    def __post_init__(self) -> None:
        """Check the margin; start from the robot's disabled pairs when no matrix was given."""
        robot, margin = one_of("robot", self.robot, Robot), number("margin", self.margin)
        for value in (margin, *(number("margin", each) for each in self.kind_margins.values())):
            if value < 0.0:
                raise ShapeError("margin", f"is negative: {value:g} m")
        object.__setattr__(self, "margin", margin)
        if self.allowed is FROM_SRDF:
            object.__setattr__(self, "allowed", AllowedCollisions(dict.fromkeys(robot.disabled_pairs, True)))

    def object(self, name: str) -> SceneObject:
        """Return an object.

        Raises:
            ObjectNotFound: If there is none of that id.
        """
        if one_of("object", name, str) not in self.objects:
            lost = COPY if name in self.added_elsewhere else ""
            raise ObjectNotFound("object", name, self.objects, frames=self.frame_names, left_out=lost)
        return self.objects[name]

    @cached_property
    def added_elsewhere(self) -> set[str]:
        """Ids of the objects that `add` gave to scenes made of this one, which does not have them."""
        return set()

    @property
    def placed(self) -> Mapping[str, SceneObject]:
        """Everything that has a placement in another frame, by name: tools and objects."""
        return {**self.tools, **self.objects} if self.tools else self.objects

    @property
    def tools_on_links(self) -> Mapping[str, SceneObject]:
        """The tools that would stay without any object."""
        return {name: item for name, item in self.tools.items() if self.owner(name) not in self.objects}

    @property
    def frame_names(self) -> tuple[str, ...]:
        """Names of all links and tool frames: those of the robot, then those of this scene."""
        return (*self.robot.frame_names, *self.tools)

    def holder(self, name: str) -> FrameAttachment:
        """Return the link (or "world") that a frame or object is fixed to, and where in it.

        Raises:
            FrameNotFound: If the name is no frame.
        """
        if one_of("frame", name, str) == WORLD:
            return FrameAttachment(WORLD, IDENTITY)
        if name in (placed := self.placed):
            item = placed[name]
            holder = self.holder(item.frame)
            return FrameAttachment(holder.link, holder.placement * item.placement)
        self._check_frame(name)
        return self.robot.frame(name)

    def carrier(self, name: str) -> str | None:
        """Return the moving object that carries a frame or object, itself if it moves; None if none does."""
        while name in (placed := self.placed):
            if placed[name].timing.motion is not None:
                return name
            name = placed[name].frame
        return None

    @cached_property
    def changing(self) -> tuple[str, ...]:
        """Names of the objects that move by themselves, are carried by such, appear or expire."""
        if all(item.timing.always for item in self.objects.values()):
            return ()
        return tuple(
            name for name, item in self.objects.items() if not item.timing.always or self.carrier(name)
        )

    def at(self, time: float) -> Self:
        """Return the scene by a clock that shows 0 when this one's shows `time`: what a later motion meets.

        Raises:
            ShapeError: If the time is negative, or nothing is known of an object's motion any more then.
        """
        moment = number("time", time)
        if moment < 0.0:
            raise ShapeError("time", f"must not be before 0 s, is {moment:g} s")
        return replace(self, objects={name: item.shifted(moment) for name, item in self.objects.items()})

    def owner(self, name: str, kind: str = "link, frame or object") -> str:
        """Return the link or object that is meant where collisions are spoken of.

        An object means itself, and so does a link that has a shape. A frame means what it is fixed on, and so
        does a link without a shape, such as a flange: no other link could be meant.

        Args:
            name: A link, a tool frame or an object.
            kind: What it is called where it is not found.

        Raises:
            FrameNotFound: If it is none of them.
        """
        if one_of(kind, name, str) in self.tools:
            return self.owner(self.tools[name].frame)
        if name in self.objects:
            return name
        if name not in self.robot.frames and name not in self.robot.links:
            raise FrameNotFound(kind, name, self.frame_names, objects=self.objects)
        link = self.robot.frame(name).link
        return _shaped_links(self.robot).get(link, link)

    def placement_of(self, name: str, positions: ConfigurationLike) -> Placement:
        """Return the placement in the world of a frame or object.

        Args:
            name: "world", a link, tool frame or object.
            positions: The configuration in any of its forms: positions of all joints or of a group's, shape
                (number of joints,) [rad | m], joint -> position, the name of a state, or a plan, for its end.

        Raises:
            FrameNotFound: If the name is no frame.
            NameNotFound: If a state or a joint is unknown.
            ShapeError: If there is not one finite position for each joint.
        """
        return self._placement_at(name, self._configuration("positions", positions))

    def _configuration(self, name: str, given: ConfigurationLike) -> Floats:
        """Return the positions of all joints in a configuration in any of its forms."""
        # Positions of all joints are taken as they are: a recorded mimic joint was where it was.
        joints = len(self.robot.joint_names)
        if isinstance(given, list | tuple | np.ndarray) and len(cast("Sized", given)) == joints:
            return floats(name, cast("ArrayLike", given), (joints,))
        return stated_configuration(self.robot, name, cast("ConfigurationLike", given))

    def _placement_at(self, name: str, positions: Floats) -> Placement:
        holder = self.holder(name)
        if holder.link == WORLD:
            return holder.placement
        return link_placement(self.robot.model, holder.link, positions) * holder.placement

    def object_bodies(self) -> tuple[CollisionBody, ...]:
        """Return the collision bodies of all objects, each fixed to a link or the world."""
        return tuple(
            CollisionBody(f"{item.name}/{count}", item.name, holder.link, holder.placement * where, shape)
            for item in self.objects.values()
            for holder in (self.holder(item.name),)
            for count, (shape, where) in enumerate(item.parts)
        )

    def may_touch(self, a: str, b: str) -> bool:
        """Say whether two links or objects are excused from keeping apart."""
        one, other = self.owner(a), self.owner(b)
        for first, second in ((one, other), (other, one)):
            if first in self.objects and second in self.objects[first].touch_links:
                return True
        # A matrix may speak of links without a shape too: they are as it says.
        return self.allowed.allowed(self._entered(a), self._entered(b))

    def margin_of(self, a: str, b: str) -> float:
        """Return the clearance that the optimiser aims at, always a little above what is required [m]."""
        pair, required = frozenset((self.owner(a), self.owner(b))), self.clearance_of(a, b)
        by_kind = kept(self.margin, self.kind_margins, self.part(a), self.part(b))
        margin = self.pair_margins.get(pair, by_kind)
        return max(margin, required + ROOM) if required > 0.0 else margin

    def clearance_of(self, a: str, b: str) -> float:
        """Return the clearance that is required between two links or objects [m]."""
        holders, links = [self.holder(name).link for name in (a, b)], self.clearances.links
        padding = max(links.get(link, 0.0) for link in holders) if WORLD in holders else 0.0
        pair = frozenset((self.owner(a), self.owner(b)))
        by_kind = kept(self.clearances.everywhere, self.clearances.kinds, self.part(a), self.part(b))
        return self.clearances.pairs.get(pair, max(by_kind, padding))

    def part(self, name: str) -> Part:
        """Say what a link, a frame or an object is to the robot.

        An object on a link that no joint moves stands in the world: a table placed on the robot's base. So
        does a link that is fixed beside the robot: a table or a floor in its description.

        Raises:
            FrameNotFound: If it is none of them.
        """
        owner = self.owner(name)
        if owner not in self.objects:
            return Part.WORLD if owner in _links_beside(self.robot) else Part.LINK
        return Part.WORLD if self.holder(owner).link in _standing_links(self.robot) else Part.CARRIED

    def __repr__(self) -> str:
        """Say the robot, its tools, the objects and the distances to keep."""
        objects = in_short(", ".join(self.objects) or "no objects", 100)
        mounted = f" with {in_short(', '.join(self.tools), 100)}" if self.tools else ""
        return f"Scene({shown(self.robot.name)}{mounted}, {objects}; {self.distances})"

    @property
    def described(self) -> tuple[tuple[str, str], ...]:
        """Each tool, and what is around the robot, as a heading and words."""
        tools = (f"{item.name} on {item.frame} at {item.placement}" for item in self.tools.values())
        around = f"{', '.join(self.objects) or 'nothing'}; {self.distances}"
        lines = [*(("tool", words) for words in tools), ("around it", around)]
        if self.added_elsewhere:
            lost = ", ".join(sorted(self.added_elsewhere))
            lines.append(("not there", f"{lost}: {COPY}"))
        return tuple(lines)

    @property
    def distances(self) -> str:
        """The distances to keep, in words."""
        margin = in_kinds(self.margin, self.kind_margins) + PAIRS_DIFFER * bool(self.pair_margins)
        return f"{self.clearances}, margin {margin}"

    def _entered(self, name: str) -> str:
        """Return the name that a matrix of allowed collisions has for a link, frame or object."""
        owner = self.owner(name)
        return name if name in self.robot.links else owner

    def _check_frame(self, name: str) -> None:
        known = (WORLD, *self.frame_names)
        if one_of("frame", name, str) not in known and name not in self.objects:
            lost = COPY if name in self.added_elsewhere else ""
            raise FrameNotFound("frame", name, known, objects=self.objects, left_out=lost)

    def _owners(self, names: Iterable[str]) -> frozenset[str]:
        return frozenset(self.owner(name, "touch link") for name in several("touch_links", names, str))

    def _check_not_within(self, name: str, frame: str) -> None:
        """Refuse a frame that is placed, directly or not, in what is to be placed in it."""
        over, placed = frame, self.placed
        while over in placed:
            if over == name:
                raise ModelError(f"object {shown(name)} cannot be placed in its own frame")
            over = placed[over].frame

    def _asked(
        self,
        caller: str,
        value: float | None,
        a: str | None,
        b: str | None,
        kinds: tuple[float | None, float | None, float | None],
    ) -> tuple[frozenset[str] | None, Mapping[PairKind, float]]:
        """Return the pair that is asked of, if it is one, and what is asked of kinds of pairs [m]."""
        order = (PairKind.WORLD, PairKind.CARRIED, PairKind.ROBOT)
        first = "margin" if caller == "with_margin" else "value"
        for name, each in zip((first, "world", "carried", "robot"), (value, *kinds), strict=True):
            if each is not None:
                warn_of_far_apart(name, number(name, each))
        stated = {kind: each for kind, each in zip(order, kinds, strict=True) if each is not None}
        pair = self._pair(caller, a, b)
        if pair is not None and (value is None or stated):
            raise ModelError(f"{caller}: give one value for {shown(a)} and {shown(b)}")
        if value is None and not stated:
            raise ModelError(f"{caller}: give a value, or one for world, carried or robot [m]")
        return pair, stated

    def _pair(self, caller: str, a: str | None, b: str | None) -> frozenset[str] | None:
        if a is None or b is None:
            if a is not b:
                raise ModelError(f"{caller}: name both things or none")
            return None
        one, other = self.owner(a), self.owner(b)
        if one == other:
            raise ModelError(f"{caller}: {shown(a)} and {shown(b)} are one thing, {shown(one)}")
        return frozenset((one, other))


@cached_per_value
def _shaped_links(robot: Robot) -> Mapping[str, str]:
    """Return the nearest link with a shape that each link without one is fixed on, where there is one."""
    shaped, frames = {body.owner for body in robot.bodies}, robot.model.frames
    found: dict[str, str] = {}
    for link in robot.links:
        place = link_frame(robot.model, link)
        while frames[place].name not in shaped and place > 0:
            joint = frames[place].parentFrame
            if frames[joint].type != pin.FrameType.FIXED_JOINT:
                break
            place = frames[joint].parentFrame
        if frames[place].name in shaped:
            found[link] = str(frames[place].name)
    return found


@cached_per_value
def _links_beside(robot: Robot) -> frozenset[str]:
    return links_of_the_world(robot.model, {body.owner for body in robot.bodies})


@cached_per_value
def _standing_links(robot: Robot) -> frozenset[str]:
    """Return the links that no joint moves, and the world."""
    model = robot.model
    fixed = (link for link in robot.links if model.frames[link_frame(model, link)].parentJoint == 0)
    return frozenset((WORLD, *fixed))
