"""The query in plain Python, configuration by configuration and pair by pair."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial

import coal
import numpy as np
import pinocchio as pin

from trajopt.geometry import Contacts, JointPlacements, Query, WorkCounts, point_jacobian
from trajopt.geometry.dynamics import DynamicsQuery, GravityTorques, TorqueSlopes
from trajopt.geometry.geometry import PLANE_EXTENT, BoundingBoxes, closed_triangles, collision_geometry
from trajopt.geometry.query import EPA_TOLERANCES, GJK_TOLERANCE
from trajopt.scene.reduced import ReducedModel
from trajopt.values.arrays import Floats
from trajopt.values.shapes.mesh import Mesh
from trajopt.values.shapes.shapes import Shape
from trajopt.values.shapes.surfaces import part_points


class PlainQuery(Query):
    """Evaluates configuration by configuration and pair by pair."""

    def __init__(self, reduced: ReducedModel, counts: WorkCounts | None = None) -> None:
        """Build Coal's geometries and the bounding volumes."""
        super().__init__(reduced, counts)
        self._data = reduced.model.createData()
        self._boxes = BoundingBoxes.of(reduced)
        self._distances = PairDistances(reduced, self._boxes)

    def kinematics(self, positions: Floats) -> JointPlacements:
        """Place all joints at configurations of shape (S, n); see `Query.kinematics`."""
        model, data = self.reduced.model, self._data
        count, joints = len(positions), model.njoints
        placements = np.empty((count, joints, 4, 4))
        jacobian = np.empty((count, 6, model.nv))
        for row, position in enumerate(positions):
            pin.computeJointJacobians(model, data, self.reduced.configuration(position))
            placements[row] = [placement.np for placement in data.oMi.tolist()]
            jacobian[row] = data.J.reshape(6, -1)  # of one joint Pinocchio hands out a vector
        self.counts.forward_kinematics += count
        return JointPlacements(placements[:, :, :3, :3], placements[:, :, :3, 3], jacobian)

    def close_pairs(self, positions: Floats, reach: Floats, aim: Floats | None = None) -> Contacts:
        """Measure every pair that is nearer than its reach; see `Query.close_pairs`."""
        del aim  # all distances are exact
        at, pairs = self.kinematics(positions), self.reduced.pairs
        candidates = np.argwhere(self._lower_bounds(at) < reach)
        self.counts.bounds += len(positions) * len(reach)
        self.counts.distances += len(candidates)
        found: list[tuple[int, int, Measured]] = []
        for sample, pair in candidates.tolist():
            measured = self._distances(at, sample, pair, float(reach[pair]))
            if measured is not None:
                found.append((sample, pair, measured))
        sample = np.array([item[0] for item in found], dtype=np.int64)
        pair = np.array([item[1] for item in found], dtype=np.int64)
        normal, first, second = (
            np.array([getattr(item[2], name) for item in found]).reshape(-1, 3)
            for name in ("normal", "point_first", "point_second")
        )
        jacobian, joint = at.jacobian[sample], self._boxes.joint
        moved = partial(point_jacobian, self.reduced, jacobian)
        velocity = moved(joint[pairs.second[pair]], second) - moved(joint[pairs.first[pair]], first)
        return Contacts(
            sample,
            pair,
            np.array([item[2].distance for item in found], dtype=np.float64),
            normal,
            first,
            second,
            np.einsum("mi,min->mn", normal, velocity),
        )

    def displacement(self, start: Floats, end: Floats) -> Floats:
        """Bound the motion between configurations; see `Query.displacement`."""
        boxes = self._boxes
        moving = np.flatnonzero((boxes.joint > 0) & (boxes.radius < PLANE_EXTENT))
        rotation, centre = self._frames(self.kinematics(start))
        other_rotation, other_centre = self._frames(self.kinematics(end))
        shift = np.linalg.norm((other_centre - centre)[:, moving], axis=2)
        turn = np.linalg.norm((other_rotation - rotation)[:, moving], axis=(2, 3)) / np.sqrt(2.0)
        return (shift + turn * boxes.radius[moving]).max(axis=1, initial=0.0)

    def _frames(self, kinematics: JointPlacements) -> tuple[Floats, Floats]:
        """Return rotations (S, B, 3, 3) and bounding centres (S, B, 3) of all bodies."""
        boxes = self._boxes
        rotation = kinematics.rotation[:, boxes.joint]
        centre = (rotation @ boxes.centre[:, :, None])[..., 0] + kinematics.translation[:, boxes.joint]
        return rotation @ boxes.rotation, centre

    def _lower_bounds(self, kinematics: JointPlacements) -> Floats:
        """Bound all distances from below by sphere against oriented box, both ways, (S, p)."""
        rotation, centre = self._frames(kinematics)
        first, second = self.reduced.pairs.first, self.reduced.pairs.second
        apart = centre[:, second] - centre[:, first]
        bound = np.full(apart.shape[:2], -np.inf)
        for box, sphere in ((first, second), (second, first)):
            local = np.abs((apart[:, :, None, :] @ rotation[:, box])[:, :, 0, :])
            outside = np.maximum(local - self._boxes.half[box], 0.0)
            reach = np.sqrt(np.einsum("spi,spi->sp", outside, outside)) - self._boxes.radius[sphere]
            np.maximum(bound, reach, out=bound)
        return bound


