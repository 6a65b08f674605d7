"""Positions of frames: distance from a point, and coordinates in a region or about an arc."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from trajopt.optimise.terms.frames import lengths, relative_frame
from trajopt.optimise.terms.requirement import INSET, constrain
from trajopt.problem.motion import Motion
from trajopt.problem.requirements import DistanceBetween, PointOnArc, PositionInRegion, Region
from trajopt.problem.residual import Constraint, Window, constraint
from trajopt.scene.reduced import ReducedModel
from trajopt.values.arrays import Floats, Ints, Rows
from trajopt.values.placement import from_rpy
from trajopt.values.shapes.shapes import Box, Cylinder, Plane, Sphere

if TYPE_CHECKING:
    import casadi as ca

    from trajopt.optimise.terms.symbolic import SymbolicKinematics

RESERVED_DISTANCE = 0.1
"""The reserve is at most this share of the range between the bounds [m]."""


@dataclass(frozen=True, eq=False)
class PointDistance:
    """Four components [m]: the first point as seen from the second along its frame's axes, and the distance.

    If the points coincide the distance is taken to grow along the frame's x axis.
    """

    reduced: ReducedModel
    required: DistanceBetween

    units = ("m",)

    @property
    def name(self) -> str:
        return f"distance of {self.required.first} from {self.required.second}"

    def linearise(self, motion: Motion) -> Rows:
        need = self.required
        seen = relative_frame(self.reduced, motion, need.first, need.second, need.first_offset)
        apart = seen.point - need.second_offset
        distance, rate = lengths(apart, seen.point_jacobian, aside=0)
        return motion.rows_of_all(
            np.hstack((apart, distance[:, None])),
            np.concatenate((seen.point_jacobian, rate[:, None]), axis=1),
        )

    def expression(self, kinematics: "SymbolicKinematics") -> "ca.SX":
        import casadi as ca

        from trajopt.optimise.terms.symbolic import length

        need = self.required
        apart = kinematics.point(need.first, need.first_offset, need.second) - ca.SX(need.second_offset)
        return ca.vertcat(apart, length(apart))


@constrain.register
def _(
    required: DistanceBetween, reduced: ReducedModel, window: Window, inset: float = INSET
) -> tuple[Constraint, ...]:
    kept = inset * 0.5 * min(required.upper - required.lower, RESERVED_DISTANCE)
    # Without a lower bound an inset one would forbid that the points meet.
    lower = required.lower + kept if required.lower > 0.0 else -np.inf
    upper = required.upper - kept
    return (
        constraint(
            PointDistance(reduced, required),
            lower=(-upper, -upper, -upper, lower),
            upper=(upper, upper, upper, upper),
            tolerance=max(0.5 * kept, 1e-9),
            window=window,
        ),
    )


ROWS = 4
"""Components kept for each member of a union."""
INSIDE = -1.0
"""The coordinates in a member of a union that is not the nearest: within every bound [m]."""
RESERVED_SIZE = 0.05
"""The reserve is a share of the region's size, of this much at most [m]."""


