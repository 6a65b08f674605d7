"""Transcription with free duration: shape and duration of a motion together.

A cubic B-spline over t / T. Its derivatives lie between their control points D^r c, linear in the control
points c; so |D^r c| <= limit_r T^r at finitely many places holds velocity (r = 1), acceleration (2) and jerk
(3) at all times. Acceleration is linear between breaks and jerk constant, so their bounds are exact. T is one
more coordinate of every control point, tied to its neighbours, so that all rows stay near the diagonal.
"""

from dataclasses import dataclass, replace

import numpy as np

from trajopt.geometry import WorkCounts
from trajopt.geometry.dynamics import DynamicsQuery
from trajopt.optimise.nlp import ConstraintRows, CostRows, Linearisation
from trajopt.optimise.transcription.bspline import BsplineNlp, SplineBasis, fitted
from trajopt.robot.joints import JointLimits
from trajopt.values.arrays import Floats, Ints, Loss, Rows, readonly
from trajopt.values.trajectory import Trajectory

RESTING = 3
"""Control points at either end that coincide: there the motion rests, without acceleration."""
TOLERANCE = 1e-3
"""Accepted excess over limits in the program: the final duration holds all."""
SHORTEST = 1e-2
"""Least duration of any motion, including one that does not move [s]."""
ROUNDING = 1e-9
"""Share of the duration left to rounding."""
STRETCH = 2e-3
"""Share by which a duration is lengthened per step until the torques are within their limits."""
STRETCHES = 300
"""Most stretches: the arm then moves at half the speed."""
SMOOTHNESS = 1e-2
"""Weight of the problem's own costs relative to the duration, which is 1 at first."""


