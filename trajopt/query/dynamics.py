"""Joint torques of a reduced model: the compiled body and the plain one."""

from abc import ABC, abstractmethod

import numpy as np
import pinocchio as pin

from trajopt.arrays import Floats
from trajopt.model.reduced import ReducedModel
from trajopt.model.robot import configuration
from trajopt.native import installed


class DynamicsQuery(ABC):
    """Inverse dynamics; owns scratch memory, so one per thread."""

    @abstractmethod
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


def dynamics_of(reduced: ReducedModel) -> DynamicsQuery:
    """Return the compiled body where it is installed, else the plain one; both answer the same."""
    return CompiledDynamics(reduced) if installed("proximity") else PlainDynamics(reduced)


class CompiledDynamics(DynamicsQuery):
    """All states in one call of the native core."""

    def __init__(self, reduced: ReducedModel) -> None:
        """Hand the model over."""
        from trajopt.native import proximity

        expand = np.ascontiguousarray(reduced.expand)
        self._core = proximity.Dynamics(model=reduced.model, expand=expand, offset=reduced.offset)

    def torque(self, positions: Floats, velocities: Floats, accelerations: Floats) -> Floats:
        """Return the torques that a motion needs; see `DynamicsQuery.torque`."""
        states = (np.ascontiguousarray(rows) for rows in (positions, velocities, accelerations))
        return self._core.torques(*states)


class PlainDynamics(DynamicsQuery):
    """One state after the other, by pinocchio's own binding."""

    def __init__(self, reduced: ReducedModel) -> None:
        """Allocate the scratch memory."""
        self._reduced = reduced
        self._data = reduced.model.createData()

    def torque(self, positions: Floats, velocities: Floats, accelerations: Floats) -> Floats:
        """Return the torques that a motion needs; see `DynamicsQuery.torque`."""
        reduced, model, data = self._reduced, self._reduced.model, self._data
        expand = reduced.expand.T
        q = positions @ expand + reduced.offset
        if model.nq != model.nv:
            q = np.array([configuration(model, row) for row in q])
        v, a = velocities @ expand, accelerations @ expand
        full = np.array([pin.rnea(model, data, *row) for row in zip(q, v, a, strict=True)])
        return full.reshape(v.shape) @ reduced.expand
