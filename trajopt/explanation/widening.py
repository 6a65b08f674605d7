"""How a requirement is widened: each number that bounds it, and the requirement with that number changed."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import singledispatch

import numpy as np

from trajopt.arrays import readonly
from trajopt.model.placement import Placement, placement
from trajopt.model.requirements import (
    AxisAlignment,
    CoupledJoints,
    DistanceBetween,
    FollowsCurve,
    FramePlacement,
    Gaze,
    GravityTorque,
    JointPositions,
    LineOfSight,
    PointOnArc,
    PositionInRegion,
    Requirement,
    SingularityDistance,
)
from trajopt.model.shapes import Box, Cylinder, Sphere

DEGREE = np.pi / 180.0
MILLIMETRE = 1e-3


@dataclass(frozen=True, eq=False)
class Widening:
    """One number of a requirement that can be widened.

    Attributes:
        what: What it bounds.
        now: What it is.
        sign: 1 where it grows, -1 where it shrinks.
        largest: By how much it can be widened at most.
        shown: Factor and unit in which it is shown: value / factor in unit.
        apply: Returns the requirement widened by an amount.
    """

    what: str
    now: float
    sign: float
    largest: float
    shown: tuple[float, str]
    apply: Callable[[float], Requirement]

    def words(self, amount: float) -> str:
        """Say the change by an amount."""
        factor, unit = self.shown
        after = (self.now + self.sign * amount) / factor
        return f"{self.what} {self.now / factor:.3g} to {after:.3g} {unit}".rstrip()


@singledispatch
def widenings(required: Requirement) -> tuple[Widening, ...]:
    """Return the numbers of a requirement that can be widened; none for one that knows of none."""
    del required
    return ()


@widenings.register
def _(required: AxisAlignment) -> tuple[Widening, ...]:
    now = required.tolerance
    return (
        Widening(
            f"tilt of {required.frame}",
            now,
            1.0,
            np.pi - now - 1e-3,
            (DEGREE, "deg"),
            lambda amount: replace(required, tolerance=now + amount),
        ),
    )


@widenings.register
def _(required: FramePlacement) -> tuple[Widening, ...]:
    position, rotation = required.position_tolerance, required.rotation_tolerance
    found: list[Widening] = []
    if np.isfinite(position).any():
        found.append(
            Widening(
                f"position tolerance of {required.frame}",
                float(position.min()),
                1.0,
                1.0,
                (MILLIMETRE, "mm"),
                lambda amount: replace(required, position_tolerance=readonly(position + amount)),
            )
        )
    if np.isfinite(rotation).any():
        found.append(
            Widening(
                f"rotation tolerance of {required.frame}",
                float(rotation.min()),
                1.0,
                np.pi,
                (DEGREE, "deg"),
                lambda amount: replace(required, rotation_tolerance=readonly(rotation + amount)),
            )
        )
    return tuple(found)


@widenings.register
def _(required: FollowsCurve) -> tuple[Widening, ...]:
    now = required.position_tolerance
    return (
        Widening(
            f"distance of {required.frame} from its curve",
            now,
            1.0,
            1.0,
            (MILLIMETRE, "mm"),
            lambda amount: replace(required, position_tolerance=now + amount),
        ),
    )


@widenings.register
def _(required: JointPositions) -> tuple[Widening, ...]:
    def apply(amount: float) -> Requirement:
        below, above = (
            {joint: value + amount for joint, value in side.items()}
            for side in (required.below, required.above)
        )
        return replace(required, below=below, above=above)

    now = min((*required.below.values(), *required.above.values()))
    what = f"tolerance of {', '.join(required.positions)}"
    return (Widening(what, now, 1.0, 2.0 * np.pi, (1.0, "rad"), apply),)


@widenings.register
def _(required: PositionInRegion) -> tuple[Widening, ...]:
    def grown(member: tuple[object, Placement], amount: float) -> tuple[object, Placement]:
        shape, where = member
        match shape:
            case Box():
                return Box(*(edge + 2.0 * amount for edge in (shape.x, shape.y, shape.z))), where
            case Sphere():
                return Sphere(shape.radius + amount), where
            case Cylinder():
                return Cylinder(shape.radius + amount, shape.length + 2.0 * amount), where
            case _:
                return shape, where * placement((0.0, 0.0, amount))

    def apply(amount: float) -> Requirement:
        members = tuple(grown(member, amount) for member in required.members)
        return replace(required, members=members)

    what = f"region of {required.frame} grown on every side"
    return (Widening(what, 0.0, 1.0, 1.0, (MILLIMETRE, "mm"), apply),)


@widenings.register
def _(required: PointOnArc) -> tuple[Widening, ...]:
    now = required.tolerance
    return (
        Widening(
            f"distance of {required.frame} from the arc",
            now,
            1.0,
            0.99 * required.radius - now,
            (MILLIMETRE, "mm"),
            lambda amount: replace(required, tolerance=now + amount),
        ),
    )


@widenings.register
def _(required: DistanceBetween) -> tuple[Widening, ...]:
    what, found = f"distance of {required.first} from {required.second}", list[Widening]()
    if required.lower > 0.0:
        found.append(
            Widening(
                f"smallest {what}",
                required.lower,
                -1.0,
                required.lower,
                (MILLIMETRE, "mm"),
                lambda amount: replace(required, lower=max(required.lower - amount, 0.0)),
            )
        )
    if np.isfinite(required.upper):
        found.append(
            Widening(
                f"largest {what}",
                required.upper,
                1.0,
                2.0,
                (MILLIMETRE, "mm"),
                lambda amount: replace(required, upper=required.upper + amount),
            )
        )
    return tuple(found)


@widenings.register
def _(required: Gaze) -> tuple[Widening, ...]:
    return (
        Widening(
            f"view angle of {required.frame}",
            required.angle,
            1.0,
            np.pi - required.angle - 1e-3,
            (DEGREE, "deg"),
            lambda amount: replace(required, angle=required.angle + amount),
        ),
    )


@widenings.register
def _(required: CoupledJoints) -> tuple[Widening, ...]:
    now = required.tolerance
    return (
        Widening(
            f"tolerance of {' and '.join(required.weights)}",
            now,
            1.0,
            2.0 * np.pi,
            (1.0, "rad"),
            lambda amount: replace(required, tolerance=now + amount),
        ),
    )


@widenings.register
def _(required: SingularityDistance) -> tuple[Widening, ...]:
    now = required.smallest
    return (
        Widening(
            f"smallest singular value of {required.frame}",
            now,
            -1.0,
            0.99 * now,
            (1.0, ""),
            lambda amount: replace(required, smallest=now - amount),
        ),
    )


@widenings.register
def _(required: LineOfSight) -> tuple[Widening, ...]:
    now = required.margin
    return (
        Widening(
            f"margin of the line of sight of {required.frame}",
            now,
            -1.0,
            0.99 * now,
            (MILLIMETRE, "mm"),
            lambda amount: replace(required, margin=now - amount),
        ),
    )


@widenings.register
def _(required: GravityTorque) -> tuple[Widening, ...]:
    now = required.share
    return (
        Widening(
            "share of the effort limits that gravity may take",
            now,
            1.0,
            1.0 - now,
            (0.01, "%"),
            lambda amount: replace(required, share=min(now + amount, 1.0)),
        ),
    )
