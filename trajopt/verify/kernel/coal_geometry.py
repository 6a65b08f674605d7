"""Shapes as Coal's collision geometries, and distances between them by Coal."""

from typing import Any, TypeAlias

import coal
import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from trajopt.arrays import Floats, Ints
from trajopt.errors import ShapeError
from trajopt.model.shapes import (
    Box,
    Capsule,
    Cone,
    Convex,
    Cylinder,
    Mesh,
    Plane,
    Shape,
    Sphere,
    convex,
)
from trajopt.verify.kernel.kinematics import Poses
from trajopt.verify.kernel.placed_bodies import Solid

Indices: TypeAlias = NDArray[np.integer[Any]]

_TOLERANCE = 1e-9
"""Of distances between bodies apart [m]: smaller than the default, for better directions."""
_DEPTH_TOLERANCE = 1e-7
"""Of depths [m]: with a smaller one round shapes get wrong ones."""
_MOST_ITERATIONS = 512
_THICKENING = 1e-5


def coal_geometry(shape: Shape) -> coal.CollisionGeometry:
    """Return a shape as Coal knows it; each of Coal's shapes has its origin where ours has."""
    geometry: coal.CollisionGeometry
    match shape:
        case Box():
            geometry = coal.Box(shape.x, shape.y, shape.z)
        case Sphere():
            geometry = coal.Sphere(shape.radius)
        case Cylinder():
            geometry = coal.Cylinder(shape.radius, shape.length)
        case Capsule():
            geometry = coal.Capsule(shape.radius, shape.length)
        case Cone():
            geometry = coal.Cone(shape.radius, shape.length)
        case Plane():
            geometry = coal.Halfspace(np.array((0.0, 0.0, 1.0)), 0.0)
        case Convex():
            geometry = coal.Convex(_points(shape.vertices), _triangles(shape.faces))
        case Mesh():
            geometry = coal.BVHModelOBBRSS()
            geometry.beginModel(len(shape.faces), len(shape.vertices))
            geometry.addSubModel(_points(shape.vertices), _triangles(shape.faces))
            geometry.endModel()
    return geometry


def hull_of(mesh: Mesh) -> Convex:
    """Return the convex hull of a mesh; a flat one is thickened a little, as a hull needs volume."""
    try:
        return convex(mesh.vertices)
    except ShapeError:
        nudge = _THICKENING * np.vstack((np.eye(3), -np.eye(3)))
        return convex((mesh.vertices[:, None] + nudge).reshape(-1, 3))


class CoalPairs:
    """Workspace for Coal's distances of pairs of solids on a moving model; one for each thread."""

    def __init__(self, model: pin.Model, solids: tuple[Solid, ...], first: Ints, second: Ints) -> None:
        """Build the geometries.

        Args:
            model: Pinocchio's model.
            solids: The solids.
            first: Index of the first solid of each pair, shape (p,).
            second: Index of the second, shape (p,).
        """
        self._model, self._data = model, model.createData()
        self._geometry = pin.GeometryModel()
        for number, solid in enumerate(solids):
            where = pin.SE3(solid.placement.rotation, solid.placement.translation)
            geometry = pin.GeometryObject(
                f"{number} {solid.owner}", solid.joint, where, coal_geometry(solid.shape)
            )
            self._geometry.addGeometryObject(geometry)
        for one, other in zip(first.tolist(), second.tolist(), strict=True):
            self._geometry.addCollisionPair(pin.CollisionPair(one, other))
        self._results = self._geometry.createData()
        for request in self._results.distanceRequests:
            request.enable_signed_distance = True
            request.gjk_tolerance, request.epa_tolerance = _TOLERANCE, _DEPTH_TOLERANCE
            request.gjk_max_iterations = _MOST_ITERATIONS

    def measure(self, poses: Poses, cell: Ints, pair: Ints) -> tuple[Floats, Floats]:
        """Measure signed distances.

        Args:
            poses: Of the robot at c configurations.
            cell: Which configuration, shape (i,).
            pair: Which pair, shape (i,).

        Returns:
            Distances, shape (i,) [m], and normals from the first to the second, shape (i, 3).
        """
        distances, normals = np.empty(len(cell)), np.empty((len(cell), 3))
        order = np.argsort(cell, kind="stable")
        at = -1
        for item, row, number in zip(order.tolist(), cell[order].tolist(), pair[order].tolist(), strict=True):
            if row != at:
                at = row
                pin.forwardKinematics(self._model, self._data, poses.configurations[row])
                pin.updateGeometryPlacements(self._model, self._data, self._geometry, self._results)
            found = pin.computeDistance(self._geometry, self._results, number)
            distances[item], normals[item] = found.min_distance, found.normal
        return distances, normals


def _points(vertices: Floats) -> coal.StdVec_Vec3s:
    points = coal.StdVec_Vec3s()
    points.extend(vertices)
    return points


def _triangles(faces: Indices) -> coal.StdVec_Triangle:
    triangles = coal.StdVec_Triangle()
    triangles.extend([coal.Triangle(*face) for face in faces.tolist()])
    return triangles
