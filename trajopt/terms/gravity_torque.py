"""Torque that holds the arm still against gravity, as a share of the effort limits."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import pinocchio as pin

from trajopt.arrays import Ints, Value
from trajopt.errors import ProblemError, shown
from trajopt.model.payload import loaded_model
from trajopt.model.reduced import ReducedModel
from trajopt.model.requirements import GravityTorque
from trajopt.nlp import Rows
from trajopt.terms.motion import Motion
from trajopt.terms.requirement import INSET, constrain
from trajopt.terms.residual import Constraint, Window, constraint

if TYPE_CHECKING:
    import casadi as ca

    from trajopt.terms.symbolic import SymbolicKinematics


@dataclass(frozen=True, eq=False)
class GravityShare(Value):
    """g_j(q) / (effort limit of joint j), one component for each of some of the group's joints.

    Derivatives are pinocchio's analytic ones of generalised gravity (Carpentier and Mansard, Analytical
    derivatives of rigid body dynamics algorithms, RSS 2018). Mimicking joints hand their torque to the
    joint they follow.

    Attributes:
        reduced: The robot and its surroundings.
        joints: Places of the joints in the group, shape (k,).
    """

    reduced: ReducedModel
    joints: Ints
    name = "gravity torque"

    def linearise(self, motion: Motion) -> Rows:
        """Evaluate and differentiate at all samples."""
        reduced = self.reduced
        model = loaded_model(reduced)
        data = model.createData()
        torque = np.empty((len(motion.positions), model.nv))
        slope = np.empty((len(motion.positions), model.nv, model.nv))
        for row, positions in enumerate(motion.positions):
            slope[row] = pin.computeGeneralizedGravityDerivatives(
                model, data, reduced.configuration(positions)
            )
            torque[row] = data.g
        by_effort = reduced.mimic_matrix[:, self.joints] / reduced.limits.effort[self.joints]
        return motion.rows_of_all(torque @ by_effort, by_effort.T @ slope @ reduced.mimic_matrix)

    def expression(self, kinematics: "SymbolicKinematics") -> "ca.SX":
        """The gradient of the potential energy - sum m g . c over the bodies' centres of mass c."""
        import casadi as ca

        model = loaded_model(kinematics.reduced)
        gravity = ca.SX(np.asarray(model.gravity.linear, dtype=np.float64))
        energy = ca.SX(0.0)
        for joint in range(1, model.njoints):
            body = model.inertias[joint]
            centre = kinematics.joint_point(joint, np.asarray(body.lever, dtype=np.float64))
            energy -= float(body.mass) * ca.dot(gravity, centre)
        torque = ca.jacobian(energy, kinematics.q).T
        return torque[self.joints.tolist()] / ca.SX(kinematics.reduced.limits.effort[self.joints])


@constrain.register
def _(
    required: GravityTorque, reduced: ReducedModel, window: Window, inset: float = INSET
) -> tuple[Constraint, ...]:
    joints = np.flatnonzero(np.isfinite(reduced.limits.effort))
    if len(joints) == 0:
        raise ProblemError(f"{required}: no joint of group {shown(reduced.group)} has an effort limit")
    within = required.share * (1.0 - inset)
    return (
        constraint(
            GravityShare(reduced, joints),
            lower=-within,
            upper=within,
            tolerance=max(required.share * inset * 0.5, 1e-9),
            window=window,
        ),
    )
