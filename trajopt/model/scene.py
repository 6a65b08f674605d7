"""Scene: a robot among objects, and what may touch what. A value: an edit gives a new one."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace

from trajopt.arrays import Floats, Value, floats, number, one_of, several
from trajopt.errors import DuplicateObject, FrameNotFound, ModelError, ObjectNotFound, ShapeError, shown
from trajopt.model.collisions.allowed_collisions import AllowedCollisions, ContactAllowance
from trajopt.model.collisions.bodies import CollisionBody
from trajopt.model.collisions.clearances import ROOM, Clearances
from trajopt.model.description.pinocchio_model import link_placement
from trajopt.model.frame_attachment import FrameAttachment
from trajopt.model.meshes.mesh_cover import MeshPolicy
from trajopt.model.placement import IDENTITY, Placement, PlacementLike
from trajopt.model.printed import in_short
from trajopt.model.requirements import WORLD
from trajopt.model.robot import Robot
from trajopt.model.scene_object import SceneObject, checked_mass, covered_parts, object_placement
from trajopt.model.shapes import Shape

DEFAULT_MARGIN = 0.01
"""Default clearance that the optimiser aims at from everything [m]."""

FROM_SRDF = AllowedCollisions()
"""Stands for the pairs that the robot's description disables, unless another matrix is given."""


