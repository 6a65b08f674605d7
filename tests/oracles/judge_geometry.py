"""Gaps between convex bodies, bodies enclosed by meshes and Coal's distances, in plain Python.

Along any unit direction n from a body A to a body B the gap min_B n x - max_A n x is a lower bound of
their signed distance, and along the best one it equals it, in penetration too. So a library for
distances need only propose directions: what is taken from them here is proven.

Distances to a mesh are distances to its triangles, so deep inside they are positive. While they are, a
body stays on the side of the surface on which it is: whether it is inside need be asked but once.
"""

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from trajopt.values.arrays import Bools, Floats, Ints
from trajopt.values.placement import Placement
from trajopt.values.shapes.mesh import Mesh
from trajopt.values.shapes.shapes import Shape
from trajopt.values.shapes.surfaces import closed_surface
from trajopt.verify.checks.distances import support
from trajopt.verify.kernel.kinematics import Poses
from trajopt.verify.kernel.shapes import coal_geometry

_TOLERANCE = 1e-9
"""Of distances between bodies apart [m]: smaller than the default, for better directions."""
_DEPTH_TOLERANCE = 1e-7
"""Of depths [m]: with a smaller one round shapes get wrong ones."""
_MOST_ITERATIONS = 512


def gap(first: Shape, second: Shape, where: Placement, directions: Floats) -> Floats:
    """Return the gap between two shapes along directions from the first to the second.

    Args:
        first: One shape.
        second: The other.
        where: Placement of the second in the first one's frame.
        directions: Unit vectors in the first one's frame, shape (c, 3).

    Returns:
        Shape (c,) [m]; negative where the shapes overlap along the direction.
    """
    between = directions @ where.translation
    return between - support(first, directions) - support(second, -directions @ where.rotation)


def inside(points: Floats, mesh: Mesh) -> Bools:
    """Say which points a mesh winds around, by the solid angle that its closed surface fills.

    Args:
        points: In the mesh's frame, shape (p, 3) [m].
        mesh: The mesh; small gaps in it do no harm, and its open sheets have no inside.

    Returns:
        Shape (p,).

    Source: van Oosterom and Strackee, IEEE Trans. Biomedical Engineering, 1983.
    """
    triangles = closed_surface(mesh).triangles
    within = ((points >= mesh.vertices.min(axis=0)) & (points <= mesh.vertices.max(axis=0))).all(axis=1)
    angle = np.zeros(len(points))
    for row in np.flatnonzero(within).tolist():
        a, b, c = np.moveaxis(triangles - points[row], 1, 0)
        la, lb, lc = (np.linalg.norm(side, axis=1) for side in (a, b, c))
        triple = np.einsum("ti,ti->t", a, np.cross(b, c))
        rest = (
            la * lb * lc
            + np.einsum("ti,ti->t", a, b) * lc
            + np.einsum("ti,ti->t", b, c) * la
            + np.einsum("ti,ti->t", c, a) * lb
        )
        angle[row] = 2.0 * np.arctan2(triple, rest).sum()
    return angle > 2.0 * np.pi


@dataclass(frozen=True, eq=False)
class Solid:
    """A shape fixed to a joint.

    Attributes:
        owner: The link or object that it is part of.
        joint: The joint.
        placement: Of the shape in the joint's frame.
        shape: The shape.
    """

    owner: str
    joint: int
    placement: Placement
    shape: Shape

    def in_world(self, poses: Poses, cell: Ints) -> tuple[Floats, Floats]:
        """Return rotation (i, 3, 3) and origin (i, 3) [m] at configurations `cell`, shape (i,)."""
        rotation = poses.rotation[cell, self.joint]
        origin = rotation @ self.placement.translation + poses.translation[cell, self.joint]
        return rotation @ self.placement.rotation, origin

    def at(self, poses: Poses, cell: int) -> Placement:
        """Return the placement in the world at one configuration."""
        joint = Placement(poses.rotation[cell, self.joint], poses.translation[cell, self.joint])
        return joint * self.placement

    def reach(self, poses: Poses, cell: Ints, directions: Floats) -> Floats:
        """Return the largest `direction @ point` over the solid's points.

        Args:
            poses: Of the robot.
            cell: Configurations, shape (i,).
            directions: Unit vectors in the world, shape (i, 3).

        Returns:
            Shape (i,) [m].
        """
        rotation, origin = self.in_world(poses, cell)
        local = np.einsum("iab,ia->ib", rotation, directions)
        return np.einsum("ij,ij->i", origin, directions) + support(self.shape, local)


def gaps(
    solids: tuple[Solid, ...], poses: Poses, cell: Ints, *, first: Ints, second: Ints, directions: Floats
) -> Floats:
    """Return gaps between solids along directions from the first to the second.

    Args:
        solids: The solids.
        poses: Of the robot.
        cell: Configurations, shape (i,).
        first: Index of the first solid, shape (i,).
        second: Index of the second solid, shape (i,).
        directions: Unit vectors in the world, shape (i, 3).

    Returns:
        Shape (i,) [m].
    """
    result = np.zeros(len(cell))
    for chosen, along in ((first, directions), (second, -directions)):
        order = np.argsort(chosen, kind="stable")
        for some in np.split(order, np.flatnonzero(np.diff(chosen[order])) + 1):
            if len(some):
                result[some] -= solids[int(chosen[some[0]])].reach(poses, cell[some], along[some])
    return result


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