@dataclass(frozen=True, eq=False)
class RegionCoordinates:
    """Coordinates of the point in the nearest member that bound the member [m].

    Flat faces give linear rows. Round ones give the distance from the centre or axis, and the coordinates
    across, whose slopes do not turn with the point, so that long steps still end in a narrow tube.

    Components 4 m ... 4 m + 3 are of member m: x, y, z of a box; x, y, z and the distance from the
    centre of a sphere; x, y, the distance from the axis and z of a cylinder; z of a half-space. Only
    the nearest member (by signed distance) has rows at a sample.
    """

    reduced: ReducedModel
    required: PositionInRegion

    units = ("m",)

    @property
    def name(self) -> str:
        return f"region of {self.required.frame}"

    def linearise(self, motion: Motion) -> Rows:
        need = self.required
        seen = relative_frame(self.reduced, motion, need.frame, need.reference, need.offset)
        local = [(seen.point - where.translation) @ where.rotation for _, where in need.members]
        outside = [_outside(shape, at) for (shape, _), at in zip(need.members, local, strict=True)]
        nearest = np.argmin(outside, axis=0)
        blocks: list[tuple[Ints, Floats, Floats, Ints]] = []
        for place, (shape, where) in enumerate(need.members):
            mine = np.flatnonzero(nearest == place)
            rate = where.rotation.T @ seen.point_jacobian[mine]
            values, rates = _coordinates(shape, local[place][mine], rate)
            count = values.shape[1]
            component = np.tile(ROWS * place + np.arange(count, dtype=np.int64), len(mine))
            slopes = rates.reshape(-1, rates.shape[-1])
            blocks.append((np.repeat(mine, count), values.ravel(), slopes, component))
        sample, value, jacobian, component = zip(*blocks, strict=True)
        return motion.rows(
            np.concatenate(sample), np.concatenate(value), np.concatenate(jacobian), np.concatenate(component)
        )

    def expression(self, kinematics: "SymbolicKinematics") -> "ca.SX":
        import casadi as ca

        need = self.required
        seen = kinematics.point(need.frame, need.offset, need.reference)
        local = [ca.SX(where.rotation.T) @ (seen - ca.SX(where.translation)) for _, where in need.members]
        columns = [
            _symbolic_coordinates(shape, at) for (shape, _), at in zip(need.members, local, strict=True)
        ]
        if len(columns) == 1:
            return columns[0]
        outside = [_symbolic_outside(shape, at) for (shape, _), at in zip(need.members, local, strict=True)]
        found: list[ca.SX] = []
        for mine, ((shape, _), column) in enumerate(zip(need.members, columns, strict=True)):
            nearest = ca.SX(1.0)
            for other, away in enumerate(outside):
                if other != mine:
                    # Of members equally near the first one counts.
                    nearest = nearest * (outside[mine] < away if other < mine else outside[mine] <= away)
            rest = INSIDE if isinstance(shape, Plane) else 0.0
            found.append(ca.if_else(nearest, column, rest))
        return ca.vertcat(*found)


def _coordinates(shape: Region, point: Floats, rate: Floats) -> tuple[Floats, Floats]:
    match shape:
        case Box():
            return point, rate
        case Sphere():
            length, slope = lengths(point, rate)
            return np.hstack((point, length[:, None])), np.concatenate((rate, slope[:, None]), axis=1)
        case Cylinder():
            length, slope = lengths(point[:, :2], rate[:, :2])
            return (
                np.stack((point[:, 0], point[:, 1], length, point[:, 2]), axis=1),
                np.stack((rate[:, 0], rate[:, 1], slope, rate[:, 2]), axis=1),
            )
        case Plane():
            return point[:, 2:], rate[:, 2:]


def _bounds(shape: Region) -> tuple[Floats, Floats]:
    match shape:
        case Box():
            upper = np.array((shape.x, shape.y, shape.z)) / 2.0
        case Sphere():
            upper = np.full(4, shape.radius)
        case Cylinder():
            upper = np.array((shape.radius, shape.radius, shape.radius, shape.length / 2.0))
        case Plane():
            return np.full(1, -np.inf), np.zeros(1)
    return -upper, upper


def _outside(shape: Region, point: Floats) -> Floats:
    """Signed distance of points (s, 3) from a shape, negative inside [m]."""
    match shape:
        case Box():
            over = np.abs(point) - np.array((shape.x, shape.y, shape.z)) / 2.0
        case Sphere():
            return np.linalg.norm(point, axis=1) - shape.radius
        case Cylinder():
            radial = np.hypot(point[:, 0], point[:, 1]) - shape.radius
            over = np.stack((radial, np.abs(point[:, 2]) - shape.length / 2.0), axis=1)
        case Plane():
            return point[:, 2]
    return np.linalg.norm(np.maximum(over, 0.0), axis=1) + np.minimum(over.max(axis=1), 0.0)


@constrain.register
def _(
    required: PositionInRegion, reduced: ReducedModel, window: Window, inset: float = INSET
) -> tuple[Constraint, ...]:
    lower, upper = (np.full(ROWS * len(required.members), side) for side in (-np.inf, np.inf))
    slack = RESERVED_SIZE
    for place, (shape, _) in enumerate(required.members):
        low, high = _bounds(shape)
        size = np.where(high > 0.0, np.minimum(high, RESERVED_SIZE), RESERVED_SIZE)
        rows = slice(ROWS * place, ROWS * place + len(low))
        lower[rows], upper[rows] = low + inset * size, high - inset * size
        slack = min(slack, float(size.min()))
    return (
        constraint(
            RegionCoordinates(reduced, required),
            lower=lower,
            upper=upper,
            tolerance=max(slack * inset * 0.5, 1e-9),
            window=window,
        ),
    )