class PlainDynamics(DynamicsQuery):
    """One state after the other, by pinocchio's own binding."""

    def __init__(self, reduced: ReducedModel) -> None:
        """Keep the model and scratch memory of pinocchio's."""
        super().__init__(reduced)
        self._reduced = reduced
        self._data = reduced.model.createData()

    def torque(self, positions: Floats, velocities: Floats, accelerations: Floats) -> Floats:
        """Return the torques that a motion needs; see `DynamicsQuery.torque`."""
        states = self._states(positions, velocities, accelerations)
        full = np.array([pin.rnea(self._reduced.model, self._data, *state) for state in states])
        return full.reshape(len(positions), -1) @ self._reduced.mimic_matrix

    def torque_slopes(self, positions: Floats, velocities: Floats, accelerations: Floats) -> TorqueSlopes:
        """Return torques and their derivatives; see `DynamicsQuery.torque_slopes`."""
        reduced = self._reduced
        slopes = np.empty((3, len(positions), reduced.model.nv, reduced.model.nv))
        for row, (q, v, a) in enumerate(self._states(positions, velocities, accelerations)):
            found = pin.computeRNEADerivatives(reduced.model, self._data, q, v, a)
            for kind, slope in enumerate(found):
                slopes[kind, row] = slope
        moved = reduced.mimic_matrix
        return TorqueSlopes(self.torque(positions, velocities, accelerations), *(moved.T @ slopes @ moved))

    def _states(
        self, positions: Floats, velocities: Floats, accelerations: Floats
    ) -> Iterator[tuple[Floats, Floats, Floats]]:
        """Yield the model's configuration, velocity and acceleration of each of the group's states."""
        reduced = self._reduced
        moved = reduced.mimic_matrix.T
        q = np.array([reduced.configuration(row) for row in positions])
        return zip(q, velocities @ moved, accelerations @ moved, strict=True)

    def gravity(self, positions: Floats) -> GravityTorques:
        """Return the torques that hold the arm still; see `DynamicsQuery.gravity`."""
        reduced, model = self._reduced, self._reduced.model
        torque, slope = np.empty((len(positions), model.nv)), np.empty((len(positions), model.nv, model.nv))
        for row, place in enumerate(positions):
            q = reduced.configuration(place)
            slope[row] = pin.computeGeneralizedGravityDerivatives(model, self._data, q)
            torque[row] = self._data.g
        moved = reduced.mimic_matrix
        return GravityTorques(torque @ moved, moved.T @ slope @ moved)


def _request(epa_tolerance: float) -> coal.DistanceRequest:
    request = coal.DistanceRequest()
    request.enable_signed_distance = True
    request.gjk_tolerance = GJK_TOLERANCE
    request.epa_tolerance = epa_tolerance
    return request


@dataclass(frozen=True, eq=False)
class Measured:
    """Nearest points of one pair; see `Contacts` for the fields."""

    distance: float
    normal: Floats
    point_first: Floats
    point_second: Floats


