"""Angles between axes, and between an axis and the line to a point."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from trajopt.optimise.terms.frames import lengths, relative_frame
from trajopt.optimise.terms.positions import RESERVED_DISTANCE
from trajopt.optimise.terms.requirement import INSET, constrain
from trajopt.problem.motion import Motion
from trajopt.problem.requirements import AxisAlignment, Gaze
from trajopt.problem.residual import Constraint, Window, constraint
from trajopt.scene.reduced import ReducedModel
from trajopt.values.arrays import Rows

if TYPE_CHECKING:
    import casadi as ca

    from trajopt.optimise.terms.symbolic import SymbolicKinematics


@dataclass(frozen=True, eq=False)
class AxisAngle:
    """One component: the angle t in [0, pi] between axis a and direction d [rad].

    t = `atan2(|a x d|, a . d)`, so `t' = -w . (a x d) / |a x d|` for a frame with angular velocity w. The
    slope is taken as zero if they are parallel, along any perpendicular if opposite.
    """

    reduced: ReducedModel
    required: AxisAlignment

    units = ("rad",)

    @property
    def name(self) -> str:
        return f"tilt of {self.required.frame}"

    def linearise(self, motion: Motion) -> Rows:
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


NEAR = 1e-6
"""The direction of a nearer point means nothing [m]."""


@dataclass(frozen=True, eq=False)
class ViewAngle:
    """One component: the angle between the camera's axis and the direction to the target, in [0, pi] [rad].

    t = atan2(|a x p|, a . p) of the point p, seen from the camera, off its axis a has a slope for every p,
    also behind the camera, unlike 1 - cos t. With p = r (cos t a + sin t n), n across the axis, t' = (cos t n
    - sin t a) . p' / r. On the axis the slope is taken as zero; straight behind, the point leaves the axis to
    one side.
    """

    reduced: ReducedModel
    required: Gaze

    units = ("rad",)

    @property
    def name(self) -> str:
        return f"gaze of {self.required.frame}"

    def linearise(self, motion: Motion) -> Rows:
        need = self.required
        # The reference is seen from the camera, so that what moves is the target.
        seen = relative_frame(self.reduced, motion, need.reference, need.frame, need.target)
        point, axis = seen.point - need.origin, need.axis
        ahead = point @ axis
        across = point - ahead[:, None] * axis
        sine = np.linalg.norm(across, axis=1)
        angle = np.arctan2(sine, ahead)
        distance = np.maximum(np.linalg.norm(point, axis=1), NEAR)
        unit = across / np.maximum(sine, 1e-12)[:, None]
        aside = np.linalg.svd(axis[None, :])[2][1]
        unit[(sine < 1e-9 * distance) & (ahead < 0.0)] = aside
        slope = (np.cos(angle)[:, None] * unit - np.sin(angle)[:, None] * axis) / distance[:, None]
        rate = np.einsum("si,sin->sn", slope, seen.point_jacobian)
        return motion.rows_of_all(angle[:, None], rate[:, None, :])

    def expression(self, kinematics: "SymbolicKinematics") -> "ca.SX":
        import casadi as ca

        from trajopt.optimise.terms.symbolic import length

        need = self.required
        point = kinematics.point(need.reference, need.target, need.frame) - ca.SX(need.origin)
        ahead = ca.dot(point, ca.SX(need.axis))
        return ca.atan2(length(point - ca.SX(need.axis) * ahead), ahead)


@dataclass(frozen=True, eq=False)
class ViewDistance:
    """One component: the distance of the target from the camera [m]."""

    reduced: ReducedModel
    required: Gaze

    units = ("m",)

    @property
    def name(self) -> str:
        return f"view distance of {self.required.frame}"

    def linearise(self, motion: Motion) -> Rows:
        need = self.required
        seen = relative_frame(self.reduced, motion, need.reference, need.frame, need.target)
        distance, rate = lengths(seen.point - need.origin, seen.point_jacobian, aside=0)
        return motion.rows_of_all(distance[:, None], rate[:, None, :])

    def expression(self, kinematics: "SymbolicKinematics") -> "ca.SX":
        import casadi as ca

        from trajopt.optimise.terms.symbolic import length

        need = self.required
        return length(kinematics.point(need.reference, need.target, need.frame) - ca.SX(need.origin))


@constrain.register
def _(required: Gaze, reduced: ReducedModel, window: Window, inset: float = INSET) -> tuple[Constraint, ...]:
    angle = constraint(
        ViewAngle(reduced, required),
        lower=-np.inf,
        upper=required.angle * (1.0 - inset),
        tolerance=max(required.angle * inset * 0.5, 1e-9),
        window=window,
    )
    if required.nearest == 0.0 and np.isinf(required.farthest):
        return (angle,)
    kept = inset * 0.5 * min(required.farthest - required.nearest, RESERVED_DISTANCE)
    distance = constraint(
        ViewDistance(reduced, required),
        lower=required.nearest + kept if required.nearest > 0.0 else -np.inf,
        upper=required.farthest - kept,
        tolerance=max(0.5 * kept, 1e-9),
        window=window,
    )
    return (angle, distance)
