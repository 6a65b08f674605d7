"""A weighted sum of joint positions."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from trajopt.optimise.terms.requirement import INSET, constrain
from trajopt.problem.motion import Motion
from trajopt.problem.requirements import CoupledJoints
from trajopt.problem.residual import Constraint, Window, constraint
from trajopt.scene.reduced import ReducedModel
from trajopt.values.arrays import Floats, Rows, Value
from trajopt.values.errors import ProblemError

if TYPE_CHECKING:
    import casadi as ca

    from trajopt.optimise.terms.symbolic import SymbolicKinematics


@dataclass(frozen=True, eq=False)
class JointSum(Value):
    """One component: a weighted sum of the group's positions and a constant [rad | m].

    Attributes:
        weights: Shape (n,).
        constant: What joints add that do not move.
    """

    weights: Floats
    constant: float
    name = "coupled joints"

    def linearise(self, motion: Motion) -> Rows:
        """Return the sums; exact, for they are linear."""
        value = motion.positions @ self.weights + self.constant
        return motion.rows_of_all(value[:, None], np.tile(self.weights, (len(value), 1, 1)))

    def expression(self, kinematics: "SymbolicKinematics") -> "ca.SX":
        """Return the components as an expression; see `Symbolic`."""
        import casadi as ca

        return ca.dot(ca.SX(self.weights), kinematics.q) + self.constant


@constrain.register
def _(
    required: CoupledJoints, reduced: ReducedModel, window: Window, inset: float = INSET
) -> tuple[Constraint, ...]:
    weights, constant = np.zeros(len(reduced.joint_names)), 0.0
    moved, robot = tuple(reduced.model.names[1:]), reduced.scene.robot
    for joint, factor in required.weights.items():
        if joint in moved:
            place = moved.index(joint)
            weights += factor * reduced.mimic_matrix[place]
            constant += factor * float(reduced.mimic_offset[place])
        else:
            constant += factor * float(reduced.start[robot.index([joint])[0]])
    off = abs(constant - required.value)
    if not weights.any():
        if off > required.tolerance:
            raise ProblemError(f"{required} is off by {off:g}, and none of its joints is in the group")
        return ()
    within = required.tolerance * (1.0 - inset)
    return (
        constraint(
            JointSum(weights, constant),
            lower=required.value - within,
            upper=required.value + within,
            tolerance=max(required.tolerance * inset * 0.5, 1e-9),
            window=window,
        ),
    )
