"""The judge's check of `DistanceBetween`: the distance of two points of frames.

With p one point as seen from the other, of speed v and acceleration u, |p| is convex, so between two
times it exceeds neither end by more than u h^2 / 8; and its second derivative is at most u + v^2 / |p|,
so it falls below the lower end by no more than that times h^2 / 8.
"""

from functools import partial

import numpy as np

from trajopt.problem.requirements import DistanceBetween
from trajopt.values.arrays import Floats
from trajopt.verify.checks.quantities import Quantity, quantities
from trajopt.verify.kernel.motion import Motion
from trajopt.verify.kernel.relative_motion import RelativeMotion


@quantities.register
def _(requirement: DistanceBetween, motion: Motion) -> tuple[Quantity, ...]:
    moving = RelativeMotion(
        motion, requirement.first, reference=requirement.second, offset=requirement.first_offset
    )
    return range_quantities(
        moving,
        requirement.second_offset,
        subject=f"{requirement.first} - {requirement.second}",
        lower=requirement.lower,
        upper=requirement.upper,
    )


def range_quantities(
    moving: RelativeMotion, origin: Floats, *, subject: str, lower: float, upper: float
) -> tuple[Quantity, ...]:
    """Return the distance of a moving point as one number for each of its bounds that is finite.

    Args:
        moving: The point, seen from a reference.
        origin: The point of the reference that it is measured from, shape (3,) [m].
        subject: For the certificate.
        lower: Smallest distance; 0 for none [m].
        upper: Largest distance; inf for none [m].
    """
    sides = [(upper, False)] if np.isfinite(upper) else []
    sides += [(lower, True)] if lower > 0.0 else []
    return tuple(
        Quantity(
            kind="distance",
            name="distance",
            subject=subject,
            unit="m",
            limit=limit,
            states=lambda times: moving.placements(times)[1] - origin,
            number=lambda points: np.linalg.norm(points, axis=-1),
            bound=partial(_least if least else _most, moving, limit),
            least=least,
        )
        for limit, least in sides
    )


def _most(moving: RelativeMotion, limit: float, begin: Floats, end: Floats, points: Floats) -> Floats:
    rates = moving.bounds(begin, end)
    first, middle, last = np.linalg.norm(points, axis=2)
    chord = np.maximum(first, last) + rates.point_acceleration * (end - begin) ** 2 / 8.0
    return np.minimum(middle + rates.shift, chord) - limit


def _least(moving: RelativeMotion, limit: float, begin: Floats, end: Floats, points: Floats) -> Floats:
    rates = moving.bounds(begin, end)
    first, middle, last = np.linalg.norm(points, axis=2)
    near = middle - rates.shift
    bend = rates.point_acceleration + rates.point_rate**2 / np.maximum(near, 1e-12)
    chord = np.minimum(first, last) - bend * (end - begin) ** 2 / 8.0
    return limit - np.maximum(near, np.where(near > 0.0, chord, -np.inf))
