"""Joint torques of a reduced model."""

import pinocchio as pin

from trajopt.arrays import Floats
from trajopt.model.reduced import ReducedModel


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
            positions: The group's, shape (n,) [rad | m].
            velocities: Shape (n,) [rad/s | m/s].
            accelerations: Shape (n,) [rad/s^2 | m/s^2].

        Returns:
            Shape (n,) [Nm | N]. Source: Featherstone, Rigid Body Dynamics Algorithms, ch. 5.
        """
        reduced = self._reduced
        full = pin.rnea(
            reduced.model,
            self._data,
            reduced.configuration(positions),
            reduced.expand @ velocities,
            reduced.expand @ accelerations,
        )
        return reduced.expand.T @ full
