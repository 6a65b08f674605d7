"""Convex parts of bodies as a proof states them, and their pairs."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import product

import numpy as np

from trajopt.robot.joints import FixedBody
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.track import ALWAYS, Timing
from trajopt.values.arrays import Bools, Floats, Ints
from trajopt.values.placement import Placement
from trajopt.values.shapes.clouds import Points, Voxels, centres_of
from trajopt.values.shapes.shapes import (
    Box,
    Capsule,
    Cone,
    Convex,
    Cylinder,
    Mesh,
    Plane,
    Shape,
    Sphere,
    bounding_sphere,
)
from trajopt.verify.kernel.motion import JudgedMotion, TimedMotion
from trajopt.verify.kernel.pair_distances import required_clearances
from trajopt.verify.kernel.shapes import hull_of

Document = dict[str, object]
ALL_TIME = (-np.inf, np.inf)
TOUCHING = "contact is accepted for a time, which was judged and is not part of this proof"
MEETING = "their hulls meet: only the judge proves exact meshes apart"
HALVINGS = 3
"""Halvings of a part around points of a cloud."""


@dataclass(frozen=True, eq=False)
class BodyPart:
    """A convex part: all points within a distance of the hull of some points and two discs, or a half-space.

    Attributes:
        vertices: Points of the hull, in the body's frame, shape (v, 3) [m].
        discs: Height along z and radius of each disc about the z axis, shape (d, 2) [m].
        inside: Centres of the balls or cubes of a cloud in it, shape (i, 3) [m]; none of other shapes.
    """

    body: FixedBody
    vertices: Floats
    radius: float
    discs: Floats
    inside: Floats = field(default_factory=lambda: np.zeros((0, 3)))

    @property
    def is_half_space(self) -> bool:
        return isinstance(self.body.shape, Plane)

    @property
    def sphere(self) -> tuple[Floats, float]:
        if len(self.vertices):
            centre = (self.vertices.min(axis=0) + self.vertices.max(axis=0)) / 2.0
            radius = float(np.linalg.norm(self.vertices - centre, axis=1).max()) + self.radius
        else:
            centre, radius = bounding_sphere(self.body.shape)
        return self.body.placement * centre, radius

    @property
    def middle(self) -> Floats:
        """The centre of the box around the points of a cloud, in the body's frame, (3,) [m]; else zero."""
        return (self.vertices[0] + self.vertices[-1]) / 2.0 if len(self.inside) else np.zeros(3)

    @property
    def divisible(self) -> bool:
        """Whether it is around points of a cloud that can be separated."""
        return len(self.inside) > 1 and bool(np.ptp(self.inside, axis=0).any())

    @property
    def halves(self) -> list["BodyPart"]:
        """Parts around both halves of the points of a cloud; itself if these cannot be cut."""
        if not self.divisible:
            return [self]
        along = self.inside[:, int(np.ptp(self.inside, axis=0).argmax())]
        lower = along < (along.min() + along.max()) / 2.0
        return [around_points(self.body, self.inside[side]) for side in (lower, ~lower)]

    def support(self, direction: Floats) -> Floats:
        local = direction @ self.body.placement.rotation
        base = direction @ self.body.placement.translation
        if self.is_half_space:
            return base
        if len(self.vertices):
            return base + (local @ self.vertices.T).max(axis=1) + self.radius * np.linalg.norm(local, axis=1)
        across = np.hypot(local[:, 0], local[:, 1])
        heights, radii = self.discs.T
        return base + (local[:, 2:] * heights + across[:, None] * radii).max(axis=1)

    def document(self) -> Document:
        return {
            "owner": self.body.owner,
            "place": placed(self.body.joint, self.body.placement),
            "shape": self._shape(),
        }

    def _shape(self) -> Document:
        if self.is_half_space:
            return {"kind": "half-space"}
        if len(self.vertices):
            return {"kind": "hull", "vertices": self.vertices.tolist(), "radius": self.radius}
        (low, bottom), (high, top) = self.discs.tolist()
        return {"kind": "frustum", "bottom": bottom, "top": top, "length": high - low}


def placed(joint: int, where: Placement) -> Document:
    x, y, z, w = where.quaternion.tolist()
    return {"joint": joint, "rotation": [w, x, y, z], "translation": where.translation.tolist()}


def convex_part(body: FixedBody) -> BodyPart | None:
    found = _outline(body.shape)
    return None if found is None else BodyPart(body, *found)


def cloud_centres(body: FixedBody) -> Floats:
    return centres_of(body.shape) if isinstance(body.shape, Points | Voxels) else np.zeros((0, 3))


def around_points(body: FixedBody, centres: Floats) -> BodyPart:
    """Return a part around some balls or cubes of a cloud: all points near the box around the centres."""
    low, high = centres.min(axis=0), centres.max(axis=0)
    radius = body.shape.radius if isinstance(body.shape, Points) else 0.0
    if isinstance(body.shape, Voxels):
        half = body.shape.size / 2.0
        low, high = np.nextafter(low - half, -np.inf), np.nextafter(high + half, np.inf)
    corners = np.unique(np.where(_CORNERS, high, low), axis=0)
    return BodyPart(body, corners, radius, np.zeros((0, 3)), centres)


