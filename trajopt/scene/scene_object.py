"""An object in the scene: shapes in a frame, with their mass and inertia."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import cast

import numpy as np
import pinocchio as pin

from trajopt.robot.bodies import MeshPolicy, cover_mesh
from trajopt.robot.joints import Anchor, FixedBody
from trajopt.scene.track import ALWAYS, Timing
from trajopt.values.arrays import Floats, Value, number
from trajopt.values.errors import ModelError, ShapeError, shown
from trajopt.values.likely_units import warn_of_far_object, warn_of_wide_mesh
from trajopt.values.placement import IDENTITY, WORLD, Placement, PlacementLike, as_placement
from trajopt.values.printed import in_number, seen_from
from trajopt.values.shapes import shapes
from trajopt.values.shapes.clouds import centres_of
from trajopt.values.shapes.mesh import Mesh
from trajopt.values.shapes.shapes import Points, Shape, Voxels

Part = tuple[Shape, Placement]
"""A shape and its placement in the object's frame."""


@dataclass(frozen=True, eq=False)
class AnchoredObject:
    """An object on its joint."""

    anchor: Anchor
    bodies: tuple[FixedBody, ...]


@dataclass(frozen=True, eq=False)
class SceneObject(Value):
    """An object in the scene.

    Attributes:
        parts: Shapes with their placements in the object's frame; empty for a frame without a shape.
        placement: Of the object's frame in `frame`, as for `Scene.add`.
        mass: Its mass [kg]; 0 if unknown.
        timing: Its existence and motion; `placement` is then its placement at time 0.
        given: Assumptions about it, as phrases that follow "proven given that" in certificates.
    """

    name: str
    parts: tuple[Part, ...]
    placement: Placement
    frame: str
    touch_links: frozenset[str] = frozenset()
    notes: tuple[str, ...] = ()
    mass: float = 0.0
    timing: Timing = ALWAYS
    given: tuple[str, ...] = ()

    def __repr__(self) -> str:
        parts = shown(self.parts[0][0]) if len(self.parts) == 1 else in_number(self.parts, "shape")
        when = "" if self.timing.always else f"; {self.timing}"
        return f"SceneObject({shown(self.name)}: {parts} at {self.placement}{seen_from(self.frame)}{when})"

    def __post_init__(self) -> None:
        placements = (self.placement, *(where for _, where in self.parts))
        for where in {id(where): where for where in placements}.values():  # pieces of a mesh share one
            as_placement(f"placement of {shown(self.name)}", where)

    def anchored(self, frame: Anchor) -> AnchoredObject:
        """Return the object fixed to the joint that carries its frame."""
        anchor = Anchor(frame.joint, frame.placement * self.placement)
        bodies = tuple(
            FixedBody(f"{self.name}/{count}", self.name, anchor.joint, anchor.placement * where, shape)
            for count, (shape, where) in enumerate(self.parts)
        )
        return AnchoredObject(anchor, bodies)

    @cached_property
    def inertia(self) -> pin.Inertia:
        """Its mass, spread evenly over its shapes, in its frame; at its origin if these have no volume."""
        whole = pin.Inertia.Zero()
        for shape, where in self.parts:
            whole += pin.SE3(where.rotation, where.translation).act(uniform_inertia(shape))
        if whole.mass <= 0.0:
            return pin.Inertia(self.mass, np.zeros(3), np.zeros((3, 3)))
        return pin.Inertia(self.mass, whole.lever, self.mass / whole.mass * whole.inertia)

    @cached_property
    def contact_traits(self) -> tuple[str, str, int, frozenset[str]]:
        """Everything that determines its pairs: all fields except its placement."""
        return (self.name, self.frame, len(self.parts), self.touch_links)

    def still_at(self, time: float) -> "SceneObject":
        """Return it at rest, at its place at a time [s] or at the last known one."""
        motion = self.timing.motion
        where = self.placement if motion is None else motion.track.at(min(time, motion.until))
        return replace(self, placement=where, timing=ALWAYS)

    def shifted(self, time: float) -> "SceneObject":
        """Return it with its clock advanced by `time` [s]; see `Timing.shifted`."""
        if self.timing.always:
            return self
        timing = self.timing.shifted(time)
        where = self.placement if timing.motion is None else timing.motion.track.at(0.0)
        return replace(self, placement=where, timing=timing)


def object_placement(name: str, value: PlacementLike | None) -> Placement:
    if value is None:
        return IDENTITY
    where = as_placement(label := f"placement of {shown(name)}", value)
    warn_of_far_object(label, where.translation)
    return where


def covered_parts(
    name: str, shape: Shape | Sequence[tuple[Shape, PlacementLike]], policy: MeshPolicy
) -> tuple[tuple[Part, ...], tuple[str, ...]]:
    """Return the parts of an object, with meshes covered by convex pieces, and notes on these.

    Args:
        shape: One shape at its origin, or several with placements in the object's frame.

    Warns:
        UnitWarning: If a mesh is wider than a robot cell.
    """
    parts: list[Part] = []
    notes: list[str] = []
    pairs = [(shape, IDENTITY)] if isinstance(shape, Shape) else shape
    if isinstance(pairs, str) or not isinstance(pairs, Iterable):  # pyright: ignore[reportUnnecessaryIsInstance]
        pairs = [cast("tuple[Shape, PlacementLike]", shape)]
    for item in pairs:
        if not _is_part(item):
            raise ModelError(f"{shown(name)}: give a shape, or pairs (shape, placement), not {shown(item)}")
        part, where = item[0], as_placement(f"placement in {shown(name)}", item[1])
        if isinstance(part, Mesh):
            if not len(part.faces):
                raise ShapeError(f"mesh of {shown(name)}", "has no face with an area")
            warn_of_wide_mesh(shown(name), part.vertices)
            cover = cover_mesh(part, policy)
            parts.extend((piece, where) for piece in cover.shapes)
            notes.append(f"{name}: {cover.note}")
        else:
            parts.append((part, where))
    return tuple(parts), tuple(notes)


