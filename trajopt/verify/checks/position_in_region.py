"""The judge's check of `PositionInRegion`: a point inside a union of convex shapes.

The signed distance d from a convex shape is a convex function that changes by no more than the point
moves. Between two times the point is off the chord by at most the bulge b, so d is at most the larger
of its values at both, plus b. A union is proven by any one member in each interval.
"""

from collections.abc import Callable

import numpy as np

from trajopt.problem.requirements import Member, PositionInRegion
from trajopt.values.arrays import Floats
from trajopt.values.shapes.shapes import Box, Cylinder, Plane, Sphere
from trajopt.verify.checks.quantities import Quantity, quantities
from trajopt.verify.kernel.motion import Motion
from trajopt.verify.kernel.relative_motion import RelativeMotion


@quantities.register
def _(requirement: PositionInRegion, motion: Motion) -> tuple[Quantity, ...]:
    moving = RelativeMotion(
        motion, requirement.frame, reference=requirement.reference, offset=requirement.offset
    )
    members = tuple(_distance(member) for member in requirement.members)

    def depth(points: Floats) -> Floats:
        return np.min([member(points) for member in members], axis=0)

    def bound(begin: Floats, end: Floats, points: Floats) -> Floats:
        rates = moving.bounds(begin, end)
        bulge = rates.point_acceleration * (end - begin) ** 2 / 8.0
        proven = np.full(len(begin), np.inf)
        for member in members:
            first, middle, last = (member(points[row]) for row in range(3))
            chord = np.maximum(first, last) + bulge
            proven = np.minimum(proven, np.minimum(middle + rates.shift, chord))
        return proven

    return (
        Quantity(
            kind="region",
            name="signed distance from the region",
            subject=requirement.frame,
            unit="m",
            limit=0.0,
            states=lambda times: moving.placements(times)[1],
            number=depth,
            bound=bound,
        ),
    )


def _distance(member: Member) -> Callable[[Floats], Floats]:
    """Return the signed distance of points (c, 3) from a placed shape, negative inside [m]."""
    shape, where = member

    def of(points: Floats) -> Floats:
        x, y, z = ((points - where.translation) @ where.rotation).T
        match shape:
            case Sphere():
                return np.sqrt(x * x + y * y + z * z) - shape.radius
            case Plane():
                return z
            case Cylinder():
                return _corner(np.sqrt(x * x + y * y) - shape.radius, np.abs(z) - shape.length / 2)
            case Box():
                return _corner(np.abs(x) - shape.x / 2, np.abs(y) - shape.y / 2, np.abs(z) - shape.z / 2)

    return of


def _corner(*over: Floats) -> Floats:
    """Combine distances from faces at right angles, negative inside, to that from the solid."""
    inside = np.minimum(np.max(over, axis=0), 0.0)
    return np.sqrt(sum(np.maximum(one, 0.0) ** 2 for one in over)) + inside
