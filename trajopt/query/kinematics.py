"""Placements and Jacobians of all joints at many configurations at once."""

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from trajopt.arrays import Floats, Ints
from trajopt.model.reduced import ReducedModel


@dataclass(eq=False)
class Counts:
    """Exact numbers of the work done so far; the same on every machine.

    Attributes:
        forward_kinematics: Configurations at which all joints were placed.
        distances: Calls of Coal's distance function.
    """

    forward_kinematics: int = 0
    distances: int = 0


@dataclass(frozen=True, eq=False)
class Kinematics:
    """Joint placements and Jacobians at S configurations of a reduced model with J joints.

    Attributes:
        rotation: Of each joint frame (the world first), shape (S, J, 3, 3).
        translation: Shape (S, J, 3) [m].
        jacobian: Spatial velocity at the world's origin (linear, angular) of each of the group's
            joints at unit speed, shape (S, 6, model joints).
    """

    rotation: Floats
    translation: Floats
    jacobian: Floats

    def take(self, index: Ints) -> "Kinematics":
        """Return the kinematics of some of the configurations."""
        return Kinematics(self.rotation[index], self.translation[index], self.jacobian[index])


class KinematicsQuery:
    """Evaluates a reduced model; owns pinocchio's scratch memory, so one per thread."""

    def __init__(self, reduced: ReducedModel, counts: Counts) -> None:
        """Allocate the scratch memory."""
        self._reduced = reduced
        self._data = reduced.model.createData()
        self._counts = counts
        model = reduced.model
        supports = np.zeros((model.njoints, model.nv))
        for joint in range(1, model.njoints):
            for ancestor in list(model.supports[joint])[1:]:
                supports[joint, model.joints[ancestor].idx_v] = 1.0
        self._supports = supports

    def __call__(self, positions: Floats) -> Kinematics:
        """Evaluate at configurations.

        Args:
            positions: The group's positions, shape (S, n) [rad | m].
        """
        model, data = self._reduced.model, self._data
        count, joints = len(positions), model.njoints
        placements = np.empty((count, joints, 4, 4))
        jacobian = np.empty((count, 6, model.nv))
        for row, position in enumerate(positions):
            pin.computeJointJacobians(model, data, self._reduced.configuration(position))
            placements[row] = [placement.np for placement in data.oMi.tolist()]
            jacobian[row] = data.J
        self._counts.forward_kinematics += count
        return Kinematics(placements[:, :, :3, :3], placements[:, :, :3, 3], jacobian)

    def point_jacobian(self, jacobian: Floats, joints: Ints, points: Floats) -> Floats:
        """Return Jacobians of points carried by joints, by the group's positions.

        The velocity of a point p is v + w x p with (v, w) the spatial velocity at the origin.

        Args:
            jacobian: Of `Kinematics`, one for each point, shape (m, 6, model joints).
            joints: The joint that carries each point, shape (m,).
            points: In the world, shape (m, 3) [m].

        Returns:
            Shape (m, 3, n) [m/rad | m/m].
        """
        linear, angular = jacobian[:, :3], jacobian[:, 3:]
        moved = linear + np.cross(angular, points[:, :, None], axisa=1, axisb=1, axisc=1)
        return (moved * self._supports[joints][:, None, :]) @ self._reduced.expand

    def angular_jacobian(self, jacobian: Floats, joint: int) -> Floats:
        """Return Jacobians of a joint's angular velocity in the world, shape (m, 3, n)."""
        return (jacobian[:, 3:] * self._supports[joint]) @ self._reduced.expand