def _symbolic_coordinates(shape: Region, point: "ca.SX") -> "ca.SX":
    import casadi as ca

    from trajopt.optimise.terms.symbolic import length

    match shape:
        case Sphere():
            rows = [point, length(point)]
        case Cylinder():
            rows = [point[:2], length(point[:2]), point[2]]
        case Plane():
            rows = [point[2]]
        case _:
            rows = [point]
    column = ca.vertcat(*rows)
    return ca.vertcat(column, ca.SX(np.zeros(ROWS - column.shape[0])))


def _symbolic_outside(shape: Region, point: "ca.SX") -> "ca.SX":
    import casadi as ca

    from trajopt.optimise.terms.symbolic import length

    match shape:
        case Box():
            over = ca.fabs(point) - ca.SX(np.array((shape.x, shape.y, shape.z)) / 2.0)
        case Sphere():
            return length(point) - shape.radius
        case Cylinder():
            over = ca.vertcat(length(point[:2]) - shape.radius, ca.fabs(point[2]) - shape.length / 2.0)
        case _:
            return point[2]
    return length(ca.fmax(over, 0.0)) + ca.fmin(ca.mmax(over), 0.0)


@dataclass(frozen=True, eq=False)
class ArcCoordinates:
    """Four components [m]: r - R, z, their length, and R t.

    With (r, t, z) cylindrical coordinates about the circle's axis, t counted from the middle of the arc.
    On the axis r grows towards the middle of the arc; t jumps opposite to it.
    """

    reduced: ReducedModel
    required: PointOnArc

    units = ("m",)

    @property
    def name(self) -> str:
        return f"arc of {self.required.frame}"

    def linearise(self, motion: Motion) -> Rows:
        need = self.required
        seen = relative_frame(self.reduced, motion, need.frame, need.reference, need.offset)
        axes = need.centre.rotation @ from_rpy(0.0, 0.0, need.sweep / 2.0)
        point, rate = (seen.point - need.centre.translation) @ axes, axes.T @ seen.point_jacobian
        radius, radius_rate = lengths(point[:, :2], rate[:, :2], aside=0)
        off = np.stack((radius - need.radius, point[:, 2]), axis=1)
        off_rate = np.stack((radius_rate, rate[:, 2]), axis=1)
        apart, apart_rate = lengths(off, off_rate)
        # On the axis the direction is unknown, and turning would be infinitely fast.
        square = np.maximum(radius, 1e-6)[:, None] ** 2
        turn = (point[:, :1] * rate[:, 1] - point[:, 1:2] * rate[:, 0]) / square
        along = need.radius * np.arctan2(point[:, 1], point[:, 0])
        return motion.rows_of_all(
            np.stack((off[:, 0], off[:, 1], apart, along), axis=1),
            np.stack((off_rate[:, 0], off_rate[:, 1], apart_rate, need.radius * turn), axis=1),
        )

    def expression(self, kinematics: "SymbolicKinematics") -> "ca.SX":
        import casadi as ca

        from trajopt.optimise.terms.symbolic import length

        need = self.required
        axes = need.centre.rotation @ from_rpy(0.0, 0.0, need.sweep / 2.0)
        seen = kinematics.point(need.frame, need.offset, need.reference)
        point = ca.SX(axes.T) @ (seen - ca.SX(need.centre.translation))
        off = ca.vertcat(length(point[:2]) - need.radius, point[2])
        return ca.vertcat(off, length(off), need.radius * ca.atan2(point[1], point[0]))


@constrain.register
def _(
    required: PointOnArc, reduced: ReducedModel, window: Window, inset: float = INSET
) -> tuple[Constraint, ...]:
    within = required.tolerance * (1.0 - inset)
    whole = required.sweep >= 2.0 * np.pi
    reach = np.inf if whole else required.radius * required.sweep / 2.0
    return (
        constraint(
            ArcCoordinates(reduced, required),
            lower=(-within, -within, -np.inf, -reach),
            upper=(within, within, within, reach),
            tolerance=max(required.tolerance * inset * 0.5, 1e-9),
            window=window,
        ),
    )
