"""Signed distances of all pairs of bodies that come near, at many configurations at once."""

from dataclasses import dataclass

import coal
import numpy as np

from trajopt.arrays import Floats, Ints
from trajopt.model.mesh_file import Mesh
from trajopt.model.reduced import ReducedModel
from trajopt.model.shapes import bounding_box
from trajopt.query.geometry import collision_geometry
from trajopt.query.kinematics import Counts, Kinematics

PLANE_EXTENT = 1e3
"""Half the edge of the box that stands for a half-space when pairs are culled [m]."""

GJK_TOLERANCE = 1e-9
"""Coal's default of 1e-6 costs the same time and makes normals wrong by up to 1e-3."""
EPA_TOLERANCES = (1e-6, 1e-4)
"""For penetration, tried in turn: on curved shapes Coal's expanding polytope fails at tight ones and
reports the largest float as depth."""


def _request(epa_tolerance: float) -> coal.DistanceRequest:
    request = coal.DistanceRequest()
    request.enable_signed_distance = True
    request.gjk_tolerance = GJK_TOLERANCE
    request.epa_tolerance = epa_tolerance
    return request


@dataclass(frozen=True, eq=False)
class Contacts:
    """Nearest points of pairs that come near each other.

    Attributes:
        sample: Configuration of each contact, shape (m,).
        pair: Index of the pair, shape (m,).
        distance: Signed: positive apart, negative in penetration, shape (m,) [m].
        normal: Unit vector from the first body to the second, Coal's own (rebuilt from the
            witness points it would flip in penetration), in the world, shape (m, 3).
        point_first: Witness point on the first body, in the world, shape (m, 3) [m].
        point_second: Witness point on the second body, in the world, shape (m, 3) [m].
    """

    sample: Ints
    pair: Ints
    distance: Floats
    normal: Floats
    point_first: Floats
    point_second: Floats


