"""The judge's own signed distances between the bodies of a reduced model."""

import coal
import numpy as np
import pinocchio as pin

from trajopt.arrays import Bools, Floats, Ints
from trajopt.errors import ModelError, ShapeError
from trajopt.model.placement import Placement
from trajopt.model.reduced import FixedBody, ReducedModel
from trajopt.model.shapes import Convex, Mesh, Plane, Shape, bounding_sphere, convex
from trajopt.verify.coal_geometry import coal_geometry
from trajopt.verify.enclosure import inside, representatives
from trajopt.verify.half_space import height_above
from trajopt.verify.kinematics import Poses

COAL_TOLERANCE = 1e-7
"""Coal's distance may exceed the true one by this [m]."""
_MOST_ITERATIONS = 512
_THICKENING = 1e-5


class Distances:
    """Workspace for signed distances of pairs of bodies; one for each thread.

    A distance is positive between bodies apart and minus the depth in penetration. Those of
    half-spaces are exact. An exact mesh has no depth: in contact its convex hull stands for it.

    Attributes:
        first: Index of the first body of each pair, shape (p,).
        second: Index of the second, shape (p,).
        centre: Centre of each body's bounding sphere in its joint's frame, shape (b, 3) [m].
        radius: Radius of each, infinite for planes, shape (b,) [m].
        joint: Joint that carries each body, shape (b,).
        calls: Distances measured so far.
    """

    def __init__(self, reduced: ReducedModel, *, error: float) -> None:
        """Build Coal's geometries.

        Args:
            reduced: The model.
            error: Taken off every distance [m].

        Raises:
            ModelError: If two half-spaces have to keep apart.
        """
        self.first, self.second = reduced.pairs.first, reduced.pairs.second
        self.calls = 0
        self._bodies, self._error = reduced.bodies, error
        self._model, self._data = reduced.model, reduced.model.createData()
        spheres = [bounding_sphere(body.shape) for body in self._bodies]
        self.centre: Floats = np.array(
            [body.placement * centre for body, (centre, _) in zip(self._bodies, spheres, strict=True)]
        ).reshape(-1, 3)
        self.radius: Floats = np.array([radius for _, radius in spheres])
        self.joint: Ints = np.array([body.joint for body in self._bodies], dtype=np.int64)
        planes = self._are(Plane)
        self.planar: Bools = planes[self.first] | planes[self.second]
        both = planes[self.first] & planes[self.second]
        if both.any():
            pair = int(both.argmax())
            raise ModelError(f"half-spaces {self.pair_name(pair)} meet always; allow their contact")
        self._plane_first = planes[self.first]
        meshes = self._are(Mesh)
        self._meshed = (meshes[self.first] | meshes[self.second]) & ~self.planar
        self._hulls: dict[int, int] = {}
        self._geometry = self._build()
        self._results = self._geometry.createData()
        for request in self._results.distanceRequests:
            request.enable_signed_distance = True
            request.gjk_tolerance = request.epa_tolerance = COAL_TOLERANCE
            request.gjk_max_iterations = request.epa_max_iterations = _MOST_ITERATIONS

    def owners(self, pair: int) -> tuple[str, str]:
        """Return the links or objects of a pair."""
        one, other = self._ends(pair)
        return one.owner, other.owner

    def pair_name(self, pair: int) -> str:
        """Return the links or objects of a pair as one text."""
        return " - ".join(self.owners(pair))

    def apart(self, centres: Floats, cell: Ints, pair: Ints) -> Floats:
        """Bound distances from below by bounding spheres.

        Args:
            centres: Of the bodies' spheres in the world, for c configurations, (c, b, 3) [m].
            cell: Which configuration, shape (i,).
            pair: Which pair, shape (i,).

        Returns:
            Shape (i,) [m]; minus infinity for half-spaces.
        """
        first, second = self.first[pair], self.second[pair]
        between = centres[cell, first] - centres[cell, second]
        spread = np.sqrt(np.einsum("ij,ij->i", between, between))
        return spread - self.radius[first] - self.radius[second]

    def measure(self, poses: Poses, cell: Ints, pair: Ints) -> Floats:
        """Measure signed distances, less the error they may have.

        Args:
            poses: Of the robot at c configurations.
            cell: Which configuration, shape (i,).
            pair: Which pair, shape (i,).

        Returns:
            Shape (i,) [m].
        """
        self.calls += len(cell)
        result = np.empty(len(cell))
        planar = self.planar[pair]
        for number in np.unique(pair[planar]).tolist():
            chosen = planar & (pair == number)
            result[chosen] = self._height(poses, cell[chosen], number)
        solid = np.flatnonzero(~planar)
        order = solid[np.argsort(cell[solid], kind="stable")]
        at = -1
        for item, row, number in zip(order.tolist(), cell[order].tolist(), pair[order].tolist(), strict=True):
            if row != at:
                at = row
                pin.forwardKinematics(self._model, self._data, poses.configurations[row])
                pin.updateGeometryPlacements(self._model, self._data, self._geometry, self._results)
            result[item] = self._distance(number)
        return result - self._error

    def hull_distance(self, poses: Poses, cell: int, pair: int) -> float:
        """Measure a pair with the convex hulls of meshes in their place."""
        pin.forwardKinematics(self._model, self._data, poses.configurations[cell])
        pin.updateGeometryPlacements(self._model, self._data, self._geometry, self._results)
        self.calls += 1
        return self._coal(self._hulls.get(pair, pair)) - self._error

    def meshed(self, pair: Ints) -> Bools:
        """Say which pairs have an exact mesh in them (and no half-space)."""
        return self._meshed[pair]

    def enclosed(self, poses: Poses, cell: int) -> Ints:
        """Return the pairs of which one body is enclosed by the other's exact mesh."""
        found: list[int] = []
        for pair in np.flatnonzero(self._meshed).tolist():
            one, other = self._ends(pair)
            for body, shell in ((one, other), (other, one)):
                if isinstance(shell.shape, Mesh):
                    seen = _placed(shell, poses, cell).inverse() * _placed(body, poses, cell)
                    if inside(seen * representatives(body.shape), shell.shape).any():
                        found.append(pair)
                        break
        return np.array(found, dtype=np.int64)

    def _ends(self, pair: int) -> tuple[FixedBody, FixedBody]:
        return self._bodies[int(self.first[pair])], self._bodies[int(self.second[pair])]

    def _are(self, kind: type[Shape]) -> Bools:
        return np.array([isinstance(body.shape, kind) for body in self._bodies], dtype=np.bool_)

    def _coal(self, pair: int) -> float:
        found = pin.computeDistance(self._geometry, self._results, pair)
        return float(found.min_distance)

    def _distance(self, pair: int) -> float:
        distance = self._coal(pair)
        if distance <= 0.0 and pair in self._hulls:
            return min(distance, self._coal(self._hulls[pair]))
        return distance

    def _height(self, poses: Poses, cell: Ints, pair: int) -> Floats:
        first, second = self._ends(pair)
        plane, body = (first, second) if self._plane_first[pair] else (second, first)
        plane_rotation, point = _in_world(plane, poses, cell)
        rotation, origin = _in_world(body, poses, cell)
        return height_above(
            body.shape,
            rotation=rotation,
            origin=origin,
            normal=plane_rotation[..., 2],
            point=point,
        )

    def _build(self) -> pin.GeometryModel:
        """Make pinocchio's geometry model: our pairs first, those with hulls behind."""
        model = pin.GeometryModel()
        for body in self._bodies:
            _add(model, body, coal_geometry(body.shape))
        for one, other in zip(self.first.tolist(), self.second.tolist(), strict=True):
            model.addCollisionPair(pin.CollisionPair(one, other))
        hulls: dict[int, int] = {}
        for pair in np.flatnonzero(self._meshed).tolist():
            ends = (int(self.first[pair]), int(self.second[pair]))
            for end in ends:
                body = self._bodies[end]
                if isinstance(body.shape, Mesh) and end not in hulls:
                    hulls[end] = _add(model, body, coal_geometry(_hull(body.shape)))
            self._hulls[pair] = len(model.collisionPairs)
            model.addCollisionPair(pin.CollisionPair(*(hulls.get(end, end) for end in ends)))
        return model


def _hull(mesh: Mesh) -> Convex:
    """Hull of a mesh; a flat one is thickened a little, as a hull needs volume."""
    try:
        return convex(mesh.vertices)
    except ShapeError:
        nudge = _THICKENING * np.vstack((np.eye(3), -np.eye(3)))
        return convex((mesh.vertices[:, None] + nudge).reshape(-1, 3))


def _add(model: pin.GeometryModel, body: FixedBody, geometry: coal.CollisionGeometry) -> int:
    where = pin.SE3(body.placement.rotation, body.placement.translation)
    name = f"{model.ngeoms} {body.name}"
    return int(model.addGeometryObject(pin.GeometryObject(name, body.joint, where, geometry)))


def _placed(body: FixedBody, poses: Poses, cell: int) -> Placement:
    joint = Placement(poses.rotation[cell, body.joint], poses.translation[cell, body.joint])
    return joint * body.placement


def _in_world(body: FixedBody, poses: Poses, cell: Ints) -> tuple[Floats, Floats]:
    rotation = poses.rotation[cell, body.joint]
    origin = rotation @ body.placement.translation + poses.translation[cell, body.joint]
    return rotation @ body.placement.rotation, origin
