"""Coal's signed distance of one pair of bodies at a time."""

from dataclasses import dataclass

import coal
import numpy as np

from trajopt.arrays import Floats
from trajopt.model.meshes.mesh_file import Mesh
from trajopt.model.reduced import ReducedModel
from trajopt.query.boxes import PLANE_EXTENT, BoundingBoxes
from trajopt.query.enclosure import encloses
from trajopt.query.geometry import collision_geometry
from trajopt.query.kinematics import Kinematics

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

    def __call__(self, kinematics: Kinematics, sample: int, pair: int, reach: float) -> Measured | None:
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

    def _transform(self, kinematics: Kinematics, sample: int, body: int) -> coal.Transform3s:
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