_CORNERS = np.array(np.meshgrid((False, True), (False, True), (False, True))).reshape(3, 8).T


def convex_parts(reduced: ReducedModel) -> tuple[BodyPart, ...]:
    return tuple(part for part in map(convex_part, reduced.bodies) if part is not None)


def _outline(shape: Shape) -> tuple[Floats, float, Floats] | None:
    nothing = np.zeros((0, 3))
    match shape:
        case Box(x=x, y=y, z=z):
            signs = np.array(np.meshgrid((-0.5, 0.5), (-0.5, 0.5), (-0.5, 0.5))).reshape(3, 8).T
            return signs * (x, y, z), 0.0, nothing
        case Sphere(radius=radius):
            return np.zeros((1, 3)), radius, nothing
        case Capsule(radius=radius, length=length):
            return np.array(((0.0, 0.0, -length / 2.0), (0.0, 0.0, length / 2.0))), radius, nothing
        case Cylinder(radius=radius, length=length):
            return nothing, 0.0, np.array(((-length / 2.0, radius), (length / 2.0, radius)))
        case Cone(radius=radius, length=length):
            return nothing, 0.0, np.array(((-length / 2.0, radius), (length / 2.0, 0.0)))
        case Convex(vertices=vertices):
            return vertices, 0.0, nothing
        case Mesh():
            return hull_of(shape).vertices, 0.0, nothing
        case Plane():
            return nothing, 0.0, nothing
        case _:
            return None


@dataclass(frozen=True, eq=False)
class Pairs:
    """Pairs of convex parts in a proof.

    Attributes:
        pairs: Indices of two parts in each row, shape (p, 2).
        required: Clearance of each pair, shape (p,) [m].
        excused: Two owners, and the reason why they need not keep apart.
        changes: Objects that are not always there, or only near their place.
        contacts: Owners that keep apart only from the first time until the second [s].
    """

    parts: tuple[BodyPart, ...]
    pairs: Ints
    required: Floats
    excused: tuple[tuple[str, str, str], ...]
    changes: Mapping[str, Timing]
    contacts: Mapping[frozenset[str], tuple[float, float]]
    knots: Floats
    first_driven: int

    @property
    def driven(self) -> Bools:
        joints = np.array([part.body.joint for part in self.parts], dtype=np.int64)
        return np.any(joints[self.pairs] >= self.first_driven, axis=1)

    @property
    def clouds(self) -> list[Document]:
        """The requirements by which balls and cubes of clouds are within parts."""
        bodies = {id(part.body): part.body for part in self.parts if len(part.inside)}
        return [
            {
                "kind": "cloud",
                "owner": body.owner,
                "cubes": isinstance(body.shape, Voxels),
                "size": body.shape.size / 2.0 if isinstance(body.shape, Voxels) else body.shape.radius,
                "inside": [
                    [number, part.inside.tolist()]
                    for number, part in enumerate(self.parts)
                    if part.body is body
                ],
            }
            for body in bodies.values()
            if isinstance(body.shape, Points | Voxels)
        ]

    @property
    def growth(self) -> Floats:
        error = [np.zeros(3) if timing.motion is None else timing.motion.error for timing in self.timings]
        return np.array(error).reshape(-1, 3)[self.pairs].sum(axis=1)

    @property
    def present(self) -> Floats:
        appears = np.array([timing.appears for timing in self.timings])[self.pairs].max(axis=1)
        expires = np.array([timing.expires for timing in self.timings])[self.pairs].min(axis=1)
        spans = np.array(
            [self.contacts.get(_owners(self.parts, *row), ALL_TIME) for row in self.pairs.tolist()]
        )
        since, until = spans.reshape(-1, 2).T
        return np.stack((np.maximum(appears, since), np.minimum(expires, until)), axis=1)

    @property
    def timings(self) -> list[Timing]:
        return [self.changes.get(part.body.owner, ALWAYS) for part in self.parts]

    def coarse(self, lost: Collection[int]) -> tuple[int, ...]:
        """Return the parts of lost pairs around several points of a cloud."""
        among: set[int] = {part for pair in lost for part in self.pairs[pair].tolist()}
        return tuple(part for part in sorted(among) if self.parts[part].divisible)

    def cut(self, coarse: Collection[int]) -> tuple["Pairs", Bools]:
        """Return the pairs of the pieces of some parts, and which pairs stay."""
        parts, pieces = list(self.parts), dict[int, list[int]]()
        for part in coarse:
            cut = [self.parts[part]]
            for _ in range(HALVINGS):
                cut = [half for each in cut for half in each.halves]
            pieces[part] = [part, *range(len(parts), len(parts) + len(cut) - 1)]
            parts[part] = cut[0]
            parts += cut[1:]
        kept = np.array([pieces.keys().isdisjoint(pair) for pair in self.pairs.tolist()], dtype=np.bool_)
        rows = [
            (row, (one, other))
            for row in np.flatnonzero(~kept).tolist()
            for one, other in product(*(pieces.get(part, [part]) for part in self.pairs[row].tolist()))
        ]
        finer, origin = np.array([pair for _, pair in rows]).reshape(-1, 2), [row for row, _ in rows]
        return replace(self, parts=tuple(parts), pairs=finer, required=self.required[origin]), kept

    def owners(self, pair: int) -> frozenset[str]:
        one, other = self.pairs[pair].tolist()
        return _owners(self.parts, one, other)

    def excusable(self, pair: int) -> bool:
        """Return whether a proof may excuse a pair: exact meshes, or contact that is accepted for a time."""
        shapes = (self.parts[int(part)].body.shape for part in self.pairs[pair])
        return self.owners(pair) in self.contacts or any(isinstance(shape, Mesh) for shape in shapes)

    def excusing(self, lost: Collection[int]) -> "Pairs":
        """Return the pairs of other owners, with the owners of lost pairs excused."""
        gone = {self.owners(pair) for pair in lost}
        kept = [self.owners(pair) not in gone for pair in range(len(self.pairs))]
        excused = tuple(
            (min(owners), max(owners), TOUCHING if owners in self.contacts else MEETING) for owners in gone
        )
        contacts = {owners: span for owners, span in self.contacts.items() if owners not in gone}
        return replace(
            self,
            pairs=self.pairs[kept],
            required=self.required[kept],
            excused=self.excused + excused,
            contacts=contacts,
        )


