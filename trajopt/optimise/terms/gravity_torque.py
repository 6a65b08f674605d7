"""Torque that holds the arm still against gravity, as a share of the effort limits."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from trajopt.optimise.terms.requirement import INSET, constrain
from trajopt.problem.motion import Motion
from trajopt.problem.requirements import GravityTorque
from trajopt.problem.residual import Constraint, Window, constraint
from trajopt.scene.reduced import ReducedModel, loaded_model
from trajopt.values.arrays import Floats, Ints, Rows, Value
from trajopt.values.errors import ProblemError, shown

if TYPE_CHECKING:
    import casadi as ca

    from trajopt.optimise.terms.symbolic import SymbolicKinematics


@dataclass(frozen=True, eq=False)
class GravityShare(Value):
    """g_j(q) / (effort limit of joint j), one component for each of some of the group's joints.

    Derivatives are analytic (Carpentier and Mansard, Analytical derivatives of rigid body dynamics
    algorithms, RSS 2018). The torque of mimic joints counts for the joint that they follow.

    Attributes:
        joints: Indices of the joints in the group, shape (k,).
    """

    reduced: ReducedModel
    joints: Ints
    name = "gravity torque"

    def linearise(self, motion: Motion) -> Rows:
        found, effort = motion.query.dynamics.gravity(motion.positions), self.reduced.limits.effort
        by_effort = np.eye(len(effort))[:, self.joints] / effort[self.joints]
        return motion.rows_of_all(found.torque @ by_effort, by_effort.T @ found.position)

    def expression(self, kinematics: "SymbolicKinematics") -> "ca.SX":
        effort = self.reduced.limits.effort[self.joints]
        return _torque_expression(kinematics)[self.joints.tolist()] / effort


@dataclass(frozen=True, eq=False)
class HoldingTorque(Value):
    """g_j(q) / (effort limit of joint j), for joints near their largest torque.

    The component of a row is the index of its joint in the group.

    Attributes:
        effort: Effort limits of the group's joints, shape (n,) [Nm | N].
        listed: Share from which a joint gets a row, shape (n,); inf for none.
    """

    effort: Floats
    listed: Floats
    name = "torque to hold still"

    def linearise(self, motion: Motion) -> Rows:
        found = motion.query.dynamics.gravity(motion.positions)
        share = found.torque / self.effort
        sample, joint = np.nonzero(np.abs(share) >= self.listed)
        slope = found.position[sample, joint] / self.effort[joint, None]
        return motion.rows(sample, share[sample, joint], slope, joint)

    def expression(self, kinematics: "SymbolicKinematics") -> "ca.SX":
        return _torque_expression(kinematics) * (1.0 / self.effort)


def _torque_expression(kinematics: "SymbolicKinematics") -> "ca.SX":
    """Return the gradient of the potential energy - sum m g . c over the bodies' centres of mass c."""
    import casadi as ca

    model = loaded_model(kinematics.reduced)
    gravity = ca.SX(np.asarray(model.gravity.linear, dtype=np.float64))
    energy = ca.SX(0.0)
    for joint in range(1, model.njoints):
        body = model.inertias[joint]
        centre = kinematics.joint_point(joint, np.asarray(body.lever, dtype=np.float64))
        energy -= float(body.mass) * ca.dot(gravity, centre)
    return ca.jacobian(energy, kinematics.q).T


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