def _is_part(item: object) -> bool:
    pair = cast("tuple[object, ...]", item) if isinstance(item, tuple) else ()
    return len(pair) == 2 and isinstance(pair[0], Shape)


def cloud_parts(cloud: Points | Voxels | None) -> tuple[Part, ...]:
    if not isinstance(cloud, Points | Voxels | None):  # pyright: ignore[reportUnnecessaryIsInstance]
        raise ModelError(f"cloud must be Points, Voxels or None, is {shown(cloud)}")
    return () if cloud is None else ((cloud, IDENTITY),)


def replaced_cloud(
    old: SceneObject, cloud: Points | Voxels | None, given: tuple[str, ...] = ()
) -> SceneObject:
    if not all(isinstance(shape, Points | Voxels) for shape, _ in old.parts):
        raise ModelError(
            f"{shown(old.name)} is not a cloud, and would be lost: remove it, or take another name"
        )
    parts = cloud_parts(cloud)
    return replace(old, parts=parts, placement=IDENTITY, frame=WORLD, notes=(), timing=ALWAYS, given=given)


def checked_mass(name: str, mass: float) -> float:
    checked = number(f"mass of {name}", mass)
    if checked < 0.0:
        raise ShapeError(f"mass of {name}", f"is negative: {checked:g} kg")
    return checked


THINNEST = 1e-6
"""Assumed thickness of a flat mesh [m]."""


def uniform_inertia(shape: shapes.Shape) -> pin.Inertia:
    """Return mass, centre of mass and moments of a shape of density 1 kg/m^3, in the shape's frame.

    A mesh counts as its convex hull, or as its bounding box if it is flat; balls and cubes of a cloud count
    individually, even if they overlap; a half-space has no mass.
    """
    match shape:
        case shapes.Box():
            return pin.Inertia.FromBox(shape.x * shape.y * shape.z, shape.x, shape.y, shape.z)
        case shapes.Sphere():
            return pin.Inertia.FromSphere(4.0 / 3.0 * np.pi * shape.radius**3, shape.radius)
        case shapes.Cylinder():
            volume = np.pi * shape.radius**2 * shape.length
            return pin.Inertia.FromCylinder(volume, shape.radius, shape.length)
        case shapes.Capsule():
            volume = np.pi * shape.radius**2 * (shape.length + 4.0 / 3.0 * shape.radius)
            return pin.Inertia.FromCapsule(volume, shape.radius, shape.length)
        case shapes.Cone():
            return _cone(shape)
        case shapes.Plane():
            return pin.Inertia.Zero()
        case shapes.Convex():
            return _polyhedron(shape)
        case Mesh():
            return _hull(shape)
        case shapes.Points() | shapes.Voxels():
            return _cloud(shape)


def _cone(cone: shapes.Cone) -> pin.Inertia:
    volume = np.pi * cone.radius**2 * cone.length / 3.0
    across = 3.0 / 20.0 * cone.radius**2 + 3.0 / 80.0 * cone.length**2
    moments = volume * np.diag((across, across, 3.0 / 10.0 * cone.radius**2))
    return pin.Inertia(volume, np.array((0.0, 0.0, -cone.length / 4.0)), moments)


def _polyhedron(solid: shapes.Convex) -> pin.Inertia:
    """Add up the tetrahedra between a vertex and each face.

    A tetrahedron with a corner at the origin and the others at a, b, c has six times the volume
    d = a . (b x c), the first moment d / 24 s with s = a + b + c, and the second
    d / 120 (a a' + b b' + c c' + s s') (Tonon, J. Math. Stat. 1, 2005).
    """
    origin = solid.vertices[0]
    corners = solid.vertices[solid.faces] - origin
    six = np.linalg.det(corners)
    total = corners.sum(axis=1)
    volume = six.sum() / 6.0
    centre = six @ total / 24.0 / volume
    each = np.einsum("f,fki,fkj->ij", six, corners, corners) + np.einsum("f,fi,fj->ij", six, total, total)
    return pin.Inertia(volume, origin + centre, _moments(each / 120.0 - volume * np.outer(centre, centre)))


def _hull(mesh: Mesh) -> pin.Inertia:
    try:
        return _polyhedron(shapes.convex(mesh.vertices))
    except ShapeError:  # it lies in a plane
        lower, upper = shapes.bounding_box(mesh)
        edges = np.maximum(upper - lower, THINNEST)
        box = pin.Inertia.FromBox(float(np.prod(edges)), *edges.tolist())
        return pin.Inertia(box.mass, (lower + upper) / 2.0, box.inertia)


def _cloud(cloud: shapes.Points | shapes.Voxels) -> pin.Inertia:
    one = uniform_inertia(
        shapes.Sphere(cloud.radius)
        if isinstance(cloud, shapes.Points)
        else shapes.Box(cloud.size, cloud.size, cloud.size)
    )
    centres = centres_of(cloud)
    centre = centres.mean(axis=0)
    away = centres - centre
    moments = len(centres) * one.inertia + one.mass * _moments(away.T @ away)
    return pin.Inertia(len(centres) * one.mass, centre, moments)


def _moments(second: Floats) -> Floats:
    return np.trace(second) * np.eye(3) - second
