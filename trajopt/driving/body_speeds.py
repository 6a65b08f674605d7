"""Body speeds: how fast a robot's bodies, and what moves by itself, can come nearer to each other now."""

import numpy as np

from trajopt.geometry import Kinematics
from trajopt.geometry.geometry import BoundingBoxes
from trajopt.scene.deviation import pair_levers
from trajopt.scene.reduced import ReducedModel
from trajopt.values.arrays import Floats


class BodySpeeds:
    """How fast pairs of bodies can come nearer, in a configuration and for velocities within bounds."""

    def __init__(self, reduced: ReducedModel) -> None:
        """Lay out the bodies.

        Args:
            reduced: Robot and scene.
        """
        model, boxes = reduced.model, BoundingBoxes.of(reduced)
        self._mimic, self._pairs, self._levers = reduced.mimic_matrix, reduced.pairs, pair_levers(reduced)
        self._joint, self._centre, self._radius = boxes.joint, boxes.centre[:, :, None], boxes.radius
        self._carried = np.zeros((model.nv, model.njoints))
        for joint in range(1, model.njoints):
            for carrier in list(model.supports[joint])[1:]:
                self._carried[int(model.joints[carrier].idx_v), joint] = 1.0

    def nearer(self, placed: Kinematics, lower: Floats, upper: Floats) -> Floats:
        """Bound how fast the bodies of each pair can come nearer, shape (p,) [m/s].

        At the middle of the bounds no point of a body is faster than its centre, and its turning times its
        radius, make it; the rest is bounded by levers, which hold everywhere.

        Args:
            placed: Where the joints are, in one configuration.
            lower: Least velocities of the joints, shape (n,) [rad/s | m/s].
            upper: Largest, likewise.
        """
        rates = self._mimic @ ((lower + upper) / 2.0)
        twist = (placed.jacobian[0] * rates) @ self._carried
        linear, angular = twist[:3, self._joint].T, twist[3:, self._joint].T
        turned = (placed.rotation[0, self._joint] @ self._centre)[:, :, 0]
        centre = turned + placed.translation[0, self._joint]
        ahead, behind = (1, 2, 0), (2, 0, 1)
        moved = linear + angular[:, ahead] * centre[:, behind] - angular[:, behind] * centre[:, ahead]
        sizes = np.sqrt(np.stack((moved, angular)) ** 2 @ np.ones(3))
        speed = sizes[0] + sizes[1] * self._radius
        middle = speed[self._pairs.first] + speed[self._pairs.second]
        by_levers = self._levers @ np.stack((np.maximum(-lower, upper), (upper - lower) / 2.0), axis=1)
        return np.minimum(by_levers[:, 0], middle + by_levers[:, 1])
