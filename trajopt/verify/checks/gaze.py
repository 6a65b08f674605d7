"""The judge's check of `Gaze`: a target within a cone about a camera's axis, and within a range.

While the target moves by s as seen from the camera, at distance r, its direction turns by at most
asin(s / r). A cone of half angle up to a right angle is convex: between two times at which the target is
within an angle, the chord is too, and the target is off the chord by at most the bulge.
"""

import numpy as np

from trajopt.problem.requirements import Gaze
from trajopt.values.arrays import Floats
from trajopt.verify.checks.distance_between import range_quantities
from trajopt.verify.checks.quantities import Quantity, quantities
from trajopt.verify.kernel.motion import Motion
from trajopt.verify.kernel.relative_motion import RelativeMotion


@quantities.register
def _(requirement: Gaze, motion: Motion) -> tuple[Quantity, ...]:
    moving = RelativeMotion(
        motion, requirement.reference, reference=requirement.frame, offset=requirement.target
    )

    def bound(begin: Floats, end: Floats, points: Floats) -> Floats:
        rates = moving.bounds(begin, end)
        first, middle, last = (_angles(points[row], requirement.axis) for row in range(3))
        distance = np.linalg.norm(points[1], axis=1)
        bulge = rates.point_acceleration * (end - begin) ** 2 / 8.0
        ends = np.maximum(first, last)
        chord = np.where(ends <= np.pi / 2, ends + _turn(bulge, distance - rates.shift - bulge), np.inf)
        return np.minimum(middle + _turn(rates.shift, distance), chord) - requirement.angle

    angle = Quantity(
        kind="gaze",
        name="angle off the view axis",
        subject=requirement.frame,
        unit="rad",
        limit=requirement.angle,
        states=lambda times: moving.placements(times)[1] - requirement.origin,
        number=lambda points: _angles(points, requirement.axis),
        bound=bound,
    )
    within = range_quantities(
        moving,
        requirement.origin,
        subject=requirement.frame,
        lower=requirement.nearest,
        upper=requirement.farthest,
    )
    return (angle, *within)


def _angles(points: Floats, axis: Floats) -> Floats:
    """Angles between points (c, 3) and an axis (3,) of length one, accurate near 0 and pi [rad]."""
    return np.arctan2(np.linalg.norm(np.cross(points, axis), axis=1), points @ axis)


def _turn(shift: Floats, distance: Floats) -> Floats:
    """Largest turn of the direction to what moves by a shift, seen from a distance, each (c,) [rad]."""
    clear = shift < distance
    return np.where(clear, np.arcsin(np.where(clear, shift / np.where(clear, distance, 1.0), 0.0)), np.pi)