class PairDistances:
    """Measures pairs with Coal; owns its scratch memory."""

    def __init__(self, reduced: ReducedModel, boxes: BoundingBoxes) -> None:
        """Build Coal's geometries."""
        self._first, self._second = reduced.pairs.first, reduced.pairs.second
        self._shapes = [body.shape for body in reduced.bodies]
        self._geometries = [collision_geometry(body.shape) for body in reduced.bodies]
        self._exact = [isinstance(body.shape, Mesh) for body in reduced.bodies]
        self._boxes = boxes
        self._requests = [_request(tolerance) for tolerance in EPA_TOLERANCES]
        self._result = coal.DistanceResult()
        self._contact_request = coal.CollisionRequest()
        self._contact_request.num_max_contacts = 64
        self._contact_request.enable_contact = True

    def __call__(self, kinematics: JointPlacements, sample: int, pair: int, reach: float) -> Measured | None:
        """Measure a pair at one of the placed configurations; None when not nearer than the reach [m]."""
        first, second = int(self._first[pair]), int(self._second[pair])
        geometries = self._geometries[first], self._geometries[second]
        places = self._transform(kinematics, sample, first), self._transform(kinematics, sample, second)
        result, distance = self._result, -np.inf
        for request in self._requests:
            result.clear()
            distance = float(
                coal.distance(geometries[0], places[0], geometries[1], places[1], request, result)
            )
            if abs(distance) < PLANE_EXTENT:
                break
        exact = self._exact[first] or self._exact[second]
        # Of what is enclosed the way to the surface counts, which is no longer than the way out.
        sign = -1.0 if exact and distance > 0.0 and self._enclosed(first, second, places) else 1.0
        if sign * distance >= reach:
            return None
        if distance <= 0.0 and exact:
            return self._deepest_contact(geometries, places)
        points = np.array(result.getNearestPoint1()), np.array(result.getNearestPoint2())
        # Between two meshes Coal leaves the normal out.
        both = self._exact[first] and self._exact[second]
        normal = (points[1] - points[0]) / distance if both else np.array(result.normal)
        return Measured(sign * distance, sign * normal, *points)

    def _transform(self, kinematics: JointPlacements, sample: int, body: int) -> coal.Transform3s:
        joint, boxes = int(self._boxes.joint[body]), self._boxes
        rotation = kinematics.rotation[sample, joint]
        return coal.Transform3s(
            rotation @ boxes.rotation[body],
            rotation @ boxes.translation[body] + kinematics.translation[sample, joint],
        )

    def _enclosed(self, first: int, second: int, places: tuple[coal.Transform3s, coal.Transform3s]) -> bool:
        """Say whether one of two bodies apart is inside the other's exact mesh."""
        for body, shell, at, around in ((first, second, *places), (second, first, *places[::-1])):
            seen = around.inverseTimes(at)
            rotation: Floats = np.array(seen.getRotation())
            translation: Floats = np.array(seen.getTranslation())
            if encloses(self._shapes[shell], self._shapes[body], rotation, translation):
                return True
        return False

    def _deepest_contact(
        self,
        geometries: tuple[coal.CollisionGeometry, coal.CollisionGeometry],
        places: tuple[coal.Transform3s, coal.Transform3s],
    ) -> Measured | None:
        """Measure a penetrating exact mesh: Coal's distance says only that it touches."""
        result = coal.CollisionResult()
        coal.collide(geometries[0], places[0], geometries[1], places[1], self._contact_request, result)
        contacts = [result.getContact(i) for i in range(result.numContacts())]
        if not contacts:
            return None
        deepest = min(contacts, key=lambda contact: contact.penetration_depth)
        return Measured(
            float(deepest.penetration_depth),
            np.array(deepest.normal),
            np.array(deepest.getNearestPoint1()),
            np.array(deepest.getNearestPoint2()),
        )


def encloses(shell: Shape, body: Shape, rotation: Floats, translation: Floats) -> bool:
    """Say whether a shape's closed surface winds around a part of a body.

    Args:
        shell: The shape.
        body: The body's.
        rotation: Of the body in the shape's frame, shape (3, 3).
        translation: Of the body there, shape (3,) [m].
    """
    triangles = closed_triangles(shell)
    if not len(triangles):
        return False
    corners = triangles.reshape(-1, 3)
    points = part_points(body) @ rotation.T + translation
    boxed = ((points >= corners.min(axis=0)) & (points <= corners.max(axis=0))).all(axis=1)
    return any(_solid_angle(triangles - point) > 2.0 * np.pi for point in points[boxed])


def _solid_angle(triangles: Floats) -> float:
    """Return the solid angle that triangles fill as seen from the origin (van Oosterom, Strackee 1983)."""
    length = np.linalg.norm(triangles, axis=2)
    cosines = np.einsum("kij,kij->ki", triangles, np.roll(triangles, -1, axis=1))
    rest = length.prod(axis=1) + (cosines * np.roll(length, -2, axis=1)).sum(axis=1)
    return float(2.0 * np.arctan2(np.linalg.det(triangles), rest).sum())
