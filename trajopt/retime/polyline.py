"""The polyline that was checked, over the path parameter."""

from dataclasses import dataclass

import numpy as np

from trajopt.arrays import Floats

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
