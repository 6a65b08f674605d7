"""Scene: a value; an edit returns a new one."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from math import inf
from typing import TYPE_CHECKING, cast

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from trajopt.robot.bodies import CollisionBody, MeshPolicy
from trajopt.robot.configuration import ConfigurationLike, stated_configuration
from trajopt.robot.joints import Anchor, FixedBody, joint_unit
from trajopt.robot.loading.pinocchio_model import link_frame, link_placement, links_of_the_world
from trajopt.robot.robot import FrameAttachment, Robot
from trajopt.scene.clearances import (
    PAIRS_DIFFER,
    ROOM,
    AllowedCollisions,
    Clearances,
    ContactAllowance,
    PairKind,
    Part,
    in_kinds,
    kept,
)
from trajopt.scene.model_error import EXACT, ModelUncertainty
from trajopt.scene.planned_robot import MovingRobot, Planned, model_and_trajectory
from trajopt.scene.scene_object import (
    SceneObject,
    checked_mass,
    cloud_parts,
    covered_parts,
    object_placement,
    replaced_cloud,
)
from trajopt.scene.track import ALWAYS, TOLERANCE, Prediction, Timing, Track, timing_of
from trajopt.values.arrays import (
    Floats,
    Value,
    floats,
    is_array_like,
    name_of,
    number,
    one_of,
    several,
    unless_none,
)
from trajopt.values.cached import cached_per_value
from trajopt.values.errors import (
    DuplicateObject,
    FrameNotFound,
    ModelError,
    ObjectNotFound,
    ShapeError,
    listed,
    shown,
    unknown_attribute,
)
from trajopt.values.likely_units import warn_of_far_apart
from trajopt.values.placement import IDENTITY, WORLD, Placement, PlacementLike, as_placement
from trajopt.values.printed import in_short
from trajopt.values.shapes.shapes import Points, Shape, Voxels, bounding_box
from trajopt.values.trajectory import Trajectory

DEFAULT_MARGIN = 0.01
"""Default margin of the optimiser [m]."""

FROM_SRDF = AllowedCollisions()
"""Default matrix: the pairs that the robot's description disables."""


COPY = "added to a copy of this scene, which `scene = scene.add(..)` keeps"
"""Message for an object that was added to another copy of the scene."""


OTHER_NAMES = {
    "add_box": "scene = scene.add(name, to.Box(x, y, z), placement)",
    "add_sphere": "scene = scene.add(name, to.Sphere(radius), placement)",
    "add_cylinder": "scene = scene.add(name, to.Cylinder(radius, length), placement)",
    "add_plane": "scene = scene.add(name, to.Plane(), placement)",
    "add_mesh": "scene = scene.add(name, to.load_mesh(path), placement)",
    **dict.fromkeys(("add_object", "add_obstacle", "add_shape"), "scene = scene.add(name, shape, placement)"),
    **dict.fromkeys(("remove_object", "remove_world_object", "delete"), "scene = scene.remove(name)"),
    **dict.fromkeys(("attach_box", "attach_object", "attach_mesh"), "scene = scene.attach(name, frame)"),
    **dict.fromkeys(("get_objects", "get_known_object_names"), "scene.objects"),
}
"""Names of methods in other libraries, and the expressions to use here."""


LIFTING = 0.5
"""Duration of the allowed contact of a grasped object with its support [s]: lifted at 0.1 m/s^2, it is a
centimetre above it afterwards.
"""


