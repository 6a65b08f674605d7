"""The program of a jerk-limited profile: minimise the duration within rows of limits.

The unknowns are control values z at the stations of a squared clock speed y, a quadratic B-spline as in
`tests.oracles.retiming.profile`, but positive at the ends too. With p = dq/dclock and so on, at a grid point

    acceleration  q'' = p u + p' y,                   u = y' / 2,
    jerk          q''' = sqrt(y) (p y'' / 2 + 3/2 p' y' + p'' y).

The acceleration is linear in z. The jerk's limit reads |linear in z| <= jerk / sqrt(y), whose right-hand
side is convex: its tangent lies below, so what holds with the tangent holds exactly.

Source: the form of the rows is that of Debrouwere et al., Time-optimal path following for robots with
convex-concave constraints using sequential convex programming, IEEE T-RO 29(6), 2013.
"""

from dataclasses import dataclass

import numpy as np

from tests.oracles.retiming.constraints import LEAST_ROOM, squared_speed_bound
from tests.oracles.retiming.discretised_path import Bounds, DiscretisedPath
from tests.oracles.retiming.profile import stations
from tests.oracles.retiming.smooth_path import RampedPath
from trajopt.values.arrays import Floats, Ints

LARGEST = 1e4
"""Bound of the squared clock speed where nothing else bounds it [-]."""


class NothingFits(ArithmeticError):
    """No uniform scaling of a profile is within all limits, however slow it is."""


@dataclass(frozen=True, eq=False)
class Program:
    """Rows of limits, in blocks of three neighbouring control values, one block an interval of the grid.

    Attributes:
        weight: Of 1 / sqrt(z) in the duration, shape (k + 1,) [s].
        bound: What z must stay below, shape (k + 1,).
        rows: Factors of the values, shape (k - 1, m + r, 3): m of acceleration and torque, then r of jerk.
        above: What the first m values must stay below, positive, shape (k - 1, m).
        below: What their negatives must stay below, positive, shape (k - 1, m).
        jerk: Limits of the other values times sqrt(y), shape (k - 1, r).
        speed: Factors of y at the start and at the end of each interval, shape (k - 1, 2, 3).
    """

    weight: Floats
    bound: Floats
    rows: Floats
    above: Floats
    below: Floats
    jerk: Floats
    speed: Floats


@dataclass(frozen=True, eq=False)
class JerkRows:
    """The part of a program that does not depend on the limits.

    Attributes:
        on: The path on the grid of the clock.
        moving: Places of the joints that move.
        columns: Places of their accelerations and of the torques among the rows of the path.
        weight: As in `Program`.
        rows: As in `Program`.
        speed: As in `Program`.
    """

    on: DiscretisedPath
    moving: Ints
    columns: Ints
    weight: Floats
    rows: Floats
    speed: Floats

    def within(self, bounds: Bounds) -> Program:
        """Set the limits; those of the jerk must be given, infinite where there is none."""
        assert bounds.jerk is not None
        room, c = bounds.rows[:-1, self.columns], self.on.rows.c[:-1, self.columns]
        return Program(
            self.weight,
            np.minimum(squared_speed_bound(self.on.slope, bounds.velocity), LARGEST),
            self.rows,
            np.maximum(room - c, LEAST_ROOM * room),
            np.maximum(room + c, LEAST_ROOM * room),
            np.tile(bounds.jerk[:, self.moving], 2),
            self.speed,
        )


def jerk_rows(on: DiscretisedPath, ramp: RampedPath) -> JerkRows:
    """Build the rows of a path over a clock.

    Args:
        on: The path on the grid of the clock.
        ramp: The path over the clock.
    """
    s, count = on.s, len(on.s) - 1
    station = stations(s)
    apart, width = np.diff(station), np.diff(s)
    part = (s - station[:-1]) / apart
    joints, limited = int(on.dq.shape[1]), int(on.rows.a.shape[1])
    moving: Ints = np.nonzero((on.dq != 0.0).any(axis=0))[0]
    columns: Ints = np.concatenate((moving, np.arange(joints, limited)))

    value = np.stack((1.0 - part, part), axis=1)  # of y at a grid point, by the stations beside it
    slope = np.stack((-1.0 / apart, 1.0 / apart), axis=1)  # of y' there
    speed, rate = _at_ends(value), _at_ends(slope)
    curvature = (rate[:, 1] - rate[:, 0]) / width[:, None]

    a, b = on.rows.a[:-1, columns, None], on.rows.b[:-1, columns, None]
    parts = [a * (rate[:, :1] / 2.0) + b * speed[:, :1]]
    for end, ddp in enumerate(ramp.third(s)):
        at_end = slice(end, count + end)
        p, dp = on.dq[at_end][:, moving, None], on.ddq[at_end][:, moving, None]
        bent = ddp[:, moving, None] * speed[:, None, end]
        parts.append(p * (curvature[:, None] / 2.0) + dp * (1.5 * rate[:, None, end]) + bent)

    weight = np.zeros(count + 2)
    share = speed.sum(axis=1) / 3.0 + (0.0, 1.0 / 3.0, 0.0)  # of each control value in the mean of y
    for place in range(3):
        weight[place : place + count] += width * share[:, place]
    return JerkRows(on, moving, columns, weight, np.concatenate(parts, axis=1), speed)


def _at_ends(factors: Floats) -> Floats:
    """Factors of two stations at grid points, (k, 2) -> of three at the ends of intervals, (k - 1, 2, 3)."""
    ends = np.zeros((len(factors) - 1, 2, 3))
    ends[:, 0, :2], ends[:, 1, 1:] = factors[:-1], factors[1:]
    return ends
