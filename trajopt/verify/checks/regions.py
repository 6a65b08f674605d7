"""Checks of points in regions and on arcs."""

from collections.abc import Callable

import numpy as np

from trajopt.problem.requirements import Member, PointOnArc, PositionInRegion
from trajopt.values.arrays import Bools, Floats
from trajopt.values.shapes.shapes import Box, Cylinder, Plane, Sphere
from trajopt.verify.checks.quantities import Quantity, quantities
from trajopt.verify.kernel.motion import JudgedMotion
from trajopt.verify.kernel.relative_motion import RelativeMotion


@quantities.register
def _(requirement: PositionInRegion, motion: JudgedMotion) -> tuple[Quantity, ...]:
    """A point inside a union of convex shapes.

    The signed distance d from a convex shape is convex and changes by no more than the point moves. Between
    two times the point is off the chord by at most the bulge b, so d is at most the larger of its values at
    both, plus b. A union is proven by any one member in each interval.
    """
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
    """Combine distances from perpendicular faces, negative inside, to the distance from the solid."""
    inside = np.minimum(np.max(over, axis=0), 0.0)
    return np.sqrt(sum(np.maximum(one, 0.0) ** 2 for one in over)) + inside


@quantities.register
def _(requirement: PointOnArc, motion: JudgedMotion) -> tuple[Quantity, ...]:
    """Return the distance of a point from an arc.

    The distance changes by no more than the point moves. While the point is certainly abreast of the arc,
    the distance is the length of (r - R, z); with speed v and acceleration u the second derivative of that
    vector is at most u + v^2 / r, so it is off the chord by at most that times h^2 / 8.
    """
    moving = RelativeMotion(
        motion, requirement.frame, reference=requirement.reference, offset=requirement.offset
    )
    centre = requirement.centre

    def bound(begin: Floats, end: Floats, points: Floats) -> Floats:
        rates = moving.bounds(begin, end)
        first, middle, last = (_from_arc(requirement, points[row]) for row in range(3))
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
            number=lambda points: _from_arc(requirement, points),
            bound=bound,
        ),
    )


def _from_arc(arc: PointOnArc, points: Floats) -> Floats:
    x, y, z = points.T
    ring = np.hypot(np.hypot(x, y) - arc.radius, z)
    ends = [
        np.sqrt((x - arc.radius * np.cos(angle)) ** 2 + (y - arc.radius * np.sin(angle)) ** 2 + z**2)
        for angle in (0.0, arc.sweep)
    ]
    within = np.arctan2(y, x) % (2.0 * np.pi) <= arc.sweep
    return np.where(within, ring, np.minimum(*ends))


def _abreast(arc: PointOnArc, points: Floats, shift: Floats) -> Bools:
    """Whether points (c, 3) stay between the ends of the arc while they move by up to a shift (c,)."""
    radius = np.hypot(points[:, 0], points[:, 1])
    clear = shift < 0.5 * radius
    turn = np.arcsin(np.where(clear, shift / np.maximum(radius, 1e-12), 0.0))
    angle = np.arctan2(points[:, 1], points[:, 0]) % (2.0 * np.pi)
    whole = arc.sweep >= 2.0 * np.pi
    return np.asarray(clear & (whole | ((angle > turn) & (angle + turn < arc.sweep))), dtype=np.bool_)
