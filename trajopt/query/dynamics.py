"""Joint torques of a reduced model."""

import numpy as np
import pinocchio as pin

from trajopt.arrays import Floats
from trajopt.model.reduced import ReducedModel
from trajopt.model.robot import configuration


class DynamicsQuery:
    """Inverse dynamics; owns pinocchio's scratch memory, so one per thread."""

    def __init__(self, reduced: ReducedModel) -> None:
        """Allocate the scratch memory."""
        self._reduced = reduced
        self._data = reduced.model.createData()

    def torque(self, positions: Floats, velocities: Floats, accelerations: Floats) -> Floats:
        """Return the torques that a motion needs, by the recursive Newton-Euler algorithm.

        Mimicking joints hand their torque to the joint they follow (virtual work).

        Args:
            positions: The group's at S moments, shape (S, n) [rad | m].
            velocities: Shape (S, n) [rad/s | m/s].
            accelerations: Shape (S, n) [rad/s^2 | m/s^2].

        Returns:
            Shape (S, n) [Nm | N]. Source: Featherstone, Rigid Body Dynamics Algorithms, ch. 5.
        """
        reduced, model, data = self._reduced, self._reduced.model, self._data
        expand = reduced.expand.T
        q = positions @ expand + reduced.offset
        if model.nq != model.nv:
            q = np.array([configuration(model, row) for row in q])
        v, a = velocities @ expand, accelerations @ expand
        full = np.array([pin.rnea(model, data, *row) for row in zip(q, v, a, strict=True)])
        return full.reshape(v.shape) @ reduced.expand
