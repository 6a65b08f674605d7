"""Error of a frame's placement: position along the goal's axes, and rotation coordinates.

e = (R_g^T (p - p_g), c(R_g^T R)). The rotation vector is log(R_g^T R) with derivative
J_r^{-1} R^T w (Sola et al., A micro Lie theory, 2018, eq. 144); Euler angles are intrinsic x-y-z.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from trajopt.optimise.terms.frames import lengths, relative_frame
from trajopt.optimise.terms.requirement import INSET, constrain
from trajopt.problem.motion import Motion
from trajopt.problem.requirements import FollowsCurve, FramePlacement, RotationCoordinates
from trajopt.problem.residual import WHOLE, Constraint, Window, constraint
from trajopt.scene.reduced import ReducedModel
from trajopt.values.arrays import Floats, Rows, Value

if TYPE_CHECKING:
    import casadi as ca

    from trajopt.optimise.terms.symbolic import SymbolicKinematics

TINY = 1e-4
"""Sine of the angle below which the axis of a rotation is not read from its skew part."""


@dataclass(frozen=True, eq=False)
class FramePlacementError:
    """Six components: position [m] and rotation [rad] along the axes of the goal placement."""

    reduced: ReducedModel
    required: FramePlacement

    units = (*("m",) * 3, *("rad",) * 3)

    @property
    def name(self) -> str:
        return f"placement of {self.required.frame}"

    def linearise(self, motion: Motion) -> Rows:
        need = self.required
        seen = relative_frame(self.reduced, motion, need.frame, need.reference, need.offset)
        to_goal = need.placement.rotation.T
        rotation = to_goal @ seen.rotation
        body_spin = np.swapaxes(seen.rotation, 1, 2) @ seen.angular_jacobian
        if need.coordinates is RotationCoordinates.ROTATION_VECTOR:
            angles, rate = rotation_vector(rotation)
        else:
            angles, rate = _xyz_euler(rotation)
        value = np.hstack(((seen.point - need.placement.translation) @ to_goal.T, angles))
        jacobian = np.concatenate((to_goal @ seen.point_jacobian, rate @ body_spin), axis=1)
        return motion.rows_of_all(value, jacobian)

    def expression(self, kinematics: "SymbolicKinematics") -> "ca.SX":
        import casadi as ca

        need = self.required
        to_goal = ca.SX(need.placement.rotation.T)
        point = kinematics.point(need.frame, need.offset, need.reference)
        rotation = to_goal @ kinematics.rotation(need.frame, need.reference)
        angles = (
            _symbolic_vector(rotation)
            if need.coordinates is RotationCoordinates.ROTATION_VECTOR
            else _symbolic_euler(rotation)
        )
        return ca.vertcat(to_goal @ (point - ca.SX(need.placement.translation)), angles)


def rotation_vector(rotation: Floats) -> tuple[Floats, Floats]:
    """Return log R, shape (S, 3), and its rate by body-frame angular velocity, (S, 3, 3).

    With R - R^T = 2 sin t [a]x and trace R = 1 + 2 cos t for a turn by t about a.
    """
    difference = rotation - np.swapaxes(rotation, 1, 2)
    sine = 0.5 * np.sqrt(0.5 * np.einsum("sij,sij->s", difference, difference))
    cosine = 0.5 * (np.einsum("sii->s", rotation) - 1.0)
    angle = np.arctan2(sine, cosine)
    ratio = np.where(sine < TINY, 1.0, angle / np.maximum(sine, TINY))
    skew = (0.5 * ratio)[:, None, None] * difference
    half = np.flatnonzero((sine < TINY) & (cosine < 0.0))
    if len(half):
        skew[half] = angle[half, None, None] * _half_turns(rotation[half], difference[half], cosine[half])
    small = angle < 1e-4
    safe = np.where(small, 1.0, angle)
    # 1/t^2 - (1 + cos t) / (2 t sin t), written with the half angle, which is finite at pi.
    factor = np.where(small, 1.0 / 12.0, (1.0 - 0.5 * safe / np.tan(0.5 * safe)) / safe**2)
    rate = np.eye(3) + 0.5 * skew + factor[:, None, None] * (skew @ skew)
    return skew[:, (2, 0, 1), (1, 2, 0)], rate


def _half_turns(rotation: Floats, difference: Floats, cosine: Floats) -> Floats:
    """Return [a]x, shape (S, 3, 3), of turns near pi, where (R + R^T) / 2 = cos t I + (1 - cos t) a a^T."""
    even = 0.5 * (rotation + np.swapaxes(rotation, 1, 2)) - cosine[:, None, None] * np.eye(3)
    columns = np.einsum("sii->si", even).argmax(axis=1)
    axis = np.take_along_axis(even, columns[:, None, None], axis=2)[:, :, 0]
    axis /= np.linalg.norm(axis, axis=1, keepdims=True)
    odd = difference[:, (2, 0, 1), (1, 2, 0)]
    axis *= np.where(np.einsum("si,si->s", axis, odd) < 0.0, -1.0, 1.0)[:, None]
    return np.asarray(np.cross(np.eye(3), axis[:, None]), dtype=np.float64)


def _xyz_euler(rotation: Floats) -> tuple[Floats, Floats]:
    """Return angles (a, b, c) of R = Rx(a) Ry(b) Rz(c) and their rate by body-frame spin.

    The body-frame spin is (cos b cos c, -cos b sin c, sin b) a' + (sin c, cos c, 0) b' +
    (0, 0, 1) c'. At b = +-pi/2 the inverse does not exist; cos b is kept from zero there.
    """
    a = np.arctan2(-rotation[:, 1, 2], rotation[:, 2, 2])
    b = np.arcsin(np.clip(rotation[:, 0, 2], -1.0, 1.0))
    c = np.arctan2(-rotation[:, 0, 1], rotation[:, 0, 0])
    cos_b = np.maximum(np.cos(b), 1e-6)
    cos_c, sin_c, tan_b = np.cos(c), np.sin(c), np.sin(b) / cos_b
    zero, one = np.zeros_like(a), np.ones_like(a)
    rate = np.stack(
        (
            np.stack((cos_c / cos_b, -sin_c / cos_b, zero), 1),
            np.stack((sin_c, cos_c, zero), 1),
            np.stack((-cos_c * tan_b, sin_c * tan_b, one), 1),
        ),
        1,
    )
    return np.stack((a, b, c), 1), rate


@constrain.register
def _(
    required: FramePlacement, reduced: ReducedModel, window: Window, inset: float = INSET
) -> tuple[Constraint, ...]:
    tolerance = np.concatenate((required.position_tolerance, required.rotation_tolerance))
    bound = tolerance * (1.0 - inset)
    return (
        constraint(
            FramePlacementError(reduced, required),
            lower=-bound,
            upper=bound,
            tolerance=float(max(tolerance.min() * inset * 0.5, 1e-9)),
            window=window,
        ),
    )


def _symbolic_vector(rotation: "ca.SX") -> "ca.SX":
    import casadi as ca

    from trajopt.optimise.terms.symbolic import length

    axis = 0.5 * ca.vertcat(
        rotation[2, 1] - rotation[1, 2], rotation[0, 2] - rotation[2, 0], rotation[1, 0] - rotation[0, 1]
    )
    sine = length(axis)
    return axis * (ca.atan2(sine, 0.5 * (ca.trace(rotation) - 1.0)) / sine)


def _symbolic_euler(rotation: "ca.SX") -> "ca.SX":
    import casadi as ca

    return ca.vertcat(
        ca.atan2(-rotation[1, 2], rotation[2, 2]),
        ca.asin(ca.fmin(ca.fmax(rotation[0, 2], -1.0), 1.0)),
        ca.atan2(-rotation[0, 1], rotation[0, 0]),
    )


POSITION_ROWS = 4
"""Components of the position error: three along axes, and the distance."""


@dataclass(frozen=True, eq=False)
class CurveError(Value):
    """Components: position error (x, y, z), its length [m], rotation error (three, two or none) [rad].

    Knot k belongs to location s_k on the curve, with R_c and p_c. The components are R_c^T (p - p_c), its
    length, and the rotation log(R_c^T R), or with a free spin about the axis a of the frame the components of
    R_c^T R a across a.

    Attributes:
        stations: Length along the curve of each knot, shape (N,) [m]; spread evenly when None.
        window: Part of the motion that follows the curve; a single knot is the end.
    """

    reduced: ReducedModel
    required: FollowsCurve
    stations: Floats | None = None
    window: Window = WHOLE

    units = (*("m",) * POSITION_ROWS, *("rad",) * 3)

    @property
    def name(self) -> str:
        return f"curve of {self.required.frame}"

    @property
    def axes_of_rotation(self) -> Floats:
        """Axes of the components of the rotation error, shape (d, 3)."""
        if np.isinf(self.required.rotation_tolerance):
            return np.empty((0, 3))
        if self.required.spin is None:
            return np.eye(3)
        # The components are those of a turn's cross product with the axis of the spin.
        return np.asarray(np.cross(self.required.spin, self._across), dtype=np.float64)

    @cached_property
    def _across(self) -> Floats:
        assert self.required.spin is not None
        axis = self.required.spin
        first = np.array(np.cross(axis, np.eye(3)[int(np.abs(axis).argmin())]), dtype=np.float64)
        first /= np.linalg.norm(first)
        return np.stack((first, np.array(np.cross(axis, first), dtype=np.float64)))

    def linearise(self, motion: Motion) -> Rows:
        last = len(motion.knots) - 1
        # A lone configuration has no place along the curve, unless that is the end alone.
        told = last > 0 or self.stations is not None or self.window.first == self.window.last
        knots = np.isclose(motion.place, np.round(motion.place), rtol=0.0, atol=1e-9)
        at_knots = motion.where(knots & told)
        if self.stations is not None:
            s = np.interp(at_knots.place, np.arange(last + 1), self.stations)
        else:
            first, length = self.window.first, self.window.last - self.window.first
            part = (at_knots.place / last - first) / length if length > 0.0 else np.ones(len(at_knots.place))
            s = self.required.until * np.clip(part, 0.0, 1.0)
        value, jacobian = self.errors(at_knots, s)
        return at_knots.rows_of_all(value, jacobian)

    def errors(self, motion: Motion, s: Floats) -> tuple[Floats, Floats]:
        """Compare S samples with locations of length `s` along the curve, shape (S,) [m].

        Returns:
            Components, shape (S, d), and their derivatives by the sample's configuration, (S, d, n).
        """
        need = self.required
        seen = relative_frame(self.reduced, motion, need.frame, need.reference, need.offset)
        there = need.curve(s)
        inward = np.swapaxes(there.rotation, 1, 2)
        off = np.einsum("sij,sj->si", inward, seen.point - there.translation)
        rate = inward @ seen.point_jacobian
        far, far_rate = lengths(off, rate)
        values, rates = [off, far[:, None]], [rate, far_rate[:, None]]
        if np.isfinite(need.rotation_tolerance):
            turned = inward @ seen.rotation
            if need.spin is None:
                angles, by_spin = rotation_vector(turned)
                values.append(angles)
                rates.append(by_spin @ np.swapaxes(seen.rotation, 1, 2) @ seen.angular_jacobian)
            else:
                across = self._across
                values.append(turned @ need.spin @ across.T)
                axis = np.einsum("sij,j->si", seen.rotation, need.spin)
                turning = np.swapaxes(seen.angular_jacobian, 1, 2)
                moved = np.swapaxes(np.asarray(np.cross(turning, axis[:, None]), dtype=np.float64), 1, 2)
                rates.append(across @ inward @ moved)
        return np.concatenate(values, axis=1), np.concatenate(rates, axis=1)


@constrain.register
def _(
    required: FollowsCurve, reduced: ReducedModel, window: Window, inset: float = INSET
) -> tuple[Constraint, ...]:
    bound = within(required, 1.0 - inset)
    smallest = min(required.position_tolerance, required.rotation_tolerance)
    return (
        constraint(
            CurveError(reduced, required, window=window),
            lower=-bound,
            upper=bound,
            tolerance=max(smallest * inset * 0.5, 1e-9),
            window=window,
        ),
    )


def within(required: FollowsCurve, share: float) -> Floats:
    """Bounds of the components that keep a share of the tolerances, shape (d,)."""
    turned = 0 if np.isinf(required.rotation_tolerance) else 3 if required.spin is None else 2
    angle = share * required.rotation_tolerance / np.sqrt(max(turned, 1))
    distance = share * required.position_tolerance
    return np.concatenate((np.full(POSITION_ROWS, distance), np.full(turned, angle)))
