"""Coordinates of a point about an arc: off the circle, off its plane, and along the arc."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from trajopt.optimise.terms.frames import lengths, relative_frame
from trajopt.optimise.terms.requirement import INSET, constrain
from trajopt.problem.motion import Motion
from trajopt.problem.requirements import PointOnArc
from trajopt.problem.residual import Constraint, Window, constraint
from trajopt.scene.reduced import ReducedModel
from trajopt.values.arrays import Rows
from trajopt.values.placement import from_rpy

if TYPE_CHECKING:
    import casadi as ca

    from trajopt.optimise.terms.symbolic import SymbolicKinematics


@dataclass(frozen=True, eq=False)
class ArcCoordinates:
    """Four components [m]: r - R, z, their length, and R t.

    With (r, t, z) cylindrical coordinates about the circle's axis, t counted from the middle of the arc.
    On the axis r grows towards the middle of the arc; t jumps opposite to it.

    Attributes:
        reduced: The robot and its surroundings.
        required: The requirement.
    """

    reduced: ReducedModel
    required: PointOnArc

    units = ("m",)

    @property
    def name(self) -> str:
        """The frame whose point is on the arc."""
        return f"arc of {self.required.frame}"

    def linearise(self, motion: Motion) -> Rows:
        """Evaluate and differentiate at all samples."""
        need = self.required
        seen = relative_frame(self.reduced, motion, need.frame, need.reference, need.offset)
        axes = need.centre.rotation @ from_rpy(0.0, 0.0, need.sweep / 2.0)
        point, rate = (seen.point - need.centre.translation) @ axes, axes.T @ seen.point_jacobian
        radius, radius_rate = lengths(point[:, :2], rate[:, :2], aside=0)
        off = np.stack((radius - need.radius, point[:, 2]), axis=1)
        off_rate = np.stack((radius_rate, rate[:, 2]), axis=1)
        apart, apart_rate = lengths(off, off_rate)
        # On the axis the direction is unknown, and turning would be infinitely fast.
        square = np.maximum(radius, 1e-6)[:, None] ** 2
        turn = (point[:, :1] * rate[:, 1] - point[:, 1:2] * rate[:, 0]) / square
        along = need.radius * np.arctan2(point[:, 1], point[:, 0])
        return motion.rows_of_all(
            np.stack((off[:, 0], off[:, 1], apart, along), axis=1),
            np.stack((off_rate[:, 0], off_rate[:, 1], apart_rate, need.radius * turn), axis=1),
        )

    def expression(self, kinematics: "SymbolicKinematics") -> "ca.SX":
        """Return the components as an expression; see `Symbolic`."""
        import casadi as ca

        from trajopt.optimise.terms.symbolic import length

        need = self.required
        axes = need.centre.rotation @ from_rpy(0.0, 0.0, need.sweep / 2.0)
        seen = kinematics.point(need.frame, need.offset, need.reference)
        point = ca.SX(axes.T) @ (seen - ca.SX(need.centre.translation))
        off = ca.vertcat(length(point[:2]) - need.radius, point[2])
        return ca.vertcat(off, length(off), need.radius * ca.atan2(point[1], point[0]))


@constrain.register
def _(
    required: PointOnArc, reduced: ReducedModel, window: Window, inset: float = INSET
) -> tuple[Constraint, ...]:
    within = required.tolerance * (1.0 - inset)
    whole = required.sweep >= 2.0 * np.pi
    reach = np.inf if whole else required.radius * required.sweep / 2.0
    return (
        constraint(
            ArcCoordinates(reduced, required),
            lower=(-within, -within, -np.inf, -reach),
            upper=(within, within, within, reach),
            tolerance=max(required.tolerance * inset * 0.5, 1e-9),
            window=window,
        ),
    )
