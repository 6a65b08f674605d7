"""Shapes as Coal's collision geometries, and their bounding boxes and spheres."""

from collections.abc import Container, Sequence
from dataclasses import dataclass, fields
from itertools import product

import coal
import numpy as np

from trajopt.scene.reduced import ReducedModel
from trajopt.scene.scene import Scene
from trajopt.values.arrays import Floats, Ints
from trajopt.values.cached import cached_per_value
from trajopt.values.placement import WORLD, Placement
from trajopt.values.printed import in_length
from trajopt.values.shapes import shapes
from trajopt.values.shapes.clouds import Points, Voxels
from trajopt.values.shapes.mesh import Mesh
from trajopt.values.shapes.surfaces import closed_surface

PLANE_EXTENT = 1e3
"""Half the edge of the box that models a half-space [m]."""


@cached_per_value
def collision_geometry(shape: shapes.Shape) -> coal.CollisionGeometry:
    """Return Coal's geometry of a shape, in the shape's own frame; computed once for each shape.

    For a cloud it is one ball or cube about the origin: the core has their positions.
    """
    match shape:
        case shapes.Box():
            geometry = coal.Box(shape.x, shape.y, shape.z)
        case shapes.Sphere() | Points():
            geometry = coal.Sphere(shape.radius)
        case shapes.Cylinder():
            geometry = coal.Cylinder(shape.radius, shape.length)
        case shapes.Capsule():
            geometry = coal.Capsule(shape.radius, shape.length)
        case shapes.Cone():
            geometry = coal.Cone(shape.radius, shape.length)
        case shapes.Plane():
            geometry = coal.Halfspace(np.array([0.0, 0.0, 1.0]), 0.0)
        case shapes.Convex():
            surface = _surface(shape)
            surface.buildConvexRepresentation(False)  # shares no memory with the surface
            geometry = surface.convex
        case Voxels():
            geometry = coal.Box(shape.size, shape.size, shape.size)
        case Mesh():
            geometry = _surface(shape)
            geometry.endModel()
    geometry.computeLocalAABB()
    return geometry


def _surface(shape: shapes.Convex | Mesh) -> coal.BVHModelOBBRSS:
    surface = coal.BVHModelOBBRSS()
    surface.beginModel(len(shape.faces), len(shape.vertices))
    surface.addVertices(np.ascontiguousarray(shape.vertices))
    surface.addTriangles(np.ascontiguousarray(shape.faces, dtype=np.int64))
    return surface


def closed_triangles(shape: shapes.Shape) -> Floats:
    """Return the triangles that can enclose a body without touching it, shape (k, 3, 3) [m]."""
    return closed_surface(shape).triangles if isinstance(shape, Mesh) else np.empty((0, 3, 3))


@dataclass(frozen=True, eq=False)
class BoundingBoxes:
    """Bounding boxes of B bodies, and the spheres around those.

    Attributes:
        joint: Joint that carries each body; 0 is the world, shape (B,).
        rotation: Of each body's shape in the joint's frame, shape (B, 3, 3).
        translation: Of the shape's origin there, shape (B, 3) [m].
        centre: Of the box there, shape (B, 3) [m].
        half: Half the box's edges, along the shape's axes, shape (B, 3) [m].
        radius: Of the sphere around the box, shape (B,) [m].
    """

    joint: Ints
    rotation: Floats
    translation: Floats
    centre: Floats
    half: Floats
    radius: Floats

    @staticmethod
    def of(reduced: ReducedModel) -> "BoundingBoxes":
        """Bound the bodies of a reduced model."""
        bodies = reduced.bodies
        joint = np.array([body.joint for body in bodies], dtype=np.int64)
        rotation = np.array([body.placement.rotation for body in bodies]).reshape(-1, 3, 3)
        translation = np.array([body.placement.translation for body in bodies]).reshape(-1, 3)
        corners = np.array([_corners(body.shape) for body in bodies]).reshape(-1, 2, 3)
        lower, upper = np.clip(corners, -PLANE_EXTENT, PLANE_EXTENT).transpose(1, 0, 2)
        centre = (rotation @ (0.5 * (lower + upper))[:, :, None])[:, :, 0] + translation
        half = 0.5 * (upper - lower)
        return BoundingBoxes(joint, rotation, translation, centre, half, np.linalg.norm(half, axis=1))

    @staticmethod
    def joined(several: Sequence["BoundingBoxes"]) -> "BoundingBoxes":
        """Return the boxes of several lists of bodies, in order."""
        names = [each.name for each in fields(BoundingBoxes)]
        return BoundingBoxes(*(np.concatenate([getattr(each, name) for each in several]) for name in names))

    def take(self, numbers: Ints) -> "BoundingBoxes":
        """Return the boxes with these numbers."""
        return BoundingBoxes(*(getattr(self, each.name)[numbers] for each in fields(self)))


