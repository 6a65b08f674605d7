"""The torque along a path, interpolated from few evaluations of the inverse dynamics.

Grids are many and fine, and the torque changes slowly: so it is evaluated once, at the ends and the
middle of panels of the path, and every grid reads it off the parabolas through them. No panel
reaches beyond a knot of the path, where the derivative of the curvature jumps. What the parabolas
miss is found when the trajectory is measured (`trajopt.retime.torque.torque_range`).
"""

from dataclasses import dataclass

import numpy as np

from trajopt.arrays import Floats
from trajopt.retime.ramp import RampedPath
from trajopt.retime.smooth import SmoothPath
from trajopt.retime.stages import Rows
from trajopt.retime.torque import TorqueLimits

REACH = 0.8
"""How far the joints move in one panel at most, all added up [rad | m]."""
MOST_PANELS = 500.0
"""Panels of very long paths are longer, so that there are about as many."""


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
