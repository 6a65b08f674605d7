"""Angle between an axis of a frame and a direction."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from trajopt.optimise.terms.frames import relative_frame
from trajopt.optimise.terms.requirement import INSET, constrain
from trajopt.problem.motion import Motion
from trajopt.problem.requirements import AxisAlignment
from trajopt.problem.residual import Constraint, Window, constraint
from trajopt.scene.reduced import ReducedModel
from trajopt.values.arrays import Rows

if TYPE_CHECKING:
    import casadi as ca

    from trajopt.optimise.terms.symbolic import SymbolicKinematics


@dataclass(frozen=True, eq=False)
class AxisAngle:
    """One component: the angle t in [0, pi] between axis a and direction d [rad].

    t = `atan2(|a x d|, a . d)`, so `t' = -w . (a x d) / |a x d|` for a frame with angular velocity w. If
    the two are parallel the slope is taken as zero, if opposite along any perpendicular.

    Attributes:
        reduced: The robot and its surroundings.
        required: The requirement.
    """

    reduced: ReducedModel
    required: AxisAlignment

    units = ("rad",)

    @property
    def name(self) -> str:
        """The frame whose axis is aligned."""
        return f"tilt of {self.required.frame}"

    def linearise(self, motion: Motion) -> Rows:
        """Evaluate and differentiate at all samples."""
        need = self.required
        seen = relative_frame(self.reduced, motion, need.frame, need.reference, np.zeros(3))
        axis = seen.rotation @ need.axis
        cross = np.cross(axis, need.direction)
        sine, cosine = np.linalg.norm(cross, axis=1), axis @ need.direction
        angle = np.arctan2(sine, cosine)
        across = np.linalg.svd(need.direction[None, :])[2][1]
        opposite = (sine < 1e-9) & (cosine < 0.0)
        about = np.where(opposite[:, None], across, cross / np.maximum(sine, 1e-9)[:, None])
        slope = -np.einsum("si,sin->sn", about, seen.angular_jacobian)
        return motion.rows_of_all(angle[:, None], slope[:, None, :])

    def expression(self, kinematics: "SymbolicKinematics") -> "ca.SX":
        """Return the components as an expression; see `Symbolic`."""
        import casadi as ca

        from trajopt.optimise.terms.symbolic import length

        need = self.required
        axis = kinematics.rotation(need.frame, need.reference) @ ca.SX(need.axis)
        direction = ca.SX(need.direction)
        return ca.atan2(length(ca.cross(axis, direction)), ca.dot(axis, direction))


@constrain.register
def _(
    required: AxisAlignment, reduced: ReducedModel, window: Window, inset: float = INSET
) -> tuple[Constraint, ...]:
    return (
        constraint(
            AxisAngle(reduced, required),
            lower=-np.inf,
            upper=required.tolerance * (1.0 - inset),
            tolerance=max(required.tolerance * inset * 0.5, 1e-9),
            window=window,
        ),
    )