@cached_per_value
def _corners(shape: shapes.Shape) -> Floats:
    return np.array(shapes.bounding_box(shape))


TOUCHING = 2e-3
"""Things closer than this are in contact [m]."""


def gap(first: Placement, shape: shapes.Shape, second: Placement, other: shapes.Shape) -> float:
    """Return the distance of two shapes, negative if they overlap [m]; infinite for far clouds."""
    (centre, radius), (far, reach) = shapes.bounding_sphere(shape), shapes.bounding_sphere(other)
    ones = shapes.solids_near(shape, first, second * far, reach + TOUCHING)
    others = shapes.solids_near(other, second, first * centre, radius + TOUCHING)
    return min((_convex_gap(*one, *each) for one, each in product(ones, others)), default=np.inf)


def inside_carriers(reduced: ReducedModel) -> tuple[str, ...]:
    """Return the attached objects inside a link that moves with them, deeper than in contact.

    No motion changes the depth, so planning and judge ignore it: an object in a closed
    finger, or in the palm.
    """
    scene, links = reduced.scene, set(reduced.scene.robot.links)
    depths: dict[tuple[str, str], float] = {}
    for body in reduced.bodies:
        if body.owner in links or scene.holder(body.owner).link == WORLD:
            continue
        for other in reduced.bodies:
            if other.joint == body.joint and other.owner in links:
                deep = -gap(body.placement, body.shape, other.placement, other.shape)
                pair = (body.owner, other.owner)
                depths[pair] = max(deep, depths.get(pair, 0.0))
    return tuple(
        f"{name} is {in_length(deep)} inside {link}: they move together, so nothing keeps them apart"
        for (name, link), deep in depths.items()
        if deep > TOUCHING
    )


def _convex_gap(shape: shapes.Shape, first: Placement, other: shapes.Shape, second: Placement) -> float:
    return float(
        coal.distance(
            collision_geometry(shape),
            _transform(first),
            collision_geometry(other),
            _transform(second),
            coal.DistanceRequest(),
            coal.DistanceResult(),
        )
    )


def _transform(placement: Placement) -> coal.Transform3s:
    return coal.Transform3s(np.array(placement.rotation), np.array(placement.translation))


def distance_from(
    scene: Scene, name: str, links: Container[str], at: Floats, stands: Placement | None = None
) -> float:
    """Return the distance of an object from the bodies of links, negative if they overlap [m].

    Args:
        at: Positions of all joints, shape (number of joints,) [rad | m].
        stands: Placement of the object; as in the scene if None.
    """
    place, parts = stands or scene.placement_of(name, at), scene.object(name).parts
    bodies = [
        (scene.placement_of(body.frame, at) * body.placement, body.shape)
        for body in scene.robot.bodies
        if body.owner in links
    ]
    gaps = (gap(place * where, shape, *body) for shape, where in parts for body in bodies)
    return min(gaps, default=np.inf)


def supports(scene: Scene, name: str, where: Placement) -> tuple[str, ...]:
    """Return the objects, at rest or moved by themselves, that an object touches at time 0.

    Args:
        where: Its placement in the world.
    """
    own = [(where * placed, shape) for shape, placed in scene.object(name).parts]
    found = (
        body.owner
        for body in scene.object_bodies()
        if body.owner != name
        and body.frame == WORLD
        and any(abs(gap(placed, shape, body.placement, body.shape)) < TOUCHING for placed, shape in own)
    )
    return tuple(dict.fromkeys(found))
