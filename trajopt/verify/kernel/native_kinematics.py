"""Kinematics, dynamics and extremes over many samples by the native core."""

import numpy as np

from trajopt.arrays import Floats
from trajopt.model.reduced import ReducedModel
from trajopt.native import proof
from trajopt.verify.kernel.kinematics import Kinematics, Poses
from trajopt.verify.kernel.polynomials import TIGHTNESS, Extremes, Polynomials


class NativeKinematics(Kinematics):
    """Kinematics whose loops over samples and joints are compiled.

    Attributes:
        arm: The joints as the core knows them.
    """

    def __init__(self, reduced: ReducedModel) -> None:
        """Read the joints."""
        super().__init__(reduced)
        places = list(reduced.model.jointPlacements)
        self.arm = proof.arm(
            np.array(self.parents, dtype=np.int64),
            self.revolute,
            self.axes,
            np.array([place.rotation for place in places]),
            np.array([place.translation for place in places]),
        )

    def poses(self, positions: Floats) -> Poses:
        """Compute where all joint frames are, for the group's positions of shape (c, n)."""
        joints = positions @ self.reduced.mimic_matrix.T + self.reduced.mimic_offset
        rotation, translation = self.arm.place(np.ascontiguousarray(joints))
        self.calls += len(positions)
        return Poses(self.configurations(positions), rotation, translation)

    def extremes(self, functions: Polynomials) -> tuple[Extremes, Extremes]:
        """Return the largest and the smallest values of functions of time."""
        times, coefficients = functions.times, np.ascontiguousarray(functions.coefficients)
        high, when_high = proof.largest(times, coefficients, 1.0, TIGHTNESS)
        low, when_low = proof.largest(times, coefficients, -1.0, TIGHTNESS)
        return Extremes(high, when_high), Extremes(-low, when_low)

    def torques(self, configurations: Floats, velocities: Floats, accelerations: Floats) -> Floats:
        """Compute the torques that motions of the model's joints need, shape (s, joints) [Nm | N]."""
        rows = (np.ascontiguousarray(part) for part in (configurations, velocities, accelerations))
        return proof.torques(self.reduced.model, *rows)
