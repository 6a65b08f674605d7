"""The judge's check of `PointOnArc`: the distance of a point from an arc.

The distance changes by no more than the point moves. Where the point is certainly abreast of the arc,
the distance is the length of (r - R, z); with speed v and acceleration u the second derivative of that
vector is at most u + v^2 / r, so it is off the chord by at most that times h^2 / 8.
"""

import numpy as np

from trajopt.problem.requirements import PointOnArc
from trajopt.values.arrays import Bools, Floats
from trajopt.verify.checks.quantities import Quantity, quantities
from trajopt.verify.kernel.motion import Motion
from trajopt.verify.kernel.relative_motion import RelativeMotion


@quantities.register
def _(requirement: PointOnArc, motion: Motion) -> tuple[Quantity, ...]:
    moving = RelativeMotion(
        motion, requirement.frame, reference=requirement.reference, offset=requirement.offset
    )
    centre = requirement.centre

    def bound(begin: Floats, end: Floats, points: Floats) -> Floats:
        rates = moving.bounds(begin, end)
        first, middle, last = (_distance(requirement, points[row]) for row in range(3))
        radius = np.hypot(points[1, :, 0], points[1, :, 1])
        least = np.maximum(radius - rates.shift, 1e-12)
        bend = rates.point_acceleration + rates.point_rate**2 / least
        chord = np.maximum(first, last) + bend * (end - begin) ** 2 / 8.0
        straight = _abreast(requirement, points[1], rates.shift)
        return np.minimum(middle + rates.shift, np.where(straight, chord, np.inf)) - requirement.tolerance

    return (
        Quantity(
            kind="arc",
            name="distance from the arc",
            subject=requirement.frame,
            unit="m",
            limit=requirement.tolerance,
            states=lambda times: (moving.placements(times)[1] - centre.translation) @ centre.rotation,
            number=lambda points: _distance(requirement, points),
            bound=bound,
        ),
    )


def _distance(arc: PointOnArc, points: Floats) -> Floats:
    """Distance of points (c, 3), seen from the circle, from the arc, shape (c,) [m]."""
    x, y, z = points.T
    ring = np.hypot(np.hypot(x, y) - arc.radius, z)
    ends = [
        np.sqrt((x - arc.radius * np.cos(angle)) ** 2 + (y - arc.radius * np.sin(angle)) ** 2 + z**2)
        for angle in (0.0, arc.sweep)
    ]
    within = np.arctan2(y, x) % (2.0 * np.pi) <= arc.sweep
    return np.where(within, ring, np.minimum(*ends))


def _abreast(arc: PointOnArc, points: Floats, shift: Floats) -> Bools:
    """Say which points (c, 3) stay between the ends of the arc while they move by up to a shift (c,)."""
    radius = np.hypot(points[:, 0], points[:, 1])
    clear = shift < 0.5 * radius
    turn = np.arcsin(np.where(clear, shift / np.maximum(radius, 1e-12), 0.0))
    angle = np.arctan2(points[:, 1], points[:, 0]) % (2.0 * np.pi)
    whole = arc.sweep >= 2.0 * np.pi
    return np.asarray(clear & (whole | ((angle > turn) & (angle + turn < arc.sweep))), dtype=np.bool_)