@dataclass(eq=False)
class FreeDurationNlp:
    """The program over control points and duration; the last column is the duration over the reference.

    Attributes:
        reference: Duration of the seed [s].
        start_velocities: Shape (n,) [rad/s | m/s].
        start_accelerations: Shape (n,) [rad/s^2 | m/s^2].
    """

    spline: BsplineNlp
    limits: JointLimits
    reference: float
    dynamics: DynamicsQuery | None
    start_velocities: Floats
    start_accelerations: Floats

    def __post_init__(self) -> None:
        basis = self.spline.basis
        self._derivatives = [basis.derivative(order) for order in (1, 2, 3)]
        # From a start in motion a longer duration does not make up for what the tolerance lets pass.
        share = 1.0 - 2.0 * TOLERANCE if self.moving else 1.0
        begin = (np.abs(self.start_velocities), np.abs(self.start_accelerations), 0.0)
        limits = (self.limits.velocity, self.limits.acceleration, self.limits.jerk)
        self._bounds = [
            np.maximum(share * limit, rate) * self.reference**order
            for order, (limit, rate) in enumerate(zip(limits, begin, strict=True), 1)
        ]

    @property
    def moving(self) -> bool:
        return bool(self.start_velocities.any() or self.start_accelerations.any())

    @property
    def lower(self) -> Floats:
        return _beside(self.spline.lower, 0.1)

    @property
    def upper(self) -> Floats:
        return _beside(self.spline.upper, 3.0)

    @property
    def scale(self) -> Floats:
        return np.append(self.spline.scale, 1.0)

    @property
    def counts(self) -> WorkCounts:
        return self.spline.counts

    def fitted(self, parameters: Floats, positions: Floats) -> Floats:
        first = self._started(np.tile(positions[0], (RESTING, 1)), self.reference)
        return fitted(self.spline.basis, parameters, positions, resting=RESTING, first=first)

    def sampling(self, x: Floats, *, fine: bool) -> Ints:
        return self.spline.sampling(x[:, :-1], fine=fine)

    def linearise(self, x: Floats, sampling: Ints) -> Linearisation:
        at = self.spline.linearise(x[:, :-1], sampling)
        costs = [
            replace(block, rows=widened(block.rows), weight=SMOOTHNESS * block.weight) for block in at.costs
        ]
        constraints = [replace(block, rows=widened(block.rows), reach=np.inf) for block in at.constraints]
        constraints += [self._limit(x, order) for order in (1, 2, 3)]
        if self.dynamics is not None:
            constraints.append(self._torque(x))
        if self.moving:
            constraints += [self._start(x, order) for order in (1, 2)]
        constraints.append(_tied(x))
        return Linearisation(x, (_duration(x), *costs), tuple(constraints), sampling)

    def decode(self, x: Floats) -> Trajectory:
        basis, control = self.spline.basis, x[:, :-1]
        breaks = basis.breaks
        duration = self._duration_of(control)
        if self.moving:
            # The first control points and the duration depend on each other.
            duration = max(duration, self.reference * float(x[0, -1]))
            for _ in range(STRETCHES):
                control = self._started(control, duration)
                # A start at the very limit leaves no room for rounding.
                if self._duration_of(control) <= duration * (1.0 + 2.0 * ROUNDING):
                    break
                duration *= 1.0 + 0.1 * STRETCH
        position, speed, bend = (basis.derivative_at(breaks, order)(control) for order in (0, 1, 2))
        return Trajectory(
            self.limits.joint_names,
            readonly(breaks * duration),
            readonly(position),
            readonly(speed / duration),
            readonly(bend / duration**2),
        )

    def _duration_of(self, control: Floats) -> float:
        breaks = self.spline.basis.breaks
        speed, bend = (self.spline.basis.derivative_at(breaks, order)(control) for order in (1, 2))
        return self._held_by_motors(control, least_duration(breaks, speed, bend, self.limits))

    def _started(self, control: Floats, duration: float) -> Floats:
        first, second = (self._derivatives[order].weight[0] for order in (0, 1))
        moved = control.copy()
        moved[1] = (self.start_velocities * duration - first[0] * moved[0]) / first[1]
        bend = self.start_accelerations * duration**2
        moved[2] = (bend - second[0] * moved[0] - second[1] * moved[1]) / second[2]
        return moved

    def _held_by_motors(self, control: Floats, duration: float) -> float:
        if self.dynamics is None:
            return duration
        basis = self.spline.basis
        between = (basis.breaks[:-1] + basis.breaks[1:]) / 2.0
        at = np.concatenate((basis.breaks, between))
        position, speed, bend = (basis.derivative_at(at, order)(control) for order in (0, 1, 2))
        return held_by_motors(self.dynamics, self.limits.effort, (position, speed, bend), duration)

    def _limit(self, x: Floats, order: int) -> ConstraintRows:
        """Rows +-D^r c / limit - T^r <= 0, each in units of the limit."""
        stencils, limit = self._derivatives[order - 1], self._bounds[order - 1]
        share = stencils(x[:, :-1]) / limit
        tau = x[stencils.support[:, 0], -1]
        room = tau**order
        limited = np.flatnonzero(np.isfinite(limit))
        which, joint, sign = (
            index.ravel() for index in np.meshgrid(np.arange(len(share)), limited, (-1.0, 1.0), indexing="ij")
        )
        jacobian = np.zeros((len(which), order + 1, x.shape[1]))
        factor = (sign / limit[joint])[:, None] * stencils.weight[which]
        np.put_along_axis(jacobian, joint[:, None, None], factor[:, :, None], axis=2)
        jacobian[:, 0, -1] = -order * tau[which] ** (order - 1)
        support = stencils.support[which]
        value = sign * share[which, joint] - room[which]
        place = self.spline.places(_greville(self.spline.basis, support))
        return _capped(
            ("velocity limit", "acceleration limit", "jerk limit")[order - 1],
            Rows(value, jacobian, support, joint.astype(np.int64), place),
        )

    def _start(self, x: Floats, order: int) -> ConstraintRows:
        """Rows of the first control point of a derivative, in units of its limit, as shares of it."""
        stencils, limit = self._derivatives[order - 1], self._bounds[order - 1]
        rates = (self.start_velocities, self.start_accelerations)[order - 1] * self.reference**order
        wanted, joints = rates * x[0, -1] ** order, np.arange(len(limit))
        jacobian = np.zeros((len(limit), order + 1, x.shape[1]))
        jacobian[joints, :, joints] = stencils.weight[0] / limit[:, None]
        jacobian[:, 0, -1] = -order * rates * x[0, -1] ** (order - 1) / limit
        value = (stencils.weight[0] @ x[: order + 1, :-1] - wanted) / limit
        support = np.tile(stencils.support[0], (len(limit), 1))
        none = np.zeros(len(limit))
        rows = Rows(value, jacobian, support, joints.astype(np.int64), none)
        name = ("start velocity", "start acceleration")[order - 1]
        return ConstraintRows(name, rows, none, none, TOLERANCE)

    def _torque(self, x: Floats) -> ConstraintRows:
        assert self.dynamics is not None
        basis = self.spline.basis
        breaks = basis.breaks
        position, speed, bend = (
            basis.at(breaks),
            basis.derivative_at(breaks, 1),
            basis.derivative_at(breaks, 2),
        )
        control, tau = x[:, :-1], x[position.support[:, 0], -1]
        time = (self.reference * tau)[:, None]
        q, v, a = position(control), speed(control) / time, bend(control) / time**2
        slopes = self.dynamics.torque_slopes(q, v, a)
        kept = np.flatnonzero(np.isfinite(self.limits.effort))
        by_control = (
            slopes.position[:, None] * position.weight[:, :, None, None]
            + slopes.velocity[:, None] * (speed.weight / time)[:, :, None, None]
            + slopes.acceleration[:, None] * (bend.weight / time**2)[:, :, None, None]
        )
        by_time = -np.einsum("sij,sj->si", slopes.velocity, v) - 2.0 * np.einsum(
            "sij,sj->si", slopes.acceleration, a
        )
        effort = self.limits.effort[kept]
        jacobian = np.zeros((len(q), len(kept), position.support.shape[1], x.shape[1]))
        jacobian[..., :-1] = np.swapaxes(by_control[:, :, kept], 1, 2) / effort[:, None, None]
        jacobian[:, :, 0, -1] = by_time[:, kept] / tau[:, None] / effort
        value = slopes.torque[:, kept] / effort
        count = value.size
        rows = Rows(
            value.ravel(),
            jacobian.reshape(count, *jacobian.shape[2:]),
            np.repeat(position.support, len(kept), axis=0),
            np.tile(kept, len(q)),
            np.repeat(self.spline.places(breaks), len(kept)),
        )
        one = np.ones(count)
        return ConstraintRows("torque limit", rows, -one, one, TOLERANCE)


