"""Deviation of a frame from its location on a curve, at the knots of a motion.

The knots are spread along the curve: knot k belongs to its location s_k, with R_c and p_c. The components are
R_c^T (p - p_c), its length, and the rotation log(R_c^T R), or with a free spin about the axis a of the
frame the components of R_c^T R a that are across a.
"""

from dataclasses import dataclass

import numpy as np

from trajopt.optimise.terms.frame_placement import rotation_vector
from trajopt.optimise.terms.frames import lengths, relative_frame
from trajopt.optimise.terms.requirement import INSET, constrain
from trajopt.problem.motion import Motion
from trajopt.problem.requirements import FollowsCurve
from trajopt.problem.residual import WHOLE, Constraint, Window, constraint
from trajopt.scene.reduced import ReducedModel
from trajopt.values.arrays import Floats, Rows, Value

POSITION_ROWS = 4
"""Components of the position error: three along axes, and the distance."""


@dataclass(frozen=True, eq=False)
class CurveError(Value):
    """Components: position error (x, y, z), its length [m], rotation error (three, two or none) [rad].

    Attributes:
        reduced: The robot and its surroundings.
        required: The curve and the frame that follows it.
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
        """The frame that follows."""
        return f"curve of {self.required.frame}"

    def linearise(self, motion: Motion) -> Rows:
        """Evaluate and differentiate at the knots among the samples."""
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
        """Compare every sample with a location on the curve.

        Args:
            motion: S samples.
            s: Length of each along the curve, shape (S,) [m].

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
                across = aside(need.spin)
                values.append(turned @ need.spin @ across.T)
                axis = np.einsum("sij,j->si", seen.rotation, need.spin)
                turning = np.swapaxes(seen.angular_jacobian, 1, 2)
                moved = np.swapaxes(np.asarray(np.cross(turning, axis[:, None]), dtype=np.float64), 1, 2)
                rates.append(across @ inward @ moved)
        return np.concatenate(values, axis=1), np.concatenate(rates, axis=1)


def aside(axis: Floats) -> Floats:
    """Return two unit vectors across an axis and each other, shape (2, 3)."""
    first = np.array(np.cross(axis, np.eye(3)[int(np.abs(axis).argmin())]), dtype=np.float64)
    first /= np.linalg.norm(first)
    return np.stack((first, np.array(np.cross(axis, first), dtype=np.float64)))


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
