"""Smoothing a polyline: exact in its knots, except at corners too sharp for the tolerance.

The control points lie on the polyline (Schoenberg's spline, which reproduces straight lines and
never oscillates), and are moved so that the spline passes through every knot. Where it then leaves
the polyline by more than the tolerance, the knot is replaced by a rounded corner: its control
points stay on the polyline, and two spline knots beside it set where the rounding begins.
"""

from dataclasses import dataclass

import numpy as np

from tests.oracles.retiming.smooth_path import SmoothPath, design, greville
from trajopt.timing import DeviationBound
from trajopt.values.arrays import Bools, Floats, Ints
from trajopt.values.errors import ShapeError

SAMPLES = 8
"""Even number of samples per piece of the spline at which its distance from the polyline is measured."""
BETWEEN = 0.98
"""Part of the tolerance that samples may use: arcs between them are higher by the rest at most."""
DOMINATED = 0.5
"""Samples whose neighbours both stay below this part of the largest are not measured: they do not exceed the
largest, for a piece leaves the polyline by a cubic (Lagrange's weights of four even samples tell)."""
NEGLIGIBLE = 1e-9
"""Joint differences up to this are not worth a call of the bound [rad | m]."""
SHRINK = 0.1
"""Smallest factor by which a rounding shrinks in one step."""
MERGED = 1e-9
"""Knots nearer to the one before than this part of the whole length are left out."""


@dataclass(frozen=True, eq=False)
class Polyline:
    """Straight segments between corners, none of them of zero length.

    The parameter s grows on each segment by the Euclidean norm over the joints of |dq| / v, v the
    velocity limit: it is about the time [s] that the segment takes at full speed, and makes radians
    and metres comparable.

    Attributes:
        origin: Position at s = 0, shape (n,) [rad | m].
        goal: Position at the end, shape (n,) [rad | m].
        parameters: Parameter of each corner (start and goal included), from 0, shape (m,) [s].
        corners: Positions relative to the origin, shape (m, n) [rad | m].
    """

    origin: Floats
    goal: Floats
    parameters: Floats
    corners: Floats

    @property
    def length(self) -> float:
        """The parameter at the goal [s]; 0 when nothing moves."""
        return float(self.parameters[-1])

    def __call__(self, s: Floats) -> Floats:
        """Positions relative to the origin, shape (m,) -> (m, n) [rad | m]."""
        inner = self.parameters[1:-1]
        segment = np.searchsorted(inner, s, side="right")
        begin, end = self.parameters[segment], self.parameters[segment + 1]
        part = ((s - begin) / (end - begin))[:, None]
        return self.corners[segment] * (1.0 - part) + self.corners[segment + 1] * part


def polyline(knots: Floats, velocity: Floats) -> Polyline:
    """Leave out repeated knots and lay the parameter along the rest.

    Args:
        knots: Shape (N, n) [rad | m].
        velocity: Velocity limits, shape (n,) [rad/s | m/s]; a joint whose limit is zero or
            infinite counts with 1.
    """
    usable = np.isfinite(velocity) & (velocity > 0.0)
    scale = np.where(usable, velocity, 1.0)
    relative = knots - knots[0]
    steps = np.linalg.norm(np.diff(relative, axis=0) / scale, axis=1)
    least = MERGED * float(steps.sum())
    corners = relative
    if not (steps > least).all():
        corners = relative[_distinct(relative / scale, least)]
        steps = np.linalg.norm(np.diff(corners, axis=0) / scale, axis=1)
    return Polyline(knots[0], knots[-1], np.concatenate(((0.0,), np.cumsum(steps))), corners)


def _distinct(places: Floats, least: float) -> list[int]:
    """Choose knots that are apart from the chosen one before, the first and the last among them."""
    kept = [0]
    for index in range(1, len(places)):
        if float(np.linalg.norm(places[index] - places[kept[-1]])) > least:
            kept.append(index)
    if kept[-1] != len(places) - 1 and len(kept) > 1:
        kept[-1] = len(places) - 1
    return kept


@dataclass(frozen=True, eq=False)
class Smoothing:
    """A smooth path and how far it leaves the polyline.

    Attributes:
        path: The smooth path.
        deviation: Largest deviation at the samples, by the measure of the bound.
    """

    path: SmoothPath
    deviation: float