def proven_pairs(motion: JudgedMotion) -> Pairs:
    """Return the convex parts of a model and their pairs, and the pairs of owners excused."""
    among, own = motion.among, int(motion.reduced.model.njoints)
    reduced, timed = among.reduced, among.timed if isinstance(among, TimedMotion) else None
    times = timed.driven.times if timed is not None and timed.driven.names else np.zeros(0)
    parts, place = _all_parts(reduced.bodies)
    contacts = _contacts(motion)
    required = required_clearances(reduced) + reduced.pairs.error
    rows: list[tuple[int, int]] = []
    levels: list[float] = []
    excused: dict[frozenset[str], str] = {}
    listed: set[frozenset[str]] = set()
    for pair, (one, other) in enumerate(zip(reduced.pairs.first, reduced.pairs.second, strict=True)):
        bodies = [parts[place[int(body)]] for body in (one, other)]
        owners = frozenset(reduced.owners(pair))
        listed.add(owners)
        if contacts.get(owners, ALL_TIME)[0] >= contacts.get(owners, ALL_TIME)[1]:
            excused[owners] = "contact is accepted at all times, to a depth that was judged"
        elif any(part.is_half_space and part.body.joint for part in bodies):
            excused[owners] = "a half-space moves, which was judged and is not part of this proof"
        else:
            rows.append((place[int(one)], place[int(other)]))
            levels.append(float(required[pair]))
    for one, first in enumerate(parts):
        for second in parts[one + 1 :]:
            owners = frozenset((first.body.owner, second.body.owner))
            joints = first.body.joint, second.body.joint
            moves = joints[0] != joints[1] and any(0 < joint < own for joint in joints)
            if moves and len(owners) == 2 and owners not in listed:
                excused[owners] = "the scene accepts their contact"
    kept = [row for row, (one, other) in enumerate(rows) if _owners(parts, one, other) not in excused]
    return Pairs(
        parts,
        np.array(rows, dtype=np.int64).reshape(-1, 2)[kept],
        np.array(levels, dtype=np.float64)[kept],
        tuple((min(owners), max(owners), reason) for owners, reason in excused.items()),
        {} if timed is None else timed.timings,
        {owners: span for owners, span in contacts.items() if owners not in excused},
        times[(times > 0.0) & (times < motion.duration)],
        own,
    )


def _all_parts(bodies: Sequence[FixedBody]) -> tuple[tuple[BodyPart, ...], list[int]]:
    """Return parts of bodies, those around whole clouds last, and the number of each body's part."""
    found = [convex_part(body) for body in bodies]
    order = sorted(range(len(bodies)), key=lambda body: found[body] is None)
    parts = [found[body] or around_points(bodies[body], cloud_centres(bodies[body])) for body in order]
    return tuple(parts), np.argsort(order).tolist()


def _contacts(motion: JudgedMotion) -> dict[frozenset[str], tuple[float, float]]:
    """Return from when until when owners keep apart whose contact is accepted first or last."""
    found: dict[frozenset[str], tuple[float, float]] = {}
    reduced = motion.among.reduced
    for pair, allowance in reduced.pairs.allowances:
        owners = frozenset(reduced.owners(pair))
        since, until = found.get(owners, ALL_TIME)
        since = max(since, allowance.first) if allowance.first > 0.0 else since
        until = (
            min(until, motion.duration - motion.staying - allowance.last) if allowance.last > 0.0 else until
        )
        found[owners] = since, until
    return found


def _owners(parts: Sequence[BodyPart], one: int, other: int) -> frozenset[str]:
    return frozenset((parts[one].body.owner, parts[other].body.owner))
