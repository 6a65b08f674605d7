"""Scene: a robot among objects, and what may touch what. A value: an edit gives a new one."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from trajopt.robot.configuration import ConfigurationLike
from trajopt.robot.meshes.mesh_cover import MeshPolicy
from trajopt.scene.collisions.allowed_collisions import ContactAllowance
from trajopt.scene.scene_motions import SceneMotions
from trajopt.scene.scene_object import SceneObject, checked_mass, covered_parts, object_placement
from trajopt.scene.timing import ALWAYS
from trajopt.scene.track import Prediction, Track
from trajopt.values.arrays import name_of, number, one_of, several, unless_none
from trajopt.values.errors import FrameNotFound, ModelError, shown
from trajopt.values.likely_units import warn_of_wide_mesh
from trajopt.values.other_names import unknown_attribute
from trajopt.values.placement import WORLD, PlacementLike, as_placement
from trajopt.values.shapes.mesh_file import Mesh
from trajopt.values.shapes.shapes import Shape

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
"""Names of methods in other libraries, and what to write here."""
LIFTING = 0.5
"""For so long an object may touch what it rests on after it was grasped [s]: lifted at 0.1 m/s^2 it is a
centimetre above by then."""


@dataclass(frozen=True, eq=False)
class Scene(SceneMotions):
    """A robot among objects.

    Wherever a frame is meant, a link, a tool frame or an object does: an object means its own frame. Where
    a link or an object is meant (touch links, margins, clearances, what may touch), a frame does too: it
    means what it is fixed on.

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

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> object:
            """Name what is meant by a name of another library."""
            raise unknown_attribute(self, name, OTHER_NAMES)

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
            name: Its id, not taken by another object or a frame of the robot.
            shape: One shape, or several with placements in the object's frame (none: a mere
                frame). A mesh is covered by convex pieces unless `meshes` asks for it exactly.
            placement: Of the object in `frame`; at its origin when None.
            frame: "world", a link or tool frame (it moves along then), or another object.
            touch_links: Links that may touch it; objects too, and frames for what they are fixed on.
            meshes: How meshes become convex.
            mass: Its mass [kg]; 0 where it is not known. It counts where a joint carries the object,
                spread evenly over its shapes.
            motion: How its frame moves in the world, instead of a placement; the scene's clock shows 0 when a
                motion starts. What is placed in its frame moves along.
            appears: Before it is not there [s]; None where it always was.
            expires: After it is no longer there [s]; None where it stays.

        Raises:
            DuplicateObject: If the id is taken.
            FrameNotFound: If `frame` or a touch link is unknown.
            ShapeError: If the mass is negative or not finite, or it expires before it appears.
            ModelError: If there is both a motion and a placement or frame.
        """
        self._check_free(name)
        self._check_frame(frame)
        parts, notes = covered_parts(name, shape, unless_none("meshes", meshes, MeshPolicy) or MeshPolicy())
        if isinstance(shape, Mesh):
            warn_of_wide_mesh(shown(name), shape.vertices)
        links = self._owners(touch_links)
        where = object_placement(name, placement)
        if motion is not None and (placement is not None or frame != WORLD):
            raise ModelError(f"{shown(name)} is where its motion has it: give no placement and no frame")
        added = SceneObject(name, parts, where, frame, links, notes, checked_mass(name, mass))
        self.added_elsewhere.add(name)
        return self._with(added).with_motion(name, motion, appears=appears, expires=expires)

    def with_tool(self, name: str, on: str, placement: PlacementLike | None = None) -> Scene:
        """Give the robot a tool's frame: `scene.with_tool("tcp", on="tool0", placement=(...))`.

        Its name will do wherever a frame is meant, from then on. It has no shape; what the tool looks like
        is an object on the same link (`add`, `attach`), and `on` may be that object: the frame moves along.
        `move` and `remove` take its name.

        Args:
            name: Not taken by a frame of the robot or an object.
            on: A link, a tool frame or an object.
            placement: Of the frame in that one; at its origin when None.

        Raises:
            ModelError: If the name is taken or empty, or `on` is the world.
            FrameNotFound: If `on` is unknown.
            ShapeError: If the placement is none.
        """
        if name_of("tool frame", name) in (WORLD, "", *self.frame_names, *self.objects):
            taken = "a frame of the robot" if name in self.frame_names else "an object"
            why = f"is taken by {taken if name != WORLD else 'the world'}" if name else "is empty"
            raise ModelError(f"tool frame {shown(name)} {why}: name it differently")
        if one_of("on", on, str) == WORLD:
            raise ModelError(f"{shown(name)} would stand in the world, not on the robot: add it as an object")
        if on not in self.frame_names and on not in self.objects:
            raise FrameNotFound("frame", on, self.frame_names, objects=self.objects)
        return self._with_tool(SceneObject(name, (), object_placement(name, placement), on))

    def still_at(self, time: float) -> Scene:
        """Return the scene as it stands at a time of its clock [s]: nothing in it changes any more.

        What is not known any more stands where it was known last; errors of predictions are left out. What is
        not there then is left out, unless something is placed in it.

        Raises:
            ShapeError: If the time is no finite number.
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
            ModelError: If an object or a tool's frame is placed in its frame.
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
        """Place an object, or the frame of a tool, elsewhere, in its present frame or another.

        One that moves rests there from now on.

        Raises:
            ObjectNotFound: If there is none of that id.
            FrameNotFound: If the frame is unknown.
            ModelError: If it would be placed in itself, or a tool's frame in the world.
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
            raise ModelError(f"{shown(name)} would stand in the world, not on the robot: add it as an object")
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
        """Fix an object to a link, a tool frame or an object that is attached: it moves along from now on.

        An object that moves by itself can carry others too: a tray on a conveyor.

        Args:
            name: The object's id.
            link: The link, tool frame, attached object or object that moves.
            placement: Of the object in the link's frame; or
            at: Configuration at which it is grasped where it stands, in any of its forms; of what
                moves by itself, where it is when the clock shows 0.
            touch_links: Links that may touch it, beside the link itself and what is attached between; as
                for `add`.
            mass: Its mass [kg]; the one it was added with when None.
            resting_on: One or several objects or links that it stands on until it is lifted: contact is
                accepted for the first half second of a motion, to a depth of 1 mm (`allow_contact`).

        Raises:
            ObjectNotFound: If there is none of that id.
            FrameNotFound: If the link, a touch link or what it rests on is unknown.
            ModelError: Unless exactly one of `placement` and `at` is given, or if `link` stands still.
            ShapeError: If the mass is negative or not finite.
        """
        item = self.object(name)
        holder = self.holder(one_of("link", link, str)).link
        if holder == WORLD and self.carrier(link) is None:
            raise ModelError(
                f"{shown(link)} stands in the world: nothing attached to it would move; "
                f"move {shown(name)} into its frame instead"
            )
        self._check_not_within(name, link)
        if (placement is None) == (at is None):
            raise ModelError("attach: give either `placement`, in the link, or `at`, where it is grasped")
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
        """Leave an object in the world where it is at a configuration, when the clock shows 0.

        Args:
            name: The object's id.
            at: The configuration, in any of its forms: the end of a plan is one.

        Raises:
            ObjectNotFound: If there is none of that id.
            ModelError: If it is not attached.
            NameNotFound: If a state or a joint is unknown.
            ShapeError: If there is not one finite position for each joint.
        """
        item = self.object(name)
        if self.holder(name).link == WORLD and self.carrier(item.frame) is None:
            raise ModelError(f"object {shown(name)} is not attached to a link")
        where, nothing = self._placement_at(name, self._configuration("at", at)), frozenset[str]()
        return self._with(replace(item, placement=where, frame=WORLD, touch_links=nothing))

    def allow(self, a: str, b: str | None = None, *, allowed: bool = True) -> Scene:
        """Let two things touch, or one touch anything (`b` None); `allowed=False` forbids again.

        Raises:
            FrameNotFound: If a name is no link, frame or object.
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
        """Require a clearance: of everything from everything, of two named things, or by kind [m].

        `with_clearance(world=0.03)` asks for 30 mm from the world and for nothing between the robot's own
        links. The judge proves what is required, and refuses a nearer start or goal. Links nearer by design
        need a clearance of their own, by kind or by name.

        Args:
            value: Between everything, whatever its kind, or between `a` and `b`.
            a: One link, frame or object.
            b: The other.
            world: From what stands in the world, tables and floors of the robot's description too, of the
                robot and of what it carries.
            carried: Of what is carried, from everything; from the world it keeps the larger of both.
            robot: Of the robot's links from each other.

        Raises:
            ShapeError: If a clearance is negative or not finite.
            FrameNotFound: If a name is no link, frame or object.
            ModelError: If nothing is given, only one name, names without a value, or names with kinds.

        Warns:
            UnitWarning: If it is farther than any arm reaches.
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
        """Set the margin: what the optimiser keeps where it can, but the judge does not require [m].

        Args:
            margin: From everything, whatever its kind, or between `a` and `b`.
            a: One link, frame or object.
            b: The other.
            world: As for `with_clearance`.
            carried: As for `with_clearance`.
            robot: As for `with_clearance`.

        Raises:
            ShapeError: If a margin is negative or not finite.
            FrameNotFound: If a name is no link, frame or object.
            ModelError: If nothing is given, only one name, names without a margin, or names with kinds.

        Warns:
            UnitWarning: If it is farther than any arm reaches.
        """
        pair, kinds = self._asked("with_margin", margin, a, b, (world, carried, robot))
        if pair is not None and margin is not None:
            checked = replace(self, margin=margin).margin
            return replace(self, pair_margins={**self.pair_margins, pair: checked})
        if margin is not None:
            return replace(self, margin=margin, kind_margins=kinds)
        return replace(self, kind_margins={**self.kind_margins, **kinds})

    def allow_contact(
        self, name: str, a: str, b: str, *, depth: float = 1e-3, first: float = 0.0, last: float = 0.0
    ) -> Scene:
        """Accept contact of a pair during the first or last seconds of the motion.

        Args:
            name: What it is for; shown in the certificate.
            a: One link or object.
            b: The other.
            depth: Deepest penetration accepted [m].
            first: How long from the start [s].
            last: How long up to the end [s].

        Raises:
            FrameNotFound: If a name is no link, frame or object.
            ModelError: If no window is given.
            ShapeError: If a number is negative or not finite.
        """
        allowance = ContactAllowance(name, self.owner(a), self.owner(b), depth, first, last)
        return replace(self, allowances=(*self.allowances, allowance))