def smooth(
    line: Polyline,
    *,
    lower: Floats,
    upper: Floats,
    deviation: DeviationBound | None,
    tolerance: float,
) -> Smoothing:
    """Find a smooth path within the tolerance of a polyline of positive length.

    Each step either rounds one more corner or shrinks a rounding, and the deviation at a rounded
    corner is proportional to its size: so this ends. Control points are held within the position
    limits, hence so is the whole path.

    Args:
        line: The polyline.
        lower: Lower position limits, shape (n,) [rad | m].
        upper: Upper position limits, shape (n,) [rad | m].
        deviation: How far bodies move between two positions; None for the joint difference.
        tolerance: Largest deviation, in the unit of the bound.

    Raises:
        ShapeError: If the bound returns a number that is not finite.
    """
    box = (
        np.minimum(lower - line.origin, line.corners.min(axis=0)),
        np.maximum(upper - line.origin, line.corners.max(axis=0)),
    )
    count, lengths = len(line.corners), np.diff(line.parameters)
    rounded = np.zeros(count, dtype=np.bool_)
    reach = np.full(count, np.inf)
    reach[1:-1] = np.minimum(lengths[:-1], lengths[1:]) / 2.0
    while True:
        knots, through = _spline_knots(line, rounded, reach)
        path = SmoothPath(line.origin, line.goal, knots, np.clip(_control(line, knots, through), *box))
        s = (knots[:-1, None] + np.diff(knots)[:, None] * np.arange(SAMPLES) / SAMPLES).ravel()
        far = _measure(path(s), line.origin + line(s), deviation)
        worst = float(far.max())
        if worst <= BETWEEN * tolerance or count == 2:
            return Smoothing(path, worst)
        _round_corners(line.parameters, s, far / (BETWEEN * tolerance), rounded, reach)


def _measure(on_path: Floats, on_line: Floats, deviation: DeviationBound | None) -> Floats:
    """Measure the distance of samples; every other one only where it can be the largest.

    Args:
        on_path: Samples of the smooth path, shape (S, n), S even.
        on_line: The same of the polyline.
        deviation: Measures it; the largest joint difference if None.

    Returns:
        Shape (S,); where not measured, the larger of the neighbours.
    """
    apart = np.abs(on_path - on_line).max(axis=1)
    if deviation is None:
        return apart
    far, asked = np.zeros(len(apart)), apart > NEGLIGIBLE
    first = np.arange(len(apart)) % 2 == 0
    _ask(deviation, on_path, on_line, asked & first, far)
    after = np.append(far[2::2], 0.0)
    far[1::2] = np.where(asked[1::2], np.maximum(far[::2], after), 0.0)
    _ask(deviation, on_path, on_line, asked & ~first & (far >= DOMINATED * far.max()), far)
    return far


def _ask(deviation: DeviationBound, on_path: Floats, on_line: Floats, asked: Bools, far: Floats) -> None:
    """Measure some samples, in place."""
    if asked.any():
        far[asked] = deviation(on_path[asked], on_line[asked])
        if not np.isfinite(far).all():
            raise ShapeError("deviation", "returned a number that is not finite")


def _spline_knots(line: Polyline, rounded: Bools, reach: Floats) -> tuple[Floats, Ints]:
    """Knots of the spline, and the places among them of polyline knots to pass through."""
    knots: list[float] = [0.0]
    through: list[int] = []
    for index in range(1, len(rounded)):
        begin, end = float(line.parameters[index - 1]), float(line.parameters[index])
        leave = begin + float(reach[index - 1]) if rounded[index - 1] else None
        enter = end - float(reach[index]) if rounded[index] else None
        if leave is not None and enter is not None and enter - leave < 1e-3 * (end - begin):
            knots.append((leave + enter) / 2.0)
        else:
            knots.extend(place for place in (leave, enter) if place is not None)
        if not rounded[index] and index < len(rounded) - 1:
            through.append(len(knots))
        knots.append(end)
    return np.array(knots), np.array(through, dtype=np.int64)


def _control(line: Polyline, knots: Floats, through: Ints) -> Floats:
    """Control points on the polyline, moved where the spline must pass through a knot."""
    control = line(greville(knots))
    if len(through):
        weights = design(knots, knots[through])
        moved = through + 1  # the control point with the most weight at that knot
        control[moved] += np.linalg.solve(weights[:, moved], line(knots[through]) - weights @ control)
    return control


def _round_corners(corners: Floats, s: Floats, ratio: Floats, rounded: Bools, reach: Floats) -> None:
    """Round the corners beside which the deviation is too large, or shrink their rounding.

    Too large a deviation rounds the nearer corner of its segment, or else the other one; only
    when both are rounded (or an end) does the nearer rounding shrink.

    Args:
        corners: Parameters of the polyline's corners, shape (m,).
        s: Parameters of the samples.
        ratio: Deviation over tolerance at the samples.
        rounded: Which corners are rounded; changed in place.
        reach: Size of each rounding in the parameter; changed in place.
    """
    last = len(corners) - 1
    right = np.clip(np.searchsorted(corners, s, side="right"), 1, last)
    left = right - 1
    near_left = s - corners[left] <= corners[right] - s
    near = np.where((near_left & (left > 0)) | (right == last), left, right)
    other = left + right - near
    sharp = ~rounded
    sharp[[0, last]] = False
    blamed = np.where(sharp[other] & ~sharp[near], other, near)
    worst = np.zeros(last + 1)
    np.maximum.at(worst, blamed, ratio)
    shrunk = rounded & (worst > 1.0)
    reach[shrunk] *= np.maximum(SHRINK, 0.95 / worst[shrunk])
    rounded |= sharp & (worst > 1.0)