@dataclass(frozen=True, eq=False)
class Scene(Value):
    """A robot among objects.

    Attributes:
        robot: The robot.
        objects: Objects by id.
        allowed: Pairs that may touch; starts with the robot's disabled pairs.
        margin: Clearance that the optimiser keeps from everything where it can [m].
        pair_margins: The same of single pairs of links and objects, where it differs [m].
        clearances: Clearance that is required: no motion is verified that undercuts it.
        allowances: Intended contacts, for a time.
    """

    robot: Robot
    objects: Mapping[str, SceneObject] = field(default_factory=dict[str, SceneObject])
    allowed: AllowedCollisions = FROM_SRDF
    margin: float = DEFAULT_MARGIN
    pair_margins: Mapping[frozenset[str], float] = field(default_factory=dict[frozenset[str], float])
    clearances: Clearances = field(default_factory=Clearances)
    allowances: tuple[ContactAllowance, ...] = ()

    def __post_init__(self) -> None:
        """Check the margin; start from the robot's disabled pairs when no matrix was given."""
        robot, margin = one_of("robot", self.robot, Robot), number("margin", self.margin)
        if margin < 0.0:
            raise ShapeError("margin", f"is negative: {margin:g} m")
        object.__setattr__(self, "margin", margin)
        if self.allowed is FROM_SRDF:
            object.__setattr__(self, "allowed", AllowedCollisions(dict.fromkeys(robot.disabled_pairs, True)))

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
    ) -> "Scene":
        """Add an object.

        Args:
            name: Its id, not taken by another object or a frame of the robot.
            shape: One shape, or several with placements in the object's frame (none: a mere
                frame). A mesh is covered by convex pieces unless `meshes` asks for it exactly.
            placement: Of the object in `frame`; at its origin when None.
            frame: "world", a link or tool frame (it moves along then), or another object.
            touch_links: Links that may touch it.
            meshes: How meshes become convex.
            mass: Its mass [kg]; 0 where it is not known. It counts where a joint carries the object.

        Raises:
            DuplicateObject: If the id is taken.
            FrameNotFound: If `frame` or a touch link is unknown.
            ShapeError: If the mass is negative or not finite.
        """
        if one_of("the object's id", name, str) in self.objects:
            raise DuplicateObject(name)
        if not name or name == WORLD or name in self.robot.frame_names:
            raise ModelError(f"object id {shown(name)} is taken by a frame of the robot, or empty")
        self._check_frame(frame)
        parts, notes = covered_parts(name, shape, meshes or MeshPolicy())
        links = self._links(touch_links)
        where = object_placement(name, placement)
        added = SceneObject(name, parts, where, frame, links, notes, checked_mass(name, mass))
        return replace(self, objects={**self.objects, name: added})

    def remove(self, name: str) -> "Scene":
        """Remove an object.

        Raises:
            ObjectNotFound: If there is none of that id.
            ModelError: If another object is placed in its frame.
        """
        self.object(name)
        for other in self.objects.values():
            if other.frame == name:
                raise ModelError(f"{shown(other.name)} is placed in {shown(name)}; remove or move it first")
        return replace(
            self,
            objects={key: item for key, item in self.objects.items() if key != name},
            allowed=self.allowed.without(name),
            pair_margins={pair: m for pair, m in self.pair_margins.items() if name not in pair},
            clearances=self.clearances.without(name),
            allowances=tuple(item for item in self.allowances if name not in item.pair),
        )

    def move(self, name: str, placement: PlacementLike, *, frame: str | None = None) -> "Scene":
        """Place an object elsewhere, in its present frame or another.

        Raises:
            ObjectNotFound: If there is none of that id.
            FrameNotFound: If the frame is unknown.
            ModelError: If the object would be placed in itself.
        """
        item = self.object(name)
        target = item.frame if frame is None else frame
        self._check_frame(target)
        over = target
        while over in self.objects:
            if over == name:
                raise ModelError(f"object {shown(name)} cannot be placed in its own frame")
            over = self.objects[over].frame
        return self._with(replace(item, placement=object_placement(name, placement), frame=target))

    def attach(
        self,
        name: str,
        link: str,
        *,
        placement: PlacementLike | None = None,
        at: Floats | None = None,
        touch_links: Iterable[str] = (),
        mass: float | None = None,
    ) -> "Scene":
        """Fix an object to a link or tool frame: it moves along from now on.

        Args:
            name: The object's id.
            link: The link or tool frame.
            placement: Of the object in the link's frame; or
            at: Positions of all joints at which it is grasped where it stands.
            touch_links: Links that may touch it, beside the link itself.
            mass: Its mass [kg]; the one it was added with when None.

        Raises:
            ObjectNotFound: If there is none of that id.
            FrameNotFound: If the link or a touch link is unknown.
            ModelError: Unless exactly one of `placement` and `at` is given.
            ShapeError: If the mass is negative or not finite.
        """
        item = self.object(name)
        holder = self.robot.frame(link)
        if (placement is None) == (at is None):
            raise ModelError("attach: give either `placement`, in the link, or `at`, where it is grasped")
        where = object_placement(name, placement)
        if at is not None:
            where = self.placement_of(link, at).inverse() * self.placement_of(name, at)
        links = self._links(touch_links) | {holder.link} | item.touch_links
        weight = item.mass if mass is None else checked_mass(name, mass)
        return self._with(replace(item, placement=where, frame=link, touch_links=links, mass=weight))

    def detach(self, name: str, *, at: Floats) -> "Scene":
        """Leave an object in the world where it is at these positions of all joints.

        Raises:
            ObjectNotFound: If there is none of that id.
            ModelError: If it is not attached.
        """
        item = self.object(name)
        if self.holder(name).link == WORLD:
            raise ModelError(f"object {shown(name)} is not attached to a link")
        where, nothing = self.placement_of(name, at), frozenset[str]()
        return self._with(replace(item, placement=where, frame=WORLD, touch_links=nothing))

    def allow(self, a: str, b: str | None = None, *, allowed: bool = True) -> "Scene":
        """Let two things touch, or one touch anything (`b` None); `allowed=False` forbids again.

        Raises:
            FrameNotFound: If a name is neither link nor object.
        """
        for name in (a,) if b is None else (a, b):
            self._check_owner(name)
        matrix = (
            self.allowed.with_default(a, allowed) if b is None else self.allowed.with_entry(a, b, allowed)
        )
        return replace(self, allowed=matrix)

    def with_clearance(self, value: float, a: str | None = None, b: str | None = None) -> "Scene":
        """Require a clearance: of everything from everything, or between two named things [m].

        The judge proves it, and refuses a nearer start or goal. Links nearer by design need their own.

        Raises:
            ShapeError: If the clearance is negative or not finite.
            FrameNotFound: If a name is neither link nor object.
            ModelError: If only one name is given.
        """
        return replace(self, clearances=self.clearances.having(value, self._pair("with_clearance", a, b)))

    def with_margin(self, margin: float, a: str | None = None, b: str | None = None) -> "Scene":
        """Set the margin: what the optimiser keeps where it can, but the judge does not require [m].

        Raises:
            ShapeError: If the margin is negative or not finite.
            FrameNotFound: If a name is neither link nor object.
            ModelError: If only one name is given.
        """
        pair, every = self._pair("with_margin", a, b), replace(self, margin=margin)
        single = self.pair_margins if pair is None else {**self.pair_margins, pair: every.margin}
        return every if pair is None else replace(self, pair_margins=single)

    def allow_contact(
        self, name: str, a: str, b: str, *, depth: float = 1e-3, first: float = 0.0, last: float = 0.0
    ) -> "Scene":
        """Accept contact of a pair during the first or last seconds of the motion.

        Args:
            name: What it is for; shown in the certificate.
            a: One link or object.
            b: The other.
            depth: Deepest penetration accepted [m].
            first: How long from the start [s].
            last: How long up to the end [s].

        Raises:
            FrameNotFound: If a name is neither link nor object.
            ModelError: If no window is given.
            ShapeError: If a number is negative or not finite.
        """
        self._check_owner(a)
        self._check_owner(b)
        allowance = ContactAllowance(name, a, b, depth, first, last)
        return replace(self, allowances=(*self.allowances, allowance))

    def object(self, name: str) -> SceneObject:
        """Return an object.

        Raises:
            ObjectNotFound: If there is none of that id.
        """
        if one_of("object", name, str) not in self.objects:
            raise ObjectNotFound("object", name, self.objects)
        return self.objects[name]

    def holder(self, name: str) -> FrameAttachment:
        """Return the link (or "world") that a frame or object is fixed to, and where in it.

        Raises:
            FrameNotFound: If the name is no frame.
        """
        if one_of("frame", name, str) == WORLD:
            return FrameAttachment(WORLD, IDENTITY)
        if name in self.objects:
            item = self.objects[name]
            holder = self.holder(item.frame)
            return FrameAttachment(holder.link, holder.placement * item.placement)
        self._check_frame(name)
        return self.robot.frame(name)

    def placement_of(self, name: str, positions: Floats) -> Placement:
        """Return the placement in the world of a frame or object.

        Args:
            name: "world", a link, tool frame or object.
            positions: Of all joints, shape (number of joints,) [rad | m].

        Raises:
            FrameNotFound: If the name is no frame.
            ShapeError: If there is not one finite position for each joint.
        """
        at = floats("positions", positions, (len(self.robot.joint_names),))
        holder = self.holder(name)
        if holder.link == WORLD:
            return holder.placement
        return link_placement(self.robot.model, holder.link, at) * holder.placement

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
        for one, other in ((one_of("link or object", a, str), one_of("link or object", b, str)), (b, a)):
            if one in self.objects and other in self.objects[one].touch_links:
                return True
        return self.allowed.allowed(a, b)

    def margin_of(self, a: str, b: str) -> float:
        """Return the clearance that the optimiser aims at, always a little above what is required [m]."""
        margin, required = self.pair_margins.get(frozenset((a, b)), self.margin), self.clearance_of(a, b)
        return max(margin, required + ROOM) if required > 0.0 else margin

    def clearance_of(self, a: str, b: str) -> float:
        """Return the clearance that is required between two links or objects [m]."""
        holders, links = [self.holder(name).link for name in (a, b)], self.clearances.links
        padding = max(links.get(link, 0.0) for link in holders) if WORLD in holders else 0.0
        return self.clearances.pairs.get(frozenset((a, b)), max(self.clearances.everywhere, padding))

    def __repr__(self) -> str:
        """Say the robot, the objects and the distances to keep."""
        objects = in_short(", ".join(self.objects) or "no objects", 100)
        return f"Scene({shown(self.robot.name)}, {objects}; {self.distances})"

    @property
    def distances(self) -> str:
        """The distances to keep, in words."""
        return self.clearances.beside(self.margin, self.pair_margins)

    def _with(self, item: SceneObject) -> "Scene":
        return replace(self, objects={**self.objects, item.name: item})

    def _check_frame(self, name: str) -> None:
        known = (WORLD, *self.robot.frame_names, *self.objects)
        if one_of("frame", name, str) not in known:
            raise FrameNotFound("frame", name, known)

    def _check_owner(self, name: str) -> None:
        if one_of("link or object", name, str) not in self.objects and name not in self.robot.links:
            raise FrameNotFound("link or object", name, (*self.robot.links, *self.objects))

    def _pair(self, caller: str, a: str | None, b: str | None) -> frozenset[str] | None:
        if a is None or b is None:
            if a is not b:
                raise ModelError(f"{caller}: name both things or none")
            return None
        self._check_owner(a)
        self._check_owner(b)
        return frozenset((a, b))

    def _links(self, names: Iterable[str]) -> frozenset[str]:
        links = frozenset(several("touch_links", names, str))
        for link in sorted(links.difference(self.robot.links)):
            raise FrameNotFound("touch link", link, self.robot.links)
        return links
