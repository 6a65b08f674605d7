"""Writes the limits of a path over a clock as a `Program`."""

from dataclasses import dataclass

import numpy as np

from trajopt.arrays import Floats, Ints
from trajopt.retime.course import Bounds, Course
from trajopt.retime.program import Program
from trajopt.retime.ramp import RampedPath
from trajopt.retime.stages import LEAST_ROOM, squared_speed_bound, stations

LARGEST = 1e4
"""Bound of the squared clock speed where nothing else bounds it [-]."""


@dataclass(frozen=True, eq=False)
class JerkRows:
    """What of a program does not depend on the limits.

    Attributes:
        course: The path on the grid of the clock.
        moving: Places of the joints that move.
        columns: Places of their accelerations and of the torques among the rows of the course.
        weight: As in `Program`.
        rows: As in `Program`.
        speed: As in `Program`.
    """

    course: Course
    moving: Ints
    columns: Ints
    weight: Floats
    rows: Floats
    speed: Floats

    def within(self, bounds: Bounds) -> Program:
        """Set the limits; those of the jerk must be given, infinite where there is none."""
        assert bounds.jerk is not None
        room, c = bounds.rows[:-1, self.columns], self.course.rows.c[:-1, self.columns]
        return Program(
            self.weight,
            np.minimum(squared_speed_bound(self.course.slope, bounds.velocity), LARGEST),
            self.rows,
            np.maximum(room - c, LEAST_ROOM * room),
            np.maximum(room + c, LEAST_ROOM * room),
            np.tile(bounds.jerk[:, self.moving], 2),
            self.speed,
        )


def jerk_rows(course: Course, ramp: RampedPath) -> JerkRows:
    """Write the rows of a path over a clock.

    Args:
        course: The path on the grid of the clock.
        ramp: The path over the clock.
    """
    s, count = course.s, len(course.s) - 1
    station = stations(s)
    apart, width = np.diff(station), np.diff(s)
    part = (s - station[:-1]) / apart
    joints, limited = int(course.dq.shape[1]), int(course.rows.a.shape[1])
    moving: Ints = np.nonzero((course.dq != 0.0).any(axis=0))[0]
    columns: Ints = np.concatenate((moving, np.arange(joints, limited)))

    value = np.stack((1.0 - part, part), axis=1)  # of y at a grid point, by the stations beside it
    slope = np.stack((-1.0 / apart, 1.0 / apart), axis=1)  # of y' there
    speed, rate = _at_ends(value), _at_ends(slope)
    curvature = (rate[:, 1] - rate[:, 0]) / width[:, None]

    a, b = course.rows.a[:-1, columns, None], course.rows.b[:-1, columns, None]
    parts = [a * (rate[:, :1] / 2.0) + b * speed[:, :1]]
    for end, ddp in enumerate(ramp.third(s)):
        at_end = slice(end, count + end)
        p, dp = course.dq[at_end][:, moving, None], course.ddq[at_end][:, moving, None]
        bent = ddp[:, moving, None] * speed[:, None, end]
        parts.append(p * (curvature[:, None] / 2.0) + dp * (1.5 * rate[:, None, end]) + bent)

    weight = np.zeros(count + 2)
    share = speed.sum(axis=1) / 3.0 + (0.0, 1.0 / 3.0, 0.0)  # of each control value in the mean of y
    for place in range(3):
        weight[place : place + count] += width * share[:, place]
    return JerkRows(course, moving, columns, weight, np.concatenate(parts, axis=1), speed)


def _at_ends(factors: Floats) -> Floats:
    """Factors of two stations at grid points, (k, 2) -> of three at the ends of intervals, (k - 1, 2, 3)."""
    ends = np.zeros((len(factors) - 1, 2, 3))
    ends[:, 0, :2], ends[:, 1, 1:] = factors[:-1], factors[1:]
    return ends
