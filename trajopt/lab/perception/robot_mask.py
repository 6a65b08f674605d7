"""The part of a cloud that is the robot itself: bounding boxes first, then the faces of each body."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from trajopt.robot.bodies import CollisionBody
from trajopt.robot.robot import Robot
from trajopt.scene.scene import Scene
from trajopt.values.arrays import Bools, Floats, Ints, floats
from trajopt.values.cached import cached_per_value
from trajopt.values.placement import WORLD, Placement
from trajopt.values.shapes import shapes
from trajopt.values.shapes.closed_surface import HOLE
from trajopt.values.shapes.mesh import Mesh


@dataclass(frozen=True, eq=False)
class _Solid:
    """A shape prepared for containment queries.

    Attributes:
        lower: Lower corner of its box, shape (3,) [m].
        upper: Upper corner of its box, shape (3,) [m].
        faces: Outward normals and offsets of flat faces, shape (k, 4); empty otherwise.
    """

    shape: shapes.Shape
    lower: Floats
    upper: Floats
    faces: Floats

    def near(self, points: Floats, padding: float) -> Bools:
        """Return the points in it or within the padding, shape (n, 3) in its frame [m].

        Complete; beyond edges and corners of flat faces some slightly farther points are included.
        """
        inside = (points >= self.lower - padding) & (points <= self.upper + padding)
        near: Bools = np.asarray(inside.all(axis=1))
        some = np.flatnonzero(near)
        if len(some):
            near[some] = self._nearer(points[some], padding)
        return near

    def _nearer(self, points: Floats, padding: float) -> Bools:
        """As `near`, for points in the padded box of the shape."""
        if len(self.faces):
            farthest: Floats = (points @ self.faces[:, :3].T + self.faces[:, 3]).max(axis=1)
            return farthest <= padding
        across, height = np.hypot(points[:, 0], points[:, 1]), points[:, 2]
        match self.shape:
            case shapes.Sphere(radius):
                return np.linalg.norm(points, axis=1) <= radius + padding
            case shapes.Cylinder(radius, _):
                return across <= radius + padding
            case shapes.Capsule(radius, length):
                return np.hypot(across, np.maximum(np.abs(height) - length / 2, 0.0)) <= radius + padding
            case shapes.Cone(radius, length):
                slant = float(np.hypot(radius, length))
                return (across - radius * (0.5 - height / length)) * length / slant <= padding
            case shapes.Points(centres, radius):
                return _within(points, centres, radius + padding)
            case shapes.Voxels():
                return _within(points, self.shape.centres, self.shape.size * np.sqrt(0.75) + padding)
            case Mesh():
                # What lies in a bin is no part of it, though it is within the bin's hull.
                near = self.shape.distance(points) <= padding
                near[~near] = self.shape.contains(points[~near], opening=HOLE)
                return near
            case _:
                return np.ones(len(points), dtype=np.bool_)


@dataclass(frozen=True, eq=False)
class RobotMask:
    """The robot with its attached objects, and known objects, in one configuration.

    Attributes:
        placements: Placement of each in the world.
    """

    solids: Sequence[_Solid]
    placements: Sequence[Placement]

    @staticmethod
    def of(scene: Scene, positions: Floats, known: Iterable[str] = ()) -> "RobotMask":
        """Place the robot in a configuration.

        Args:
            positions: Of all joints, shape (number of joints,) [rad | m].
        """
        at = floats("positions", positions, (len(scene.robot.joint_names),))
        named = {scene.object(name).name for name in known}
        solids, placements = list[_Solid](), list[Placement]()
        frames: dict[str, Placement] = {WORLD: Placement()}
        own = _solids_of(scene.robot)
        added = [body for body in scene.object_bodies() if body.frame != WORLD or body.owner in named]
        for body, solid in (*own, *((body, _solid(body.shape)) for body in added)):
            if body.frame not in frames:
                frames[body.frame] = scene.placement_of(body.frame, at)
            solids.append(solid)
            placements.append(frames[body.frame] * body.placement)
        return RobotMask(tuple(solids), tuple(placements))

    def covers(self, points: Floats, padding: float) -> Bools:
        """Return the points in it or within the padding.

        Complete; beyond edges and corners of its bodies it may extend slightly farther.

        Args:
            points: Shape (n, 3) in the world [m].
            padding: Distance [m].
        """
        covered = np.zeros(len(points), dtype=np.bool_)
        boxes = [
            _world_box(solid, where, padding)
            for solid, where in zip(self.solids, self.placements, strict=True)
        ]
        if not len(points) or not boxes:
            return covered
        # All of the robot first: most of what a camera sees is far from it.
        near = _in_box(
            points, np.min([low for low, _ in boxes], axis=0), np.max([up for _, up in boxes], axis=0)
        )
        close = points[near]
        for solid, where, (lower, upper) in zip(self.solids, self.placements, boxes, strict=True):
            some = _in_box(close, lower, upper)
            if len(some):
                covered[near[some]] |= solid.near(where.inverse() * close[some], padding)
        return covered


def _world_box(solid: _Solid, where: Placement, padding: float) -> tuple[Floats, Floats]:
    if not np.isfinite((solid.lower, solid.upper)).all():
        return np.full(3, -np.inf), np.full(3, np.inf)
    middle = where * ((solid.lower + solid.upper) / 2)
    half = np.abs(where.rotation) @ ((solid.upper - solid.lower) / 2 + padding)
    return middle - half, middle + half


def _in_box(points: Floats, lower: Floats, upper: Floats) -> Ints:
    some = np.arange(len(points))
    for axis in range(3):
        column = points[some, axis]
        some = some[(column >= lower[axis]) & (column <= upper[axis])]
    return some


@cached_per_value
def _solids_of(robot: Robot) -> tuple[tuple[CollisionBody, _Solid], ...]:
    return tuple((body, _solid(body.shape)) for body in robot.bodies)


def _solid(shape: shapes.Shape) -> _Solid:
    lower, upper = shapes.bounding_box(shape)
    faces = np.empty((0, 4))
    match shape:
        case shapes.Box():
            return _Solid(shape, lower, upper, faces)
        case shapes.Plane():
            return _Solid(shape, lower, upper, np.array(((0.0, 0.0, 1.0, 0.0),)))
        case shapes.Convex():
            faces = _faces(shape)
        case _:
            pass
    return _Solid(shape, lower, upper, faces)


def _faces(hull: shapes.Convex) -> Floats:
    """Return the planes of a hull's faces as outward normals and offsets, shape (k, 4)."""
    corners = hull.vertices[hull.faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(normals, axis=1)
    flat = lengths > 0.0
    normals = normals[flat] / lengths[flat, None]
    # Farthest over all corners: the planes of slivers are known badly, and must not cut the hull.
    return np.column_stack((normals, -(hull.vertices @ normals.T).max(axis=0)))


def _within(points: Floats, centres: Floats, reach: float) -> Bools:
    from scipy.spatial import cKDTree  # slow to import

    distances, _ = cKDTree(centres).query(points, distance_upper_bound=reach * (1.0 + 1e-9))
    return np.isfinite(distances)
