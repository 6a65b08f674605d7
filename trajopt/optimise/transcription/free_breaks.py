"""Transcription with free breaks: a cubic spline in time through waypoints, each piece with its own duration.

The last column of the control points has the logarithms of durations, of piece j at control point j + 1.
Piece j depends on control points j to j + 3 and the durations of pieces j - 2 to j + 2: all rows are banded.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from trajopt.geometry.dynamics import DynamicsQuery
from trajopt.optimise.nlp import ConstraintRows, CostRows, Linearisation
from trajopt.optimise.transcription.bspline import COARSE_SAMPLES, Number, basis_weights
from trajopt.optimise.transcription.free_duration import (
    RESTING,
    SHORTEST,
    SMOOTHNESS,
    TOLERANCE,
    held_by_motors,
    least_duration,
    widened,
)
from trajopt.optimise.transcription.knots import KnotsNlp, swept_samples
from trajopt.optimise.transcription.motion_nlp import MotionNlp
from trajopt.problem.motion import Motion
from trajopt.problem.smoothness import Acceleration, Jerk, Velocity
from trajopt.timing.time_scaling import travel_time
from trajopt.values.arrays import Bools, Floats, Ints, Loss, Rows, readonly
from trajopt.values.trajectory import Trajectory

DEGREE = 3
NEAR = 5
"""Number of control points and durations on which a place depends."""
LEAST_PIECES = 3
"""Least pieces between two waypoints."""
STEP = 1e-30
"""Imaginary step of derivatives, which are exact (Squire and Trapp, SIAM Review, 1998)."""
LISTED = 0.3
"""Share of a limit from which it has a row."""
HELD = 3.0
"""Weight of requirements relative to limits: a slower motion keeps a limit, but reaches no waypoint."""
STRETCH = 5.0
"""Largest ratio of a piece's duration to that of the seed, and of the seed's to it."""


@dataclass(frozen=True, eq=False)
class MotionOnBreaks(Motion):
    """Samples of a spline whose breaks move.

    Attributes:
        slopes: Derivatives of each sample's positions by the last column of its support, shape (S, k, n).
    """

    slopes: Floats

    def where(self, mask: Bools) -> "MotionOnBreaks":
        part = super().where(mask)
        fields = (part.knots, part.support, part.weight, part.place, part.positions, part.query)
        return MotionOnBreaks(*fields, self.slopes[mask])

    def rows(self, sample: Ints, value: Floats, jacobian: Floats, component: Ints) -> Rows:
        rows = super().rows(sample, value, jacobian, component)
        by_time = np.einsum("mkn,mn->mk", self.slopes[sample], jacobian)
        return replace(rows, jacobian=np.concatenate((rows.jacobian, by_time[..., None]), axis=2))


@dataclass(frozen=True, eq=False)
class SplineValues:
    """Positions or derivatives at some places of the spline.

    Attributes:
        support: Control points near each, shape (s, 5).
        weight: Their weights, shape (s, 5).
        value: Shape (s, n).
        slopes: Derivatives by the last column of the support, shape (s, 5, n).
    """

    support: Ints
    weight: Floats
    value: Floats
    slopes: Floats


@dataclass(eq=False)
class FreeBreaksNlp(MotionNlp):
    """The program over control points and durations.

    Attributes:
        places: Of the breaks, in knots of a polyline, shape (m + 1,).
        reference: Unit of the durations [s].
        unit: Unit of the problem's rows [rad | m].
    """

    places: Floats
    reference: float
    unit: float
    dynamics: DynamicsQuery | None

    @staticmethod
    def through(
        base: KnotsNlp, path: Floats, dynamics: DynamicsQuery | None, least: int
    ) -> "tuple[FreeBreaksNlp, Floats]":
        """Return the program, and a seed that rests at each waypoint of a path (N, n).

        Args:
            least: Fewest pieces of all legs together.
        """
        from scipy.interpolate import make_interp_spline

        limits, stops = base.problem.limits, np.array((0, *base.waypoint_knots, len(path) - 1))
        travel = np.add.reduceat(np.abs(np.diff(path, axis=0)), stops[:-1], axis=0)
        times = np.maximum(travel_time(0.0 * travel, travel, limits, rests=True), SHORTEST)
        wanted = max(least, LEAST_PIECES * len(times)) * times / times.sum()
        pieces = np.maximum(LEAST_PIECES, np.ceil(wanted)).astype(np.int64)
        leg = np.repeat(np.arange(len(pieces)), pieces)
        begun = np.repeat(np.cumsum(pieces) - pieces, pieces)
        share = (np.arange(len(leg)) - begun) / pieces[leg]
        eased = share**3 * (10.0 - 15.0 * share + 6.0 * share**2)
        places = np.append(stops[leg] + eased * np.diff(stops)[leg], stops[-1])
        seconds = (times / pieces)[leg]
        breaks = np.concatenate((np.zeros(1), np.cumsum(seconds)))
        before = np.minimum(places.astype(np.int64), len(path) - 2)
        points = path[before] + (places - before)[:, None] * np.diff(path, axis=0)[before]
        control: Floats = np.array(make_interp_spline(breaks, points, DEGREE, bc_type="clamped").c)
        control[:RESTING], control[-RESTING:] = path[0], path[-1]
        reference = float(seconds.mean())
        seed = np.hstack((control, np.zeros((len(control), 1))))
        seed[1 : 1 + len(seconds), -1] = np.log(seconds / reference)
        lower, upper = (np.tile(side[1], (len(control), 1)) for side in (base.lower, base.upper))
        lower, upper = (np.hstack((side, seed[:, -1:])) for side in (lower, upper))
        lower[1 : 1 + len(seconds), -1] -= np.log(STRETCH)
        upper[1 : 1 + len(seconds), -1] += np.log(STRETCH)
        for side in (lower, upper):
            side[:RESTING, :-1], side[-RESTING:, :-1] = path[0], path[-1]
        step = float((travel / pieces[:, None]).max(axis=1).mean())
        scale = np.append(base.scale * LEAST_PIECES * step, 1.0)
        fields = base.problem, base.counts, lower, upper, scale, base.query, base.constraints
        return FreeBreaksNlp(*fields, places, reference, step / HELD, dynamics), seed

    def sampling(self, x: Floats, *, fine: bool) -> Ints:
        pieces = len(self.places) - 1
        if not fine:
            return np.full(pieces, COARSE_SAMPLES)
        corners = self._local(x, *self._breaks, order=0).value
        return swept_samples(self.query, corners, COARSE_SAMPLES)

    def motion(self, x: Floats, sampling: Ints) -> MotionOnBreaks:
        piece = np.repeat(np.arange(len(sampling)), sampling)
        starts = np.repeat(np.cumsum(sampling) - sampling, sampling)
        share = np.append((np.arange(len(piece)) - starts) / sampling[piece], 1.0)
        piece = np.append(piece, len(sampling) - 1)
        place = self.places[piece] + share * np.diff(self.places)[piece]
        at = self._local(x, piece, share, order=0)
        return MotionOnBreaks(x[:, :-1], at.support, at.weight, place, at.value, self.query, at.slopes)

    def linearise(self, x: Floats, sampling: Ints) -> Linearisation:
        motion = self.motion(x, sampling)
        # The duration replaces the costs of length and smoothness.
        costs = [
            self.cost_rows(cost, motion)
            for cost in self.problem.costs or ()
            if not isinstance(cost.residual, Velocity | Acceleration | Jerk)
        ]
        weight = SMOOTHNESS * len(sampling)
        costs = [replace(each, rows=_beside(each.rows, x), weight=weight * each.weight) for each in costs]
        constraints = [self.constraint_rows(item, motion) for item in self.constraints]
        constraints = [_scaled(replace(each, rows=_beside(each.rows, x)), self.unit) for each in constraints]
        constraints += [self._limit(x, order) for order in (1, 2, 3)]
        if self.dynamics is not None:
            constraints.append(self._torque(x, self.dynamics))
        return Linearisation(x, (_duration(x, len(sampling)), *costs), tuple(constraints), sampling)

    def decode(self, x: Floats) -> Trajectory:
        limits, seconds = self.problem.limits, self._seconds(x)
        total = float(seconds.sum())
        breaks = np.concatenate((np.zeros(1), np.cumsum(seconds))) / total
        position, speed, bend = self._states(x, *self._breaks)
        duration = least_duration(breaks, speed * total, bend * total**2, limits)
        if self.dynamics is not None:
            middle = self._states(x, np.arange(len(seconds)), np.full(len(seconds), 0.5))
            q, v, a = (np.concatenate(pair) for pair in zip((position, speed, bend), middle, strict=True))
            states = q, v * total, a * total**2
            duration = held_by_motors(self.dynamics, limits.effort, states, duration)
        slower = total / duration
        return Trajectory(
            limits.joint_names,
            readonly(breaks * duration),
            readonly(position),
            readonly(speed * slower),
            readonly(bend * slower**2),
        )

    def _states(self, x: Floats, piece: Ints, share: Floats) -> tuple[Floats, Floats, Floats]:
        position, speed, bend = (self._local(x, piece, share, order=order).value for order in range(DEGREE))
        return position, speed, bend

    def _seconds(self, x: Floats) -> Floats:
        return self.reference * np.exp(x[1 : len(self.places), -1])

    @property
    def _breaks(self) -> tuple[Ints, Floats]:
        last = len(self.places) - 2
        piece = np.minimum(np.arange(last + 2), last)
        return piece, np.where(np.arange(last + 2) > last, 1.0, 0.0)

    def _local(self, x: Floats, piece: Ints, share: Floats, *, order: int) -> SplineValues:
        """Return positions or derivatives by time at shares of pieces, each of shape (s,)."""
        near = np.pad(self._seconds(x), 2)[piece[:, None] + np.arange(NEAR)]
        first = np.maximum(piece - 1, 0)
        support = first[:, None] + np.arange(NEAR)
        control = x[piece[:, None] + np.arange(DEGREE + 1), :-1]
        own = _weights(near, share, order)
        weight = np.zeros(support.shape)
        np.put_along_axis(weight, (piece - first)[:, None] + np.arange(DEGREE + 1), own, axis=1)
        slopes = np.zeros((*support.shape, control.shape[2]))
        for column in range(NEAR):
            moved = near.astype(np.complex128)
            moved[:, column] *= 1.0 + STEP * 1j
            slope = np.einsum("sk,skn->sn", _weights(moved, share, order).imag / STEP, control)
            inside = np.flatnonzero(near[:, column] > 0.0)
            slopes[inside, (piece - first - 1 + column)[inside]] = slope[inside]
        return SplineValues(support, weight, np.einsum("sk,skn->sn", own, control), slopes)

    def _limit(self, x: Floats, order: int) -> ConstraintRows:
        """Return rows of a derivative, as shares of its limits, at its largest values."""
        problem, count = self.problem, len(self.places) - 1
        limits, pieces = problem.limits, np.arange(count)
        limit = (limits.velocity, limits.acceleration, limits.jerk)[order - 1]
        kept = np.flatnonzero(np.isfinite(limit))
        # The velocity is quadratic in a piece, the acceleration linear, and the jerk constant.
        piece, share = {
            1: (np.repeat(pieces, 2), np.tile((0.0, 0.5), count)),
            2: (pieces[1:], np.zeros(count - 1)),
            3: (pieces, np.full(count, 0.5)),
        }[order]
        at = self._local(x, piece, share, order=order)
        jacobian = np.zeros((len(piece), len(kept), NEAR, x.shape[1]))
        jacobian[:, np.arange(len(kept)), :, kept] = at.weight[None] / limit[kept, None, None]
        jacobian[..., -1] = np.swapaxes(at.slopes, 1, 2)[:, kept] / limit[kept, None]
        name = ("velocity limit", "acceleration limit", "jerk limit")[order - 1]
        return self._shares(name, at.value[:, kept] / limit[kept], jacobian, at.support, kept, piece)

    def _torque(self, x: Floats, dynamics: DynamicsQuery) -> ConstraintRows:
        piece = np.arange(1, len(self.places) - 1)
        states = [self._local(x, piece, np.zeros(len(piece)), order=order) for order in range(DEGREE)]
        slopes = dynamics.torque_slopes(*(state.value for state in states))
        by_state = (slopes.position, slopes.velocity, slopes.acceleration)
        effort = self.problem.limits.effort
        kept = np.flatnonzero(np.isfinite(effort))
        jacobian = np.zeros((len(piece), len(kept), NEAR, x.shape[1]))
        for slope, state in zip(by_state, states, strict=True):
            share = slope[:, kept] / effort[kept, None]
            jacobian[..., :-1] += state.weight[:, None, :, None] * share[:, :, None, :]
            jacobian[..., -1] += np.einsum("sij,skj->sik", share, state.slopes)
        value = slopes.torque[:, kept] / effort[kept]
        return self._shares("torque limit", value, jacobian, states[0].support, kept, piece)

    def _shares(
        self, name: str, value: Floats, jacobian: Floats, support: Ints, kept: Ints, piece: Ints
    ) -> ConstraintRows:
        where, joint = np.nonzero(np.abs(value) >= LISTED)
        rows = Rows(
            value[where, joint],
            jacobian[where, joint],
            support[where],
            kept[joint],
            self.places[piece[where]],
        )
        one = np.ones(len(where))
        return ConstraintRows(name, rows, -one, one, TOLERANCE, 1.0 - LISTED)


def _weights(near: NDArray[Number], share: Floats, order: int) -> NDArray[Number]:
    """Return the weights of control points in a derivative, shape (s, 4).

    Args:
        near: Durations of the pieces around each place, which is in the middle one, shape (s, 5).
    """
    knots = np.cumsum(np.pad(near, ((0, 0), (1, 0))), axis=1)
    return basis_weights(knots[:, 2:3] + share[:, None] * near[:, 2:3], knots, order)


def _duration(x: Floats, pieces: int) -> CostRows:
    inner = np.arange(1, 1 + pieces)
    value = np.exp(x[inner, -1])
    jacobian = np.zeros((pieces, 1, x.shape[1]))
    jacobian[:, 0, -1] = value
    rows = Rows(value, jacobian, inner[:, None], np.zeros(pieces, dtype=np.int64), np.zeros(pieces))
    return CostRows("duration", rows, np.ones(pieces), Loss.HINGE)


def _scaled(block: ConstraintRows, unit: float) -> ConstraintRows:
    rows = replace(block.rows, value=block.rows.value / unit, jacobian=block.rows.jacobian / unit)
    return replace(
        block,
        rows=rows,
        lower=block.lower / unit,
        upper=block.upper / unit,
        tolerance=block.tolerance / unit,
        reach=block.reach / unit,
    )


def _beside(rows: Rows, x: Floats) -> Rows:
    return rows if rows.jacobian.shape[2] == x.shape[1] else widened(rows)
