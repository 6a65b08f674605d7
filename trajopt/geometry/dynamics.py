"""Joint torques of a reduced model, and their derivatives."""

from dataclasses import dataclass, replace

import numpy as np

from trajopt.native import proximity
from trajopt.scene.reduced import ReducedModel, loaded_model
from trajopt.values.arrays import Floats


@dataclass(frozen=True, eq=False)
class GravityTorques:
    """Torques that hold a group of n joints still at S configurations, and their derivatives.

    Attributes:
        torque: Shape (S, n) [Nm | N].
        position: Derivatives by the positions, shape (S, n, n).
    """

    torque: Floats
    position: Floats


@dataclass(frozen=True, eq=False)
class TorqueSlopes:
    """Torques at S states of a group of n joints, and their derivatives.

    Attributes:
        torque: Shape (S, n) [Nm | N].
        position: Derivatives by the positions, shape (S, n, n).
        velocity: By the velocities, shape (S, n, n).
        acceleration: By the accelerations: the mass matrix, shape (S, n, n).
    """

    torque: Floats
    position: Floats
    velocity: Floats
    acceleration: Floats


class DynamicsQuery:
    """Inverse dynamics; owns scratch memory, so one per thread."""

    def __init__(self, reduced: ReducedModel, bare: proximity.Dynamics | None = None) -> None:
        """Make one for a model; `bare` is that of the robot without its payload, if the mass is uncertain."""
        self._core = _core(reduced)
        self._uncertainty = reduced.scene.model_error.payload
        self._bare = bare

    @property
    def core(self) -> proximity.Dynamics:
        """Torque evaluator for other cores."""
        return self._core

    @staticmethod
    def loaded(reduced: ReducedModel) -> "DynamicsQuery":
        """Return the dynamics of a reduced model with its payload."""
        model = loaded_model(reduced)
        if model is reduced.model:
            return DynamicsQuery(reduced)
        bare = _core(reduced) if reduced.scene.model_error.payload > 0.0 else None
        return DynamicsQuery(replace(reduced, model=model), bare)

    def gravity(self, positions: Floats) -> GravityTorques:
        """Return the torques that hold the arm still, with their derivatives.

        The torque of mimic joints counts for the joint that they follow.

        Args:
            positions: The group's, shape (S, n) [rad | m].
        """
        return GravityTorques(*self._core.gravity(np.ascontiguousarray(positions)))

    def torque_slopes(self, positions: Floats, velocities: Floats, accelerations: Floats) -> TorqueSlopes:
        """Return torques and their derivatives; for arguments see `torque`.

        Source: Carpentier and Mansard, Analytical derivatives of rigid body dynamics algorithms, RSS 2018.
        """
        states = [np.ascontiguousarray(rows) for rows in (positions, velocities, accelerations)]
        return TorqueSlopes(self._core.torques(*states), *self._core.slopes(*states))

    def torque(self, positions: Floats, velocities: Floats, accelerations: Floats) -> Floats:
        """Return the torques that a motion needs, by the recursive Newton-Euler algorithm.

        The torque of mimic joints counts for the joint that they follow (virtual work). If the mass of the
        payload is uncertain, each torque is the largest.

        Args:
            positions: The group's at S moments, shape (S, n) [rad | m].
            velocities: Shape (S, n) [rad/s | m/s].
            accelerations: Shape (S, n) [rad/s^2 | m/s^2].

        Returns:
            Shape (S, n) [Nm | N]. Source: Featherstone, Rigid Body Dynamics Algorithms, ch. 5.
        """
        states = [np.ascontiguousarray(rows) for rows in (positions, velocities, accelerations)]
        torques = self._core.torques(*states)
        if self._bare is None:
            return torques
        carried = torques - self._bare.torques(*states)
        return torques + np.copysign(self._uncertainty * np.abs(carried), torques)


def _core(reduced: ReducedModel) -> proximity.Dynamics:
    mimic_matrix = np.ascontiguousarray(reduced.mimic_matrix)
    return proximity.Dynamics(model=reduced.model, expand=mimic_matrix, offset=reduced.mimic_offset)