@dataclass(frozen=True, eq=False)
class Scene(Value):
    """A robot among objects.

    An argument that takes a frame accepts a link, a tool frame or an object. An argument that takes a link or
    object (touch links, margins, clearances, contacts) also accepts a frame, which refers to the body that it
    is fixed on.

    Attributes:
        allowed: Pairs that may touch; initially the robot's disabled pairs.
        margin: Default margin of the optimiser [m]. Groups that reach less than half a metre keep at most a
            fiftieth of their reach, unless more than the default is requested.
        clearances: Required clearances: no motion is verified that violates them.
        tools: Tool frames of this scene, by name, as objects without a shape.
        kind_margins: Margins of kinds of pairs that differ [m].
        model_error: Difference of the robot from its description; a motion is proven for every such robot.
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
    model_error: ModelUncertainty = EXACT

    def __post_init__(self) -> None:
        robot, margin = one_of("robot", self.robot, Robot), number("margin", self.margin)
        for value in (margin, *(number("margin", each) for each in self.kind_margins.values())):
            if value < 0.0:
                raise ShapeError("margin", f"is negative: {value:g} m")
        object.__setattr__(self, "margin", margin)
        if self.allowed is FROM_SRDF:
            object.__setattr__(self, "allowed", AllowedCollisions(dict.fromkeys(robot.disabled_pairs, True)))

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> object:
            raise unknown_attribute(self, name, OTHER_NAMES)

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
        """Ids of the objects that `add` gave to scenes derived from this one, which lacks them."""
        return set()

    @property
    def placed(self) -> Mapping[str, SceneObject]:
        """All tools and objects, by name."""
        return {**self.tools, **self.objects} if self.tools else self.objects

    @property
    def tools_on_links(self) -> Mapping[str, SceneObject]:
        """The tools that do not depend on an object."""
        return {name: item for name, item in self.tools.items() if self.owner(name) not in self.objects}

    @property
    def frame_names(self) -> tuple[str, ...]:
        """Names of all links and tool frames, the robot's first."""
        return (*self.robot.frame_names, *self.tools)

    def holder(self, name: str) -> FrameAttachment:
        """Return the link (or "world") that carries a frame or object, and its placement there.

        Raises:
            FrameNotFound: If the name is not a frame.
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
        """Return the dynamic obstacle that carries a frame or object, perhaps itself; None without one."""
        while one_of("name", name, str) in (placed := self.placed):
            if placed[name].timing.motion is not None:
                return name
            name = placed[name].frame
        return None

    def placement_at(self, name: str, time: float) -> Placement:
        """Return the placement at a time [s] of an object that is placed in the world or moves by itself.

        Args:
            time: By the clock of the scene.

        Raises:
            FrameNotFound: If the object does not exist.
            ShapeError: If the time is not a finite number.
        """
        moment, now, carrier = number("time", time), self.holder(name).placement, self.carrier(name)
        motion = None if carrier is None else self.objects[carrier].timing.motion
        if carrier is None or motion is None:
            return now
        return motion.track.at(moment) * self.holder(carrier).placement.inverse() * now

    @cached_property
    def changing(self) -> tuple[str, ...]:
        """Names of the objects that move by themselves, are carried by such, appear or expire."""
        if all(item.timing.always for item in self.objects.values()):
            return ()
        return tuple(
            name for name, item in self.objects.items() if not item.timing.always or self.carrier(name)
        )

    def at(self, time: float) -> Scene:
        """Return the scene with its clock advanced: `time` becomes 0.

        Raises:
            ShapeError: If the time is negative, or after the end of an object's prediction.
        """
        moment = number("time", time)
        if moment < 0.0:
            raise ShapeError("time", f"must not be before 0 s, is {moment:g} s")
        return replace(self, objects={name: item.shifted(moment) for name, item in self.objects.items()})

    def owner(self, name: str) -> str:
        """Return the link or object that a name refers to in contact rules.

        A frame, or a link without a shape such as a flange, refers to the body that it is fixed on.

        Raises:
            FrameNotFound: If it is none of them.
        """
        return self._owner(name, "link, frame or object")

    def placement_of(self, name: str, positions: ConfigurationLike) -> Placement:
        """Return the placement in the world of a frame or object.

        Args:
            positions: The configuration: positions of all joints or of a group's, shape
                (number of joints,) [rad | m], joint -> position, the name of a state, or a plan, for its end.

        Raises:
            FrameNotFound: If the name is not a frame.
            NameNotFound: If a state or a joint is unknown.
            ShapeError: If the positions are not one finite number for each joint.
        """
        return self._placement_at(name, self._configuration("positions", positions))

    def object_bodies(self) -> tuple[CollisionBody, ...]:
        """Return the collision bodies of all objects, each fixed to a link or the world."""
        return self._bodies_of(self.objects.values())

    def carried_bodies(self) -> tuple[CollisionBody, ...]:
        """Return the collision bodies of the objects that links of the robot carry."""
        on_frames = [item for item in self.objects.values() if item.frame != WORLD]
        return tuple(body for body in self._bodies_of(on_frames) if body.frame != WORLD)

    def _bodies_of(self, items: Iterable[SceneObject]) -> tuple[CollisionBody, ...]:
        return tuple(
            CollisionBody(f"{item.name}/{count}", item.name, holder.link, holder.placement * where, shape)
            for item in items
            for holder in (self.holder(item.name),)
            for count, (shape, where) in enumerate(item.parts)
        )

    def may_touch(self, a: str, b: str) -> bool:
        """Return whether contact of two links or objects is allowed."""
        one, other = self.owner(a), self.owner(b)
        for first, second in ((one, other), (other, one)):
            if first in self.objects and second in self.objects[first].touch_links:
                return True
        # A matrix may speak of links without a shape too: they are as it says.
        return self.allowed.allowed(self._entered(a), self._entered(b))

    def margin_of(self, a: str, b: str) -> float:
        """Return the distance that the optimiser aims at, above the required clearance [m]."""
        pair, required = frozenset((self.owner(a), self.owner(b))), self.clearance_of(a, b)
        by_kind = kept(self.margin, self.kind_margins, self.part(a), self.part(b))
        margin = self.pair_margins.get(pair, by_kind)
        return max(margin, required + ROOM) if required > 0.0 else margin

    def clearance_of(self, a: str, b: str) -> float:
        """Return the required clearance between two links or objects [m]."""
        holders, links = [self.holder(name).link for name in (a, b)], self.clearances.links
        padding = max(links.get(link, 0.0) for link in holders) if WORLD in holders else 0.0
        pair = frozenset((self.owner(a), self.owner(b)))
        by_kind = kept(self.clearances.everywhere, self.clearances.kinds, self.part(a), self.part(b))
        return self.clearances.pairs.get(pair, max(by_kind, padding))

    def part(self, name: str) -> Part:
        """Return the role of a link, frame or object.

        Objects on a link that no joint moves belong to the world, and so do links that are fixed next to the
        robot.

        Raises:
            FrameNotFound: If it is none of them.
        """
        owner = self.owner(name)
        if owner not in self.objects:
            return Part.WORLD if owner in _links_beside(self.robot) else Part.LINK
        return Part.WORLD if self.holder(owner).link in _standing_links(self.robot) else Part.CARRIED

    @property
    def described(self) -> tuple[tuple[str, str], ...]:
        """Tools and surroundings, as headings with text."""
        tools = (f"{item.name} on {item.frame} at {item.placement}" for item in self.tools.values())
        around = f"{', '.join(self.objects) or 'nothing'}; {self.distances}"
        lines = [*(("tool", words) for words in tools), ("around it", around)]
        if self.added_elsewhere:
            lines.append(("not there", f"{listed(sorted(self.added_elsewhere))}: {COPY}"))
        return tuple(lines)

    @property
    def distances(self) -> str:
        """Clearances, margins and model error in words."""
        margin = in_kinds(self.margin, self.kind_margins) + PAIRS_DIFFER * bool(self.pair_margins)
        wrong = "" if self.model_error == EXACT else f", for a model error of {self.model_error}"
        return f"{self.clearances}, margin {margin}{wrong}"

    def add(
        self,
        name: str,
        shape: Shape | Sequence[tuple[Shape, PlacementLike]],
        placement: PlacementLike | None = None,
        *,
        frame: str = WORLD,
        touch_links: Iterable[str] = (),
        meshes: MeshPolicy | None = None,
        mass: float = 0.0,
        motion: Prediction | Track | None = None,
        appears: float | None = None,
        expires: float | None = None,
    ) -> Scene:
        """Add an object.

        Args:
            shape: One shape, or several with placements in the object's frame (none: a frame without a
                shape). A mesh is covered by convex pieces unless `meshes` requests the exact triangles.
            placement: Of the object in `frame`; at its origin if None.
            frame: "world", a link or tool frame (the object moves with it), or another object.
            touch_links: Links, objects or frames that may touch it.
            mass: Its mass [kg], spread evenly over its shapes; 0 if unknown. It counts while a joint carries
                the object.
            motion: Motion of its frame in the world, instead of a placement; a motion of the robot starts at
                time 0 of the scene's clock. Objects in its frame move with it.
            appears: Time before which it does not exist [s]; None if it always exists.
            expires: Time after which it no longer exists [s]; None if it stays.

        Raises:
            DuplicateObject: If the id is taken.
            FrameNotFound: If `frame` or a touch link is unknown.
            ShapeError: If the mass is negative or not finite, or the object expires before it appears.
            ModelError: If there is both a motion and a placement or frame.
        """
        self._check_free(name)
        self._check_frame(frame)
        parts, notes = covered_parts(name, shape, unless_none("meshes", meshes, MeshPolicy) or MeshPolicy())
        links = self._owners(touch_links)
        where = object_placement(name, placement)
        if motion is not None and (placement is not None or frame != WORLD):
            raise ModelError(f"{shown(name)} is placed by its motion: omit placement and frame")
        added = SceneObject(name, parts, where, frame, links, notes, checked_mass(name, mass))
        self.added_elsewhere.add(name)
        return self._with(added).with_motion(name, motion, appears=appears, expires=expires)

    def with_tool(self, name: str, on: str, placement: PlacementLike | None = None) -> Scene:
        """Add a tool frame: `scene.with_tool("tcp", on="tool0", placement=(...))`.

        It has no shape; the shape of the tool is an object on the same link (`add`, `attach`), and `on` may
        be that object. `move` and `remove` accept its name.

        Args:
            on: A link, a tool frame or an object.
            placement: Of the frame in that one; at its origin if None.

        Raises:
            ModelError: If the name is taken or empty, or `on` is the world.
            FrameNotFound: If `on` is unknown.
            ShapeError: If the placement is invalid.
        """
        if name_of("tool frame", name) in (WORLD, "", *self.frame_names, *self.objects):
            taken = "a frame of the robot" if name in self.frame_names else "an object"
            why = f"is taken by {taken if name != WORLD else 'the world'}" if name else "is empty"
            raise ModelError(f"tool frame {shown(name)} {why}: name it differently")
        if one_of("on", on, str) == WORLD:
            raise ModelError(
                f"{shown(name)} would be fixed in the world, not on the robot: add it as an object"
            )
        if on not in self.frame_names and on not in self.objects:
            raise FrameNotFound("frame", on, self.frame_names, objects=self.objects)
        return self._with_tool(SceneObject(name, (), object_placement(name, placement), on))

    def with_motion(
        self,
        name: str,
        motion: Prediction | Track | None = None,
        *,
        appears: float | None = None,
        expires: float | None = None,
    ) -> Scene:
        """Let an object move, appear and expire; see `add`.

        Raises:
            ObjectNotFound: If there is none of that id.
            ModelError: If a moving object is placed in another frame than the world.
            ShapeError: If it expires before it appears.
        """
        item, timing = self.object(name), timing_of(name, motion, appears, expires)
        if timing.motion is None:
            return self._with(replace(item, timing=timing))
        if item.frame != WORLD:
            raise ModelError(f"{shown(name)} is placed in {shown(item.frame)}: only in the world it moves")
        where = object_placement(name, timing.motion.track.at(0.0))
        return self._with(replace(item, timing=timing, placement=where))

    def with_robot_in_motion(
        self,
        name: str,
        motion: Planned[MovingRobot] | MovingRobot,
        trajectory: Trajectory | None = None,
        *,
        base: PlacementLike = IDENTITY,
        start: float = 0.0,
        until: float = inf,
        tolerance: float = TOLERANCE,
    ) -> Scene:
        """Add another robot that moves as planned: `scene.with_robot_in_motion("left", plan, base=...)`.

        Each of its links with a shape, and its attached objects, become objects such as "left/link7", on a
        track with a proven bound on the error (see `trajopt.scene.track`).

        Args:
            name: Prefix of the objects' ids.
            motion: A plan, a result with one, or a reduced model.
            trajectory: The motion of a reduced model; None for a plan's own.
            base: Placement of the other scene's world in this scene's world.
            start: Start of the motion on the clock of this scene; negative if it has begun [s].
            until: End of the time for which the motion is known [s].
            tolerance: Largest error of the tracks, which is subtracted from all distances; smaller errors
                need more pieces [m].

        Raises:
            PlanningFailed: If the result has no plan.
            ProblemError: If `motion` is neither, or the trajectory is missing.
            DuplicateObject: If an id is taken.
            ModelError: If a half-space would have to move.
            ShapeError: If a number or the placement is invalid.
        """
        robot, moved = model_and_trajectory("with_robot_in_motion", motion, trajectory, MovingRobot)
        if not one_of("name", name, str):
            raise ModelError("name of the robot is empty: its links would have the names of this one's")
        where = as_placement("base", base)
        added = robot_objects(name, robot, moved, base=where, start=start, until=until, tolerance=tolerance)
        for key in added:
            if key in self.placed or key in self.frame_names:
                raise DuplicateObject(key)
        return replace(self, objects={**self.objects, **added})

    def with_cloud(self, name: str, cloud: Points | Voxels | None, *, given: Iterable[str] = ()) -> Scene:
        """Add a measured cloud to the world, or replace the earlier cloud of that name.

        The object keeps its allowed contacts, margins and clearances.

        Args:
            cloud: In world coordinates; None for an empty measurement, which leaves a frame without a shape.
            given: Assumptions about it, as phrases that each certificate repeats.

        Raises:
            ModelError: If the name is one of the robot's, or of an object that is not a cloud.
        """
        stated = several("given", given, str)
        if one_of("the cloud's id", name, str) in self.objects:
            return self._with(replaced_cloud(self.objects[name], cloud, stated))
        self._check_free(name)
        return self._with(SceneObject(name, cloud_parts(cloud), IDENTITY, WORLD, given=stated))

    def still_at(self, time: float) -> Scene:
        """Return a static scene: a snapshot at a time of the clock [s].

        After the end of a prediction an object keeps its last position; errors of predictions are left out.
        Objects that do not exist then are left out, unless another object is placed in their frame.

        Raises:
            ShapeError: If the time is not a finite number.
        """
        moment = number("time", time)
        if not self.changing:
            return self
        found = replace(self, objects={name: item.still_at(moment) for name, item in self.objects.items()})
        carrying = {item.frame for item in self.placed.values()}
        for name, item in self.objects.items():
            if not item.timing.appears <= moment <= item.timing.expires and name not in carrying:
                found = found.remove(name)
        return found

    def remove(self, name: str) -> Scene:
        """Remove an object, or the frame of a tool.

        Raises:
            ObjectNotFound: If there is none of that id.
            ModelError: If an object or a tool frame is placed in its frame.
        """
        if one_of("object", name, str) not in self.tools:
            self.object(name)
        for other in self.placed.values():
            if other.frame == name:
                raise ModelError(f"{shown(other.name)} is placed in {shown(name)}; remove or move it first")
        return replace(
            self,
            objects={key: item for key, item in self.objects.items() if key != name},
            tools={key: item for key, item in self.tools.items() if key != name},
            allowed=self.allowed.without(name),
            pair_margins={pair: m for pair, m in self.pair_margins.items() if name not in pair},
            clearances=self.clearances.without(name),
            allowances=tuple(item for item in self.allowances if name not in item.pair),
        )

    def move(self, name: str, placement: PlacementLike, *, frame: str | None = None) -> Scene:
        """Place an object, or a tool frame, elsewhere, in its present frame or another.

        A moving object rests there afterwards.

        Raises:
            ObjectNotFound: If there is none of that id.
            FrameNotFound: If the frame is unknown.
            ModelError: If it would be placed in itself, or a tool frame in the world.
        """
        item = self.tools[name] if one_of("object", name, str) in self.tools else self.object(name)
        target = item.frame if frame is None else frame
        self._check_frame(target)
        self._check_not_within(name, target)
        timing = replace(item.timing, motion=None)
        where = object_placement(name, as_placement("placement", placement))
        moved = replace(item, placement=where, frame=target, timing=ALWAYS if timing.always else timing)
        if name not in self.tools:
            return self._with(moved)
        if target == WORLD:
            raise ModelError(
                f"{shown(name)} would be fixed in the world, not on the robot: add it as an object"
            )
        return self._with_tool(moved)

    def attach(
        self,
        name: str,
        link: str,
        *,
        placement: PlacementLike | None = None,
        at: ConfigurationLike | None = None,
        touch_links: Iterable[str] = (),
        mass: float | None = None,
        resting_on: str | Iterable[str] = (),
    ) -> Scene:
        """Fix an object to a link, a tool frame or an attached object, with which it moves afterwards.

        A dynamic obstacle can carry others too: a tray on a conveyor.

        Args:
            placement: Of the object in the link's frame; or
            at: Configuration at which it is grasped at its present place; for a moving object, its place at
                time 0.
            touch_links: Links that may touch it, beyond the link itself and the objects attached between; as
                for `add`.
            mass: Its mass [kg]; unchanged if None.
            resting_on: Objects or links that support it until it is lifted: contact is accepted for the first
                half second of a motion, to a depth of 1 mm (`allow_contact`).

        Raises:
            ObjectNotFound: If there is none of that id.
            FrameNotFound: If the link, a touch link or a support is unknown.
            ModelError: Unless exactly one of `placement` and `at` is given, or if `link` cannot move.
            ShapeError: If the mass is negative or not finite.
        """
        item = self.object(name)
        holder = self.holder(one_of("link", link, str)).link
        if holder == WORLD and self.carrier(link) is None:
            raise ModelError(
                f"{shown(link)} is fixed in the world: nothing attached to it would move; "
                f"move {shown(name)} into its frame instead"
            )
        self._check_not_within(name, link)
        if (placement is None) == (at is None):
            raise ModelError(
                "attach: give either `placement`, in the link, or `at`, the configuration of the grasp"
            )
        where = object_placement(name, placement)
        if at is not None:
            positions = self._configuration("at", at)
            where = self._placement_at(link, positions).inverse() * self._placement_at(name, positions)
        links = self._owners(touch_links) | ({holder, self.owner(link)} - {WORLD}) | item.touch_links
        weight = item.mass if mass is None else checked_mass(name, mass)
        held = self._with(
            replace(item, placement=where, frame=link, touch_links=links, mass=weight, timing=ALWAYS)
        )
        supports = (resting_on,) if isinstance(resting_on, str) else several("resting_on", resting_on, str)
        for support in supports:
            held = held.allow_contact(f"{name} rests on {support}", name, support, first=LIFTING)
        return held

    def detach(self, name: str, *, at: ConfigurationLike) -> Scene:
        """Fix an object in the world at its place in a configuration, with moving carriers as at 0 s.

        Args:
            at: The configuration; the end of a plan is one.

        Raises:
            ObjectNotFound: If there is none of that id.
            ModelError: If it is not attached.
            NameNotFound: If a state or a joint is unknown.
            ShapeError: If the positions are not one finite number for each joint.
        """
        item = self.object(name)
        if self.holder(name).link == WORLD and self.carrier(item.frame) is None:
            raise ModelError(f"object {shown(name)} is not attached to a link")
        where, nothing = self._placement_at(name, self._configuration("at", at)), frozenset[str]()
        return self._with(replace(item, placement=where, frame=WORLD, touch_links=nothing))

    def with_mass(self, name: str, mass: float) -> Scene:
        """Return the scene with another mass of an object [kg], as in `add`.

        Raises:
            ObjectNotFound: If there is none of that id.
            ShapeError: If the mass is negative or not finite.
        """
        return self._with(replace(self.object(one_of("name", name, str)), mass=checked_mass(name, mass)))

    def allow(self, a: str, b: str | None = None, *, allowed: bool = True) -> Scene:
        """Allow contact of two bodies, or of one with anything (`b` None); `allowed=False` forbids it again.

        Raises:
            FrameNotFound: If a name is not a link, frame or object.
        """
        matrix, allowed = self.allowed, one_of("allowed", allowed, bool)
        for meant in (self._entered, self.owner):
            one, other = meant(a), None if b is None else meant(b)
            matrix = (
                matrix.with_default(one, allowed) if other is None else matrix.with_entry(one, other, allowed)
            )
        return replace(self, allowed=matrix)

    def with_clearance(
        self,
        value: float | None = None,
        a: str | None = None,
        b: str | None = None,
        *,
        world: float | None = None,
        carried: float | None = None,
        robot: float | None = None,
    ) -> Scene:
        """Require a clearance: between all bodies, between two, or by kind [m].

        `with_clearance(world=0.03)` requires 30 mm from the world, and nothing between the robot's own links.
        The judge proves the clearance, and refuses a nearer start or goal. Links that are nearer by design
        need their own clearance, by kind or by name.

        Args:
            value: Between all bodies of every kind, or between `a` and `b`.
            a: One link, frame or object.
            world: Between the world (also tables and floors of the robot's description) and the robot with
                its attached objects.
            carried: Between attached objects and everything; from the world the larger of both applies.
            robot: Between the robot's links.

        Raises:
            ShapeError: If a clearance is negative or not finite.
            FrameNotFound: If a name is not a link, frame or object.
            ModelError: If nothing is given, only one name, names without a value, or names with kinds.

        Warns:
            UnitWarning: If it is larger than the reach of any arm.
        """
        pair, kinds = self._asked("with_clearance", value, a, b, (world, carried, robot))
        kept = self.clearances if value is None else self.clearances.having(value, pair)
        return replace(self, clearances=replace(kept, kinds={**kept.kinds, **kinds}))

    def with_margin(
        self,
        margin: float | None = None,
        a: str | None = None,
        b: str | None = None,
        *,
        world: float | None = None,
        carried: float | None = None,
        robot: float | None = None,
    ) -> Scene:
        """Set the margin, a distance that the optimiser keeps if possible and the judge ignores [m].

        Other arguments, errors and the warning are as for `with_clearance`.

        Args:
            margin: Between all bodies of every kind, or between `a` and `b`.
            a: One link, frame or object.
        """
        pair, kinds = self._asked("with_margin", margin, a, b, (world, carried, robot))
        if pair is not None and margin is not None:
            checked = replace(self, margin=margin).margin
            return replace(self, pair_margins={**self.pair_margins, pair: checked})
        if margin is not None:
            return replace(self, margin=margin, kind_margins=kinds)
        return replace(self, kind_margins={**self.kind_margins, **kinds})

    def with_model_error(
        self,
        *,
        joints: float | Mapping[str, float] = 0.0,
        mounting: tuple[float, float] = (0.0, 0.0),
        payload: float = 0.0,
    ) -> Scene:
        """Require that a motion holds for every robot that differs by no more than this.

        Clearances and torques are proven for all of these robots, goals and requirements of frames for the
        described one (docs/goals-and-scenes.md#model-errors).

        Args:
            joints: Error of the zero position of every joint that turns [rad], or of single joints and those
                that follow them, by name [rad | m].
            mounting: Displacement of the robot's root in the world [m], and its rotation about any axis
                through the root's origin [rad].
            payload: Error of the masses of attached objects, as a share of each.

        Raises:
            ShapeError: If a number is not finite.
            ProblemError: If one is negative.
            JointNotFound: If the robot has no such joint.
        """
        robot = self.robot
        shift, turn = floats("mounting", mounting, (2,)).tolist()
        error = ModelUncertainty({}, shift, turn, number("payload", payload))
        if isinstance(joints, Mapping):
            robot.index(tuple(joints))
            return replace(self, model_error=error.with_joints(joints, robot))
        size = number("joints", joints)
        turning = {name: size for name in robot.joint_names if joint_unit(robot.model, name) == "rad"}
        return replace(self, model_error=replace(error, joints=turning))

    def allow_contact(
        self, name: str, a: str, b: str, *, depth: float = 1e-3, first: float = 0.0, last: float = 0.0
    ) -> Scene:
        """Accept contact of a pair during the first or last seconds of the motion.

        Args:
            name: Its purpose, shown in the certificate.
            depth: Largest accepted penetration [m].
            first: Duration from the start [s].
            last: Duration up to the end [s].

        Raises:
            FrameNotFound: If a name is not a link, frame or object.
            ModelError: If no duration is given.
            ShapeError: If a number is negative or not finite.
        """
        allowance = ContactAllowance(name, self.owner(a), self.owner(b), depth, first, last)
        return replace(self, allowances=(*self.allowances, allowance))

    def _configuration(self, name: str, given: ConfigurationLike) -> Floats:
        # Positions of all joints are taken as they are: a recorded mimic joint was where it was.
        joints = len(self.robot.joint_names)
        if is_array_like(given) and len(at := floats(name, cast("ArrayLike", given), (None,))) == joints:
            return at
        return stated_configuration(self.robot, name, given)

    def _placement_at(self, name: str, positions: Floats) -> Placement:
        holder = self.holder(name)
        if holder.link == WORLD:
            return holder.placement
        return link_placement(self.robot.model, holder.link, positions) * holder.placement

    def _entered(self, name: str) -> str:
        owner = self.owner(name)
        return name if name in self.robot.links else owner

    def _check_frame(self, name: str) -> None:
        known = {WORLD, *self.frame_names}
        if one_of("frame", name, str) not in known and name not in self.objects:
            lost = COPY if name in self.added_elsewhere else ""
            raise FrameNotFound("frame", name, known, objects=self.objects, left_out=lost)

    def _owner(self, name: str, kind: str) -> str:
        if one_of(kind, name, str) in self.tools:
            return self.owner(self.tools[name].frame)
        if name in self.objects:
            return name
        if name not in self.robot.frames and name not in self.robot.links:
            raise FrameNotFound(kind, name, self.frame_names, objects=self.objects)
        link = self.robot.frame(name).link
        return _shaped_links(self.robot).get(link, link)

    def _owners(self, names: Iterable[str]) -> frozenset[str]:
        return frozenset(self._owner(name, "touch link") for name in several("touch_links", names, str))

    def _check_not_within(self, name: str, frame: str) -> None:
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

    def _check_free(self, name: str) -> None:
        if name_of("object id", name) in self.objects:
            raise DuplicateObject(name)
        if not name or name == WORLD or name in self.frame_names:
            raise ModelError(f"object id {shown(name)} is taken by a frame of the robot, or empty")

    def _with(self, item: SceneObject) -> Scene:
        return replace(self, objects={**self.objects, item.name: item})

    def _with_tool(self, item: SceneObject) -> Scene:
        return replace(self, tools={**self.tools, item.name: item})

    def __repr__(self) -> str:
        objects = in_short(", ".join(self.objects) or "no objects", 100)
        mounted = f" with {in_short(', '.join(self.tools), 100)}" if self.tools else ""
        return f"Scene({shown(self.robot.name)}{mounted}, {objects}; {self.distances})"


@cached_per_value
def _shaped_links(robot: Robot) -> Mapping[str, str]:
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
    model = robot.model
    fixed = (link for link in robot.links if model.frames[link_frame(model, link)].parentJoint == 0)
    return frozenset((WORLD, *fixed))


def robot_objects(
    name: str,
    robot: MovingRobot,
    trajectory: Trajectory,
    *,
    base: Placement,
    start: float,
    until: float = inf,
    tolerance: float,
) -> Mapping[str, SceneObject]:
    """Return the links with shapes of a moving robot, and its attached objects, as objects by id.

    The first object on each joint has a track, and the others are placed in its frame; arguments as for
    `Scene.with_robot_in_motion`.
    """
    owned: dict[str, list[FixedBody]] = {}
    for body in robot.bodies:
        if body.joint > 0 or body.owner not in robot.scene.objects:
            owned.setdefault(body.owner, []).append(body)
    found: dict[str, SceneObject] = {}
    first: dict[int, str] = {}
    for owner, bodies in owned.items():
        key, anchor = f"{name}/{owner}", robot.anchors[owner]
        inward = anchor.placement.inverse()
        parts = tuple((body.shape, inward * body.placement) for body in bodies)
        if anchor.joint == 0:
            found[key] = SceneObject(key, parts, base * anchor.placement, WORLD)
        elif anchor.joint in first:
            carrier = first[anchor.joint]
            where = robot.anchors[carrier].placement.inverse() * anchor.placement
            found[key] = SceneObject(key, parts, where, f"{name}/{carrier}")
        else:
            first[anchor.joint] = owner
            motion = Track.of(
                robot,
                owner,
                reach=max(_reach(body, anchor) for body in robot.bodies if body.joint == anchor.joint),
                trajectory=trajectory,
                base=base,
                start=start,
                until=until,
                tolerance=tolerance,
            )
            found[key] = SceneObject(key, parts, motion.track.at(0.0), WORLD, timing=Timing(motion))
    return found


def _reach(body: FixedBody, frame: Anchor) -> float:
    lower, upper = bounding_box(body.shape)
    if not (np.isfinite(lower).all() and np.isfinite(upper).all()):
        raise ModelError(
            f"{shown(body.owner)} has no end, so no track has all of it: a half-space cannot move"
        )
    where = frame.placement.inverse() * body.placement
    corners = np.stack(np.meshgrid(*zip(lower, upper, strict=True)), axis=-1).reshape(-1, 3)
    return float(np.linalg.norm(corners @ where.rotation.T + where.translation, axis=1).max())
