"""The fastest profile on a grid: one pass backward, one forward.

A profile (see `retiming.profile`) is given by control values y of x = (ds/dt)² at the `stations`:
start, middles of the grid intervals, goal. At the grid point between two stations its path acceleration is
u = (y_next - y_prev) / (2 distance), and its squared speed x lies between the two. So a limit
|a u + b x + c| <= limit holds at the grid point if it holds with either of them for x:

    coeff_next * y_next + coeff_prev * y_prev <= constraint_rhs.

(With the average itself for x, a large value could pay for a small neighbour, and profiles jitter.)

The backward pass finds, for each station, the largest y from which rest at the goal can still be
reached; the forward pass takes the largest y that stays below. Standing still must be allowed at
every grid point (`constraint_rhs` positive): then every y from 0 up to the largest is such a value, the
half-planes of a grid point hold the origin, and both passes always succeed.

Source: Pham and Pham, IEEE T-RO 34(3), 2018, algorithm 1 (TOPP-RA). Here the two linear programs of
each grid point are reduced beforehand, for all at once, to the least of some straight lines.
"""

from dataclasses import dataclass

import numpy as np

from tests.oracles.retiming.constraints import LEAST_ROOM, Rows
from tests.oracles.retiming.profile import stations
from trajopt.values.arrays import Floats

ROUNDS = 60
"""Most cuts of the search along a polygon; each cut drops one of its at most 4 m sides."""
STEEP = 1e-8
"""A factor that is this much smaller than the other one of its half-plane is taken for a rounding error of
zero, which quotients would magnify. This occurs where a path reverses."""
FAR = 1e200
"""Where lines lie that bound nothing: finite, so that differences of them are numbers."""


@dataclass(frozen=True, eq=False)
class Stages:
    """Half-planes at all grid points, shape (k, 4 m) each.

    Attributes:
        coeff_next: Factors of the control value after the grid point.
        coeff_prev: Factors of the control value before it.
    """

    coeff_next: Floats
    coeff_prev: Floats


def stages(s: Floats, rows: Rows) -> Stages:
    """Write the limits as half-planes.

    Args:
        s: Grid, increasing, shape (k,).
        rows: The limits at the grid points.
    """
    a = rows.a / (2.0 * np.diff(stations(s))[:, None])
    b = rows.b.copy()
    b[[0, -1]] = 0.0  # at rest
    coeff_next, coeff_prev = np.hstack((a, a + b)), np.hstack((b - a, -a))
    return Stages(np.hstack((coeff_next, -coeff_next)), np.hstack((coeff_prev, -coeff_prev)))


def constraint_rhs(rows: Rows, limit: Floats) -> Floats:
    """Right-hand sides of the half-planes: limits (k, m) -> (k, 4 m), never less than a trifle."""
    least = LEAST_ROOM * limit
    above, below = np.maximum(limit - rows.c, least), np.maximum(limit + rows.c, least)
    return np.hstack((above, above, below, below))


@dataclass(frozen=True, eq=False)
class _Lines:
    """Straight lines offset - slope * argument, shape (k, 4 m); unused ones are far away."""

    offset: Floats
    slope: Floats

    def highest(self, argument: Floats) -> tuple[Floats, Floats]:
        """Return the largest line at an argument per grid point (k,), and its slope."""
        return self._pick((self.offset - self.slope * argument[:, None]).argmax(axis=1), argument)

    def lowest(self, argument: Floats) -> tuple[Floats, Floats]:
        """Return the smallest line at an argument per grid point (k,), and its slope."""
        return self._pick((self.offset - self.slope * argument[:, None]).argmin(axis=1), argument)

    def _pick(self, index: np.ndarray, argument: Floats) -> tuple[Floats, Floats]:
        rows = np.arange(len(index))
        slope = self.slope[rows, index]
        return self.offset[rows, index] - slope * argument, -slope


