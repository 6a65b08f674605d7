"""Checks of distances between frames and of lines of sight."""

from functools import partial

import coal
import numpy as np

from trajopt.problem.requirements import DistanceBetween, LineOfSight
from trajopt.values.arrays import Floats
from trajopt.values.errors import ProblemError, shown
from trajopt.values.placement import Placement
from trajopt.values.shapes.clouds import Points, Voxels
from trajopt.values.shapes.shapes import Box, Capsule, Cone, Convex, Cylinder, Mesh, Plane, Shape, Sphere
from trajopt.verify.certificate import Check
from trajopt.verify.checks.quantities import Quantity, When, check_requirement, checks_of, quantities
from trajopt.verify.kernel.motion import JudgedMotion
from trajopt.verify.kernel.relative_motion import RelativeMotion
from trajopt.verify.kernel.shapes import coal_geometry


@quantities.register
def _(requirement: DistanceBetween, motion: JudgedMotion) -> tuple[Quantity, ...]:
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
    """Return the distance of a moving point as one quantity per finite bound.

    With p the point relative to the origin, of speed v and acceleration u, |p| is convex up to u, so between
    two times it exceeds neither end by more than u h^2 / 8; and its second derivative is at most u + v^2 /
    |p|, so it falls below the lower end by no more than that times h^2 / 8.

    Args:
        moving: Point relative to a reference frame.
        origin: Point of the reference frame from which distances are measured, shape (3,) [m].
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


_THIN = 1e-3


@quantities.register
def _(requirement: LineOfSight, motion: JudgedMotion) -> tuple[Quantity, ...]:
    found: list[Quantity] = []
    motion = motion.among
    for name in requirement.obstacles(motion.reduced.scene):
        camera = RelativeMotion(motion, requirement.frame, reference=name, offset=requirement.origin)
        target = RelativeMotion(motion, requirement.reference, reference=name, offset=requirement.target)
        for shape, where in motion.reduced.scene.object(name).parts:
            if isinstance(shape, Mesh | Points | Voxels):
                what = "has an exact mesh" if isinstance(shape, Mesh) else "is a cloud"
                raise ProblemError(f"{requirement}: object {shown(name)} {what}")
            part = _Part(shape, where, _error(motion, name))
            found.append(_quantity(requirement, name, part, camera, target))
    return tuple(found)


@check_requirement.register
def _(requirement: LineOfSight, motion: JudgedMotion, when: When) -> tuple[Check, ...]:
    found = checks_of(quantities(requirement, motion), motion.among, when)
    failed = tuple(check for check in found if not check.holds)
    return failed or tuple(sorted(found, key=lambda check: check.slack or 0.0)[:1])


def _error(motion: JudgedMotion, name: str) -> float:
    carrier = motion.reduced.scene.carrier(name)
    prediction = None if carrier is None else motion.reduced.scene.object(carrier).timing.motion
    return 0.0 if prediction is None else prediction.error_at(motion.clock + motion.duration)


def _quantity(
    requirement: LineOfSight, name: str, part: "_Part", camera: RelativeMotion, target: RelativeMotion
) -> Quantity:
    margin = requirement.margin

    def states(times: Floats) -> Floats:
        return np.stack((camera.placements(times)[1], target.placements(times)[1]), axis=1)

    def bound(begin: Floats, end: Floats, lines: Floats) -> Floats:
        rates = camera.bounds(begin, end), target.bounds(begin, end)
        shift = np.maximum(*(one.shift for one in rates))
        bulge = np.maximum(*(one.point_acceleration for one in rates)) * (end - begin) ** 2 / 8.0
        directions = part.directions(lines[1])
        first, middle, last = (part.gap(lines[row], directions) for row in range(3))
        return margin - np.maximum(middle - shift, np.minimum(first, last) - bulge)

    return Quantity(
        kind="line of sight",
        name="distance of the line of sight",
        subject=f"{requirement.frame} past {name}",
        unit="m",
        limit=margin,
        states=states,
        number=lambda lines: part.gap(lines, part.directions(lines)),
        bound=bound,
        least=True,
    )


class _Part:
    """A convex part of an object with a prediction error [m], and lines in its frame, (c, 2, 3) [m]."""

    def __init__(self, shape: Shape, where: Placement, error: float) -> None:
        self._shape, self._where, self._error = shape, where, error
        self._geometry = coal_geometry(shape)
        self._at = coal.Transform3s(where.rotation, where.translation)

    def gap(self, lines: Floats, directions: Floats) -> Floats:
        """Gap along unit directions (c, 3) from the part to the lines, shape (c,) [m]."""
        ends = np.einsum("cei,ci->ce", lines - self._where.translation, directions).min(axis=1) - self._error
        if isinstance(self._shape, Plane):
            return ends
        return ends - support(self._shape, directions @ self._where.rotation)

    def directions(self, lines: Floats) -> Floats:
        """Propose directions from the part to the lines with a large gap, shape (c, 3)."""
        found = np.empty((len(lines), 3))
        if isinstance(self._shape, Plane):
            found[:] = self._where.rotation[:, 2]
            return found
        request, result = coal.DistanceRequest(), coal.DistanceResult()
        request.enable_signed_distance = True
        request.gjk_tolerance = 1e-9
        for row, (camera, target) in enumerate(lines):
            result.clear()
            length = float(np.linalg.norm(target - camera))
            placed = coal.Transform3s(_axes(target - camera), (camera + target) / 2.0)
            line = coal.Capsule(_THIN, max(length, 1e-9))
            coal.distance(self._geometry, self._at, line, placed, request, result)
            found[row] = result.normal / max(float(np.linalg.norm(result.normal)), 1e-12)
        return found


def _axes(way: Floats) -> Floats:
    """Return a rotation with a given third column, by reflecting z twice."""
    length = float(np.linalg.norm(way))
    if length < 1e-12:
        return np.eye(3)
    z = way / length
    mirror = z + np.array((0.0, 0.0, 1.0 if z[2] >= 0.0 else -1.0))
    mirror = mirror / np.linalg.norm(mirror)
    # A half turn about the bisector of z and the axis; upside down where that is nearer.
    turn = 2.0 * np.outer(mirror, mirror) - np.eye(3)
    return turn if z[2] >= 0.0 else turn @ np.diag((1.0, -1.0, -1.0))


def support(shape: Shape, directions: Floats) -> Floats:
    """Return the support function of a shape, the largest `direction @ point`, shape (c,) [m].

    Args:
        shape: A mesh counts as its convex hull, a plane has infinite support.
        directions: Unit vectors in the shape's frame, shape (c, 3).
    """
    along = directions[:, 2]
    across = np.hypot(directions[:, 0], directions[:, 1])
    match shape:
        case Box():
            reach = np.abs(directions) @ np.array((shape.x, shape.y, shape.z)) / 2
        case Sphere():
            reach = np.full(len(directions), shape.radius)
        case Cylinder():
            reach = across * shape.radius + np.abs(along) * shape.length / 2
        case Capsule():
            reach = shape.radius + np.abs(along) * shape.length / 2
        case Cone():
            reach = np.maximum(along * shape.length / 2, across * shape.radius - along * shape.length / 2)
        case Plane():
            reach = np.full(len(directions), np.inf)
        case Points():
            reach = np.array([(shape.points @ each).max() for each in directions]) + shape.radius
        case Voxels():
            half = np.abs(directions).sum(axis=1) * shape.size / 2
            reach = np.array([(shape.centres @ each).max() for each in directions]) + half
        case Convex() | Mesh():
            reach = (directions @ shape.vertices.T).max(axis=1)
    return np.asarray(reach, dtype=np.float64)