def least_duration(breaks: Floats, speed: Floats, bend: Floats, limits: JointLimits) -> float:
    """Return the least duration in which a cubic spline over [0, 1] holds the limits at all times [s].

    Args:
        breaks: Of the spline, shape (m,).
        speed: First derivatives there, shape (m, n).
        bend: Second derivatives there, shape (m, n); linear between.
    """
    length = np.diff(breaks)[:, None]
    change = np.diff(bend, axis=0)
    turns = bend[:-1] * bend[1:] < 0.0
    # Where the second derivative vanishes within a piece the first has an extreme.
    share = np.where(turns, -bend[:-1] / np.where(turns, change, 1.0), 0.0)
    extreme = speed[:-1] + 0.5 * bend[:-1] * share * length
    fastest = np.maximum(np.abs(speed).max(axis=0), np.abs(extreme).max(axis=0))
    needed = (
        fastest / limits.velocity,
        np.sqrt(np.abs(bend).max(axis=0) / limits.acceleration),
        np.cbrt(np.abs(change / length).max(axis=0) / limits.jerk),
    )
    return max(float(np.max(needed)) * (1.0 + ROUNDING), SHORTEST)


def held_by_motors(
    dynamics: DynamicsQuery, effort: Floats, states: tuple[Floats, Floats, Floats], duration: float
) -> float:
    """Return a duration, lengthened until the torques are within their limits [s].

    Args:
        states: Positions and their first and second derivatives over [0, 1], shape (s, n) each.
    """
    position, speed, bend = states
    for _ in range(STRETCHES):
        torque = dynamics.torque(position, speed / duration, bend / duration**2)
        if (np.abs(torque) <= effort).all():
            break
        duration *= 1.0 + STRETCH
    return duration


def _duration(x: Floats) -> CostRows:
    """The duration, in units of the reference; the first copy is used for all."""
    jacobian = np.zeros((1, 1, x.shape[1]))
    jacobian[0, 0, -1] = 1.0
    zero = np.zeros(1)
    rows = Rows(
        x[:1, -1].copy(), jacobian, np.zeros((1, 1), dtype=np.int64), np.zeros(1, dtype=np.int64), zero
    )
    return CostRows("duration", rows, np.ones(1), Loss.HINGE)


def _tied(x: Floats) -> ConstraintRows:
    count = len(x) - 1
    first = np.arange(count)
    jacobian = np.zeros((count, 2, x.shape[1]))
    jacobian[:, 0, -1], jacobian[:, 1, -1] = -1.0, 1.0
    rows = Rows(
        np.diff(x[:, -1]),
        jacobian,
        np.stack((first, first + 1), axis=1),
        np.zeros(count, dtype=np.int64),
        np.zeros(count),
    )
    none = np.zeros(count)
    return ConstraintRows("one duration", rows, none, none, TOLERANCE)


def _capped(name: str, rows: Rows) -> ConstraintRows:
    count = len(rows.value)
    return ConstraintRows(name, rows, np.full(count, -np.inf), np.zeros(count), TOLERANCE)


def widened(rows: Rows) -> Rows:
    jacobian = np.zeros((*rows.jacobian.shape[:2], rows.jacobian.shape[2] + 1))
    jacobian[..., :-1] = rows.jacobian
    return Rows(rows.value, jacobian, rows.knots, rows.component, rows.place)


def _beside(bounds: Floats, value: float) -> Floats:
    return np.hstack((bounds, np.full((len(bounds), 1), value)))


def _greville(basis: SplineBasis, support: Ints) -> Floats:
    knots = basis.knots
    sites = np.convolve(knots[1:-1], np.full(basis.degree, 1.0 / basis.degree), mode="valid")
    return sites[support].mean(axis=1)