def fastest(stages: Stages, rhs: Floats, bound: Floats) -> Floats:
    """Find the pointwise largest control values of a profile from rest to rest.

    Args:
        stages: Half-planes at the k grid points.
        rhs: Their right-hand sides, positive, shape (k, 4 m).
        bound: Bound at the stations, positive, shape (k + 1,).

    Returns:
        Control values of x = (ds/dt)² at the stations, shape (k + 1,); 0 at both ends.
    """
    above = _bounds(rhs, stages.coeff_prev, stages.coeff_next, upper=True)
    coeff_next = _bounds(rhs, stages.coeff_next, stages.coeff_prev, upper=True)
    summit = _summit(
        above, _bounds(rhs, stages.coeff_prev, stages.coeff_next, upper=False), _ahead(stages, rhs, bound)
    )
    controllable = _backward(above, summit, bound)
    count = len(bound)
    control = [0.0] * count
    offset, slope = list(coeff_next.offset), list(coeff_next.slope)
    for i in range(count - 1):
        reached = float((offset[i] - slope[i] * control[i]).min())
        control[i + 1] = max(0.0, min(reached, controllable[i + 1]))
    return np.array(control)


def _bounds(rhs: Floats, factor: Floats, other: Floats, *, upper: bool) -> _Lines:
    """Solve factor * y + other * argument <= rhs for y: upper or lower bounds of y."""
    least = STEEP * np.abs(other)
    used = factor > least if upper else factor < -least
    safe = np.where(used, factor, 1.0)
    return _Lines(np.where(used, rhs / safe, FAR if upper else -FAR), np.where(used, other / safe, 0.0))


def _ahead(stages: Stages, rhs: Floats, bound: Floats) -> Floats:
    """Bound of the value after each grid point, by the half-planes that bound it alone too."""
    alone = (np.abs(stages.coeff_prev) <= STEEP * stages.coeff_next) & (stages.coeff_next > 0.0)
    most = np.where(alone, rhs / np.where(alone, stages.coeff_next, 1.0), FAR)
    return np.minimum(bound[1:], most.min(axis=1))


def _backward(above: _Lines, summit: Floats, bound: Floats) -> list[float]:
    """Largest control value at each station from which rest at the goal can be reached."""
    most, peaks = [float(value) for value in bound], [float(value) for value in summit]
    offset, slope = list(above.offset), list(above.slope)
    ahead = most[-1] = 0.0
    for i in range(len(most) - 2, -1, -1):
        ahead = min(peaks[i], ahead)
        ahead = max(0.0, min(float((offset[i] - slope[i] * ahead).min()), most[i]))
        most[i] = ahead
    return most


def _summit(above: _Lines, below: _Lines, bound: Floats) -> Floats:
    """Per grid point, the value after it, at most `bound`, for which that before it can be largest."""
    end = bound.copy()
    for _ in range(ROUNDS):  # Newton from the right to where the upper and lower bounds meet
        high, high_slope = above.lowest(end)
        low, low_slope = below.highest(end)
        gap, closing = high - low, low_slope - high_slope
        outside = (gap < 0.0) & (closing > 0.0)
        if not outside.any():
            break
        step = np.where(outside, gap / np.where(outside, closing, 1.0), 0.0)
        outside &= -step > 1e-15 * end
        end = np.maximum(end + step, 0.0)
        if not outside.any():
            break
    return _highest_point(above, end)


def _highest_point(above: _Lines, end: Floats) -> Floats:
    """Per grid point, the argument in [0, end] where the least of the lines is largest."""
    begin = np.zeros_like(end)
    left, rise = above.lowest(begin)
    right, fall = above.lowest(end)
    rising, falling = rise > 0.0, fall < 0.0
    best = np.where(falling, begin, end)
    active = rising & falling
    for _ in range(ROUNDS):
        if not active.any():
            break
        # The lines that are lowest at both sides cross above the summit, at an argument between.
        slopes = np.where(active, rise - fall, 1.0)
        crossing = (right - left - fall * end + rise * begin) / slopes
        crossing = np.where(active, np.clip(crossing, begin, end), best)
        value, slope = above.lowest(crossing)
        met = value >= left + rise * (crossing - begin) - 1e-13 * np.abs(value)
        best = np.where(active, crossing, best)
        active = active & ~met & (slope != 0.0)
        up, down = active & (slope > 0.0), active & (slope < 0.0)
        begin, left, rise = (
            np.where(up, new, old) for new, old in ((crossing, begin), (value, left), (slope, rise))
        )
        end, right, fall = (
            np.where(down, new, old) for new, old in ((crossing, end), (value, right), (slope, fall))
        )
    return best
