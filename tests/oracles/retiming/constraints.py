"""What limits a profile: linear constraints on path acceleration and squared path speed, tools, torques.

Source: Pham and Pham, A new approach to time-optimal path parameterization based on reachability
analysis, IEEE T-RO 34(3), 2018.

Grids are many and fine, and the torque along a path changes slowly: so the inverse dynamics are evaluated
once, at the ends and the middle of panels of the path, and every grid interpolates the torque by parabolas
through them. No panel reaches beyond a knot of the path, where the derivative of the curvature jumps. What
the parabolas miss shows when the trajectory is measured (`torque_range`).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from tests.oracles.retiming.smooth_path import RampedPath, SmoothPath
from trajopt.timing import InverseDynamics, ToolLimits
from trajopt.values.arrays import Floats, Ints
from trajopt.values.trajectory import Trajectory

LARGEST_SQUARED_SPEED = 1e8
"""Bound of x where no velocity limit binds, since all joints turn back at once [-]."""
LEAST_ROOM = 1e-6
"""Part of each limit that is left to motion even where holding still takes more than all of it."""
QUARTERS = (0.25, 0.5, 0.75)
"""Where in each piece speeds are evaluated besides its ends."""
PARTS = (0.2, 0.4, 0.6, 0.8)
"""Where within a piece of a trajectory the torque is evaluated, beside its ends, if it is near a limit."""
CLEAR = 0.8
"""Part of a limit below which three samples of a piece are enough."""
REACH = 0.8
"""How far the joints move in one panel at most, all added up [rad | m]."""
MOST_PANELS = 500.0
"""Panels of very long paths are longer, so that there are about as many."""


@dataclass(frozen=True, eq=False)
class Rows:
    """Limits |a u + b x + c| <= limit at every grid point, one column a limit.

    Attributes:
        a: Factor of the path acceleration, shape (k, m).
        b: Factor of the squared path speed, shape (k, m).
        c: What remains at rest (gravity), shape (k, m).
    """

    a: Floats
    b: Floats
    c: Floats


def squared_speed_bound(derivative: Floats, velocity: Floats) -> Floats:
    """Bound of x = (ds/dt)² by the velocity limits.

    Args:
        derivative: dq/ds at the stations, shape (k, n).
        velocity: Velocity limits at the stations, shape (k, n).

    Returns:
        Shape (k,).
    """
    slope = np.abs(derivative)
    moving = slope > velocity / np.sqrt(LARGEST_SQUARED_SPEED)
    speed = np.where(moving, velocity / np.where(moving, slope, 1.0), np.sqrt(LARGEST_SQUARED_SPEED))
    return speed.min(axis=1) ** 2


class States(NamedTuple):
    """States of n joints at S moments.

    Attributes:
        q: Positions, shape (S, n) [rad | m].
        v: Velocities, shape (S, n) [rad/s | m/s].
        a: Accelerations, shape (S, n) [rad/s^2 | m/s^2].
    """

    q: Floats
    v: Floats
    a: Floats


def at_points(trajectory: Trajectory) -> States:
    """Return the states at the points of a quintic trajectory."""
    assert trajectory.velocities is not None and trajectory.accelerations is not None
    return States(trajectory.positions, trajectory.velocities, trajectory.accelerations)


def within(trajectory: Trajectory, part: float, pieces: Ints | slice = slice(None)) -> States:
    """Evaluate a quintic trajectory at one part of some of its pieces.

    Args:
        trajectory: Of k points.
        part: How much of the time of each piece has passed, from 0 to 1.
        pieces: Which pieces; all k - 1 by default.
    """
    c0, c1, c2, c3, c4, c5 = trajectory.coefficients[:, pieces]
    t = part * np.diff(trajectory.times)[pieces, None]
    return States(
        ((((c0 * t + c1) * t + c2) * t + c3) * t + c4) * t + c5,
        (((5.0 * c0 * t + 4.0 * c1) * t + 3.0 * c2) * t + 2.0 * c3) * t + c4,
        ((20.0 * c0 * t + 12.0 * c1) * t + 6.0 * c2) * t + 2.0 * c3,
    )


def joined(states: Sequence[States]) -> States:
    """Put states one after the other."""
    q, v, a = (np.concatenate(part) for part in zip(*states, strict=True))
    return States(q, v, a)


def tool_speed_peaks(tools: ToolLimits, trajectory: Trajectory) -> Floats:
    """Bound the speeds in each piece of a trajectory.

    They are taken at the points and at quarters between. A parabola through three even samples rises above
    them by an eighth of the second difference; eight times as much is added.

    Returns:
        Shape (k - 1, m) [m/s | rad/s].
    """
    ends, inner = at_points(trajectory), [within(trajectory, share) for share in QUARTERS]
    states = (ends, *inner)
    sampled = tools.speeds(
        np.concatenate([state.q for state in states]), np.concatenate([state.v for state in states])
    )
    count = len(ends.q) - 1
    between = sampled[count + 1 :].reshape(len(QUARTERS), count, -1)
    speeds = np.concatenate((sampled[None, :count], between, sampled[None, 1 : count + 1]))
    rise = np.abs(np.diff(speeds, n=2, axis=0)).max(axis=0)
    return speeds.max(axis=0) + rise


@dataclass(frozen=True, eq=False)
class TorqueLimits:
    """Joints with a torque limit, and the function that returns their torque.

    Attributes:
        inverse_dynamics: Torques of all joints.
        joints: Places of the limited joints, shape (m,).
        limit: Their limits, shape (m,) [Nm | N].
    """

    inverse_dynamics: InverseDynamics
    joints: Ints
    limit: Floats

    def at(self, q: Floats, v: Floats, a: Floats) -> Floats:
        """Torques of the limited joints at some points, (k, n) each -> (k, m) [Nm | N]."""
        return self.inverse_dynamics(q, v, a)[:, self.joints]


def torque_range(torque: TorqueLimits, trajectory: Trajectory) -> tuple[Floats, Floats]:
    """Bound the torque in each piece of a trajectory.

    It is evaluated at the points and half-way between. Parabolas through three even samples rise
    above them by an eighth of the second difference; where eight times as much stays clear of the
    limits, that is the bound. Else four samples between the points and twice what a parabola can add.

    Returns:
        Least and largest torque, shape (k - 1, m) each [Nm | N].
    """
    ends, middle = at_points(trajectory), within(trajectory, 0.5)
    sampled = torque.at(*joined((ends, middle)))
    count = len(middle.q)
    left, right = sampled[:count], sampled[1 : count + 1]
    low, high = _bounded(np.stack((left, sampled[count + 1 :], right)), supplement=1.0)
    near = np.nonzero((np.maximum(high, -low) > CLEAR * torque.limit).any(axis=1))[0]
    if len(near):
        inner = torque.at(*joined([within(trajectory, part, near) for part in PARTS]))
        values = (left[near], *np.split(inner, len(PARTS)), right[near])
        low[near], high[near] = _bounded(np.stack(values), supplement=0.25)
    return low, high


def _bounded(values: Floats, *, supplement: float) -> tuple[Floats, Floats]:
    """Bound what has these even samples (first axis): beyond them by a part of the second difference."""
    crest = supplement * np.abs(np.diff(values, 2, axis=0)).max(axis=0)
    return values.min(axis=0) - crest, values.max(axis=0) + crest


@dataclass(frozen=True, eq=False)
class TorqueAlong:
    """Torque along a path as a u + b x + c, u and x the path acceleration and the squared path speed.

    Attributes:
        limits: The limited joints, m of them.
        edges: Where the p panels meet, increasing, shape (p + 1,).
        begin: (a, b, c) at the beginning of each panel, shape (p, 3, m).
        middle: The same in its middle.
        end: The same at its end.
    """

    limits: TorqueLimits
    edges: Floats
    begin: Floats
    middle: Floats
    end: Floats

    def __call__(self, s: Floats) -> Rows:
        """Interpolate at parameters of the path, shape (k,)."""
        panel = np.searchsorted(self.edges[1:-1], s, side="right")
        left, right = self.edges[panel], self.edges[panel + 1]
        part = ((s - left) / (right - left))[:, None, None]
        begin, middle, end = self.begin[panel], self.middle[panel], self.end[panel]
        bend = 2.0 * (begin - 2.0 * middle + end)
        a, b, c = np.moveaxis(begin + part * ((end - begin) - bend * (1.0 - part)), 1, 0)
        return Rows(a, b, c)


@dataclass(frozen=True, eq=False)
class RampedTorque:
    """The same torque over the clock of a ramped path.

    Attributes:
        along: The torque along the path.
        ramp: The path over the clock.
    """

    along: TorqueAlong
    ramp: RampedPath

    @property
    def limits(self) -> TorqueLimits:
        """The limited joints."""
        return self.along.limits

    def __call__(self, clock: Floats) -> Rows:
        """Interpolate at clocks, shape (k,): d²s/dt² = s' u + s'' x and (ds/dt)² = s'^2 x."""
        rows, first, second = (
            self.along(self.ramp.way(clock)),
            self.ramp.way(clock, 1),
            self.ramp.way(clock, 2),
        )
        b = rows.a * second[:, None] + rows.b * first[:, None] ** 2
        return Rows(rows.a * first[:, None], b, rows.c)


def torque_along(path: SmoothPath, limits: TorqueLimits) -> TorqueAlong:
    """Evaluate the torque along a path.

    With v = q' ds/dt and a = q' u + q'' x the equation of motion M(q) a + C(q, v) v + g(q) gives
    a = M q', b = M q'' + C(q, q') q', c = g. Torque that is not of this form (friction) is not seen
    here, but is when the trajectory is checked.

    Args:
        path: The smooth path, of positive length.
        limits: The limited joints.
    """
    edges = _edges(path)
    s = np.concatenate((edges, (edges[:-1] + edges[1:]) / 2.0))
    q, dq, ddq = path(s), path(s, 1), path(s, 2)
    still = np.zeros_like(q)
    a, b, c = np.split(
        limits.at(np.vstack((q, q, q)), np.vstack((still, dq, still)), np.vstack((dq, ddq, still))), 3
    )
    table = np.stack((a - c, b - c, c), axis=1)
    count = len(edges)
    return TorqueAlong(limits, edges, table[: count - 1], table[count:], table[1:count])


def _edges(path: SmoothPath) -> Floats:
    """Cut the pieces of a path evenly into panels."""
    knots, widths = path.knots, np.diff(path.knots)
    speed = np.abs(path(np.concatenate((knots, (knots[:-1] + knots[1:]) / 2.0)), 1)).sum(axis=1)
    ends, middle = speed[: len(knots)], speed[len(knots) :]
    moved = np.maximum(np.maximum(ends[:-1], ends[1:]), middle) * widths
    reach = max(REACH, float(moved.sum()) / MOST_PANELS)
    parts = np.maximum(np.ceil(moved / reach), 1.0).astype(np.int64)
    places = [0, *np.cumsum(parts).tolist()]
    return np.interp(np.arange(places[-1] + 1), places, knots)
