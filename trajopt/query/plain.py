"""The query in plain Python: the oracle of the compiled one, and its stand-in where that is missing."""

import numpy as np
import pinocchio as pin

from trajopt.arrays import Floats
from trajopt.model.reduced import ReducedModel
from trajopt.query.boxes import PLANE_EXTENT, BoundingBoxes
from trajopt.query.contacts import Contacts
from trajopt.query.distance import Measured, PairDistances
from trajopt.query.kinematics import Counts, Kinematics
from trajopt.query.query import Query


class PlainQuery(Query):
    """Evaluates configuration by configuration and pair by pair."""

    def __init__(self, reduced: ReducedModel, counts: Counts | None = None) -> None:
        """Build Coal's geometries and the bounding volumes."""
        super().__init__(reduced, counts)
        self._data = reduced.model.createData()
        self._boxes = BoundingBoxes.of(reduced)
        self._distances = PairDistances(reduced, self._boxes)

    def kinematics(self, positions: Floats) -> Kinematics:
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
        return Kinematics(placements[:, :, :3, :3], placements[:, :, :3, 3], jacobian)

    def near(self, positions: Floats, reach: Floats) -> Contacts:
        """Measure every pair that is nearer than its reach; see `Query.near`."""
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
        velocity = self.point_jacobian(jacobian, joint[pairs.second[pair]], second) - self.point_jacobian(
            jacobian, joint[pairs.first[pair]], first
        )
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

    def _frames(self, kinematics: Kinematics) -> tuple[Floats, Floats]:
        """Return rotations (S, B, 3, 3) and bounding centres (S, B, 3) of all bodies."""
        boxes = self._boxes
        rotation = kinematics.rotation[:, boxes.joint]
        centre = (rotation @ boxes.centre[:, :, None])[..., 0] + kinematics.translation[:, boxes.joint]
        return rotation @ boxes.rotation, centre

    def _lower_bounds(self, kinematics: Kinematics) -> Floats:
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