class DistanceQuery:
    """Distances between the bodies of a reduced model; owns Coal's scratch, so one per thread."""

    def __init__(self, reduced: ReducedModel, counts: Counts) -> None:
        """Build Coal's geometries and the bounding volumes."""
        self._counts = counts
        bodies, pairs = reduced.bodies, reduced.pairs
        self._first, self._second = pairs.first, pairs.second
        self._geometries = [collision_geometry(body.shape) for body in bodies]
        self._exact = [isinstance(body.shape, Mesh) for body in bodies]
        self._joints = np.array([body.joint for body in bodies], dtype=np.int64)
        self._rotation = np.array([body.placement.rotation for body in bodies]).reshape(-1, 3, 3)
        self._translation = np.array([body.placement.translation for body in bodies]).reshape(-1, 3)
        boxes = [np.clip(bounding_box(body.shape), -PLANE_EXTENT, PLANE_EXTENT) for body in bodies]
        corners = np.array(boxes).reshape(-1, 2, 3)
        self._half = (corners[:, 1] - corners[:, 0]) / 2
        self._radius = np.linalg.norm(self._half, axis=1)
        self._centre = np.einsum("bij,bj->bi", self._rotation, corners.mean(axis=1)) + self._translation
        self._requests = [_request(tolerance) for tolerance in EPA_TOLERANCES]
        self._result = coal.DistanceResult()
        self._contact_request = coal.CollisionRequest()
        self._contact_request.num_max_contacts = 64
        self._contact_request.enable_contact = True

    def near(self, kinematics: Kinematics, reach: Floats) -> Contacts:
        """Measure every pair that is nearer than its reach.

        Args:
            kinematics: Of S configurations.
            reach: Distance of interest, one for each pair, shape (p,) [m].

        Returns:
            One contact for each configuration and pair with a signed distance below the reach.
        """
        candidates = np.argwhere(self._lower_bounds(kinematics) < reach)
        samples: list[int] = []
        pairs: list[int] = []
        numbers: list[tuple[float, Floats, Floats, Floats]] = []
        transforms: dict[tuple[int, int], coal.Transform3s] = {}
        for sample, pair in candidates.tolist():
            measured = self._measure(kinematics, sample, pair, transforms, float(reach[pair]))
            if measured is not None:
                samples.append(sample)
                pairs.append(pair)
                numbers.append(measured)
        self._counts.distances += len(candidates)
        count = len(samples)
        return Contacts(
            np.array(samples, dtype=np.int64),
            np.array(pairs, dtype=np.int64),
            np.array([item[0] for item in numbers], dtype=np.float64),
            np.array([item[1] for item in numbers]).reshape(count, 3),
            np.array([item[2] for item in numbers]).reshape(count, 3),
            np.array([item[3] for item in numbers]).reshape(count, 3),
        )

    def displacement(self, kinematics: Kinematics, other: Kinematics) -> Floats:
        """Bound how far any point of a body is from where it is at other configurations.

        The bound |dc| + |dR|_F / sqrt(2) r holds for the chord between the two placements: c is
        the body's centre, r the radius of its bounding sphere.

        Args:
            kinematics: Of S configurations.
            other: Of as many others.

        Returns:
            Largest bound over all bodies that move, shape (S,) [m].
        """
        moving = np.flatnonzero((self._joints > 0) & (self._radius < PLANE_EXTENT))
        rotation, centre = self._frames(kinematics)
        other_rotation, other_centre = self._frames(other)
        shift = np.linalg.norm((other_centre - centre)[:, moving], axis=2)
        turn = np.linalg.norm((other_rotation - rotation)[:, moving], axis=(2, 3)) / np.sqrt(2.0)
        return (shift + turn * self._radius[moving]).max(axis=1, initial=0.0)

    def _frames(self, kinematics: Kinematics) -> tuple[Floats, Floats]:
        """Return rotations (S, B, 3, 3) and bounding centres (S, B, 3) of all bodies."""
        rotation = kinematics.rotation[:, self._joints]
        centre = (rotation @ self._centre[:, :, None])[..., 0] + kinematics.translation[:, self._joints]
        return rotation @ self._rotation, centre

    def _lower_bounds(self, kinematics: Kinematics) -> Floats:
        """Bound all distances from below by sphere against oriented box, both ways, (S, p)."""
        rotation, centre = self._frames(kinematics)
        apart = centre[:, self._second] - centre[:, self._first]
        bound = np.full(apart.shape[:2], -np.inf)
        for box, sphere in ((self._first, self._second), (self._second, self._first)):
            local = np.abs((apart[:, :, None, :] @ rotation[:, box])[:, :, 0, :])
            outside = np.maximum(local - self._half[box], 0.0)
            reach = np.sqrt(np.einsum("spi,spi->sp", outside, outside)) - self._radius[sphere]
            np.maximum(bound, reach, out=bound)
        return bound

    def _transform(
        self,
        kinematics: Kinematics,
        sample: int,
        body: int,
        transforms: dict[tuple[int, int], coal.Transform3s],
    ) -> coal.Transform3s:
        joint = int(self._joints[body])
        key = (sample if joint else -1, body)
        if key not in transforms:
            rotation = kinematics.rotation[sample, joint]
            transforms[key] = coal.Transform3s(
                rotation @ self._rotation[body],
                rotation @ self._translation[body] + kinematics.translation[sample, joint],
            )
        return transforms[key]

    def _measure(
        self,
        kinematics: Kinematics,
        sample: int,
        pair: int,
        transforms: dict[tuple[int, int], coal.Transform3s],
        reach: float,
    ) -> tuple[float, Floats, Floats, Floats] | None:
        first, second = int(self._first[pair]), int(self._second[pair])
        geometries = self._geometries[first], self._geometries[second]
        places = (
            self._transform(kinematics, sample, first, transforms),
            self._transform(kinematics, sample, second, transforms),
        )
        result, distance = self._result, -np.inf
        for request in self._requests:
            result.clear()
            distance = float(
                coal.distance(geometries[0], places[0], geometries[1], places[1], request, result)
            )
            if abs(distance) < PLANE_EXTENT:
                break
        if distance >= reach:
            return None
        if distance <= 0.0 and (self._exact[first] or self._exact[second]):
            return self._deepest_contact(geometries, places)
        return (
            distance,
            np.array(result.normal),
            np.array(result.getNearestPoint1()),
            np.array(result.getNearestPoint2()),
        )

    def _deepest_contact(
        self,
        geometries: tuple[coal.CollisionGeometry, coal.CollisionGeometry],
        places: tuple[coal.Transform3s, coal.Transform3s],
    ) -> tuple[float, Floats, Floats, Floats] | None:
        """Measure a penetrating exact mesh: Coal's distance says only that it touches."""
        result = coal.CollisionResult()
        coal.collide(geometries[0], places[0], geometries[1], places[1], self._contact_request, result)
        contacts = [result.getContact(i) for i in range(result.numContacts())]
        if not contacts:
            return None
        deepest = min(contacts, key=lambda contact: contact.penetration_depth)
        return (
            float(deepest.penetration_depth),
            np.array(deepest.normal),
            np.array(deepest.getNearestPoint1()),
            np.array(deepest.getNearestPoint2()),
        )
