"""Checks of requirements on frames: placement, alignment of an axis, and gaze."""

from collections.abc import Callable

import numpy as np

from trajopt.problem.requirements import AxisAlignment, FramePlacement, Gaze, RotationCoordinates
from trajopt.values.arrays import Floats
from trajopt.verify.certificate import Check
from trajopt.verify.checks.distances import range_quantities
from trajopt.verify.checks.ends import relative_speeds
from trajopt.verify.checks.quantities import (
    Component,
    Quantity,
    When,
    check_requirement,
    proof_at_end,
    quantities,
    requirement_check,
    tightest,
)
from trajopt.verify.kernel.interval_proof import Excess, Proof, prove_over_time
from trajopt.verify.kernel.motion import JudgedMotion
from trajopt.verify.kernel.relative_motion import RateBounds, RelativeMotion

AXES = ("x", "y", "z")
Sizes = Callable[[Floats, Floats], Floats]
Changes = Callable[[Floats, RateBounds], tuple[Floats, Floats]]


@quantities.register
def _(requirement: FramePlacement, motion: JudgedMotion) -> tuple[Quantity, ...]:
    """Position and orientation of a frame, within tolerances.

    With R the rotation of the frame as seen from its goal and w its angular velocity, the rotation
    vector e of R changes at a rate J(e) w, where J has the norm (|e|/2) / sin(|e|/2); intrinsic x-y-z Euler
    angles change at a rate of at most |w| / cos(second angle). Second derivatives are bounded likewise.
    """
    moving = RelativeMotion(
        motion, requirement.frame, reference=requirement.reference, offset=requirement.offset
    )
    goal = requirement.placement

    def off(times: Floats) -> Floats:
        return (moving.placements(times)[1] - goal.translation) @ goal.rotation

    def turned(times: Floats) -> Floats:
        return rotation_error(goal.rotation.T @ moving.placements(times)[0], requirement)

    free = np.where(requirement.rotation_tolerance >= np.pi, np.inf, requirement.rotation_tolerance)
    parts = (("position", "m", requirement.position_tolerance, off), ("rotation", "rad", free, turned))
    return tuple(
        Quantity(
            kind=kind,
            name=f"{kind} beyond the tolerance",
            subject=requirement.frame,
            unit=unit,
            limit=0.0,
            states=states,
            number=lambda error, tolerance=tolerance: _excess(np.abs(error), tolerance),
            bound=None,
        )
        for kind, unit, tolerance, states in parts
        if np.isfinite(tolerance).any()
    )


@check_requirement.register
def _(requirement: FramePlacement, motion: JudgedMotion, when: When) -> tuple[Check, ...]:
    moving = RelativeMotion(
        motion,
        requirement.frame,
        reference=requirement.reference,
        offset=requirement.offset,
    )
    goal = requirement.placement

    def position_sizes(rotation: Floats, point: Floats) -> Floats:
        return np.abs((point - goal.translation) @ goal.rotation)

    def rotation_sizes(rotation: Floats, point: Floats) -> Floats:
        return np.abs(rotation_error(goal.rotation.T @ rotation, requirement))

    def rotation_changes(middle: Floats, bounds: RateBounds) -> tuple[Floats, Floats]:
        if requirement.coordinates is RotationCoordinates.ROTATION_VECTOR:
            return _vector_changes(middle, bounds)
        return _euler_changes(middle, bounds)

    free = np.where(requirement.rotation_tolerance >= np.pi, np.inf, requirement.rotation_tolerance)
    parts: tuple[tuple[str, str, Floats, Sizes, Changes], ...] = (
        (
            "position",
            "m",
            requirement.position_tolerance,
            position_sizes,
            _position_changes,
        ),
        ("rotation", "rad", free, rotation_sizes, rotation_changes),
    )
    checks: list[Check] = []
    for kind, unit, tolerance, sizes, changes in parts:
        if np.isinf(tolerance).all():
            continue
        proof = _prove(motion, moving, when, tolerance=tolerance, sizes=sizes, changes=changes)
        values = sizes(*moving.placements(np.array((proof.time,))))[0]
        names = tuple(f"{kind} along {axis}" for axis in AXES)
        checks.append(
            requirement_check(
                when,
                kind=kind,
                subject=requirement.frame,
                unit=unit,
                component=tightest(names, values, tolerance),
                proof=proof,
            )
        )
    return tuple(checks)


def rotation_error(rotation: Floats, requirement: FramePlacement) -> Floats:
    """Return the rotation error in the requirement's coordinates, (c, 3, 3) -> (c, 3) [rad]."""
    if requirement.coordinates is RotationCoordinates.ROTATION_VECTOR:
        return rotation_vectors(rotation)
    return euler_angles(rotation, requirement.rotation_tolerance)


def rotation_vectors(rotation: Floats) -> Floats:
    """Return rotation vectors (axis times angle) of rotations, (c, 3, 3) -> (c, 3) [rad].

    The skew part is the axis times the sine; beyond a right angle the symmetric part is used.
    """
    skew = 0.5 * (rotation - rotation.swapaxes(1, 2))[:, (2, 0, 1), (1, 2, 0)]
    sine, cosine = np.linalg.norm(skew, axis=1), 0.5 * (np.trace(rotation, axis1=1, axis2=2) - 1.0)
    angle = np.arctan2(sine, cosine)
    square = 0.5 * (rotation + rotation.swapaxes(1, 2)) - cosine[:, None, None] * np.eye(3)
    longest = np.diagonal(square, axis1=1, axis2=2).argmax(axis=1)
    axis = square[np.arange(len(square)), :, longest]
    against = (axis * skew).sum(axis=1) < 0.0
    axis = axis / np.maximum(np.linalg.norm(axis, axis=1), 1e-300)[:, None]
    beyond = np.where(against, -angle, angle)[:, None] * axis
    ratio = np.where(sine > 0.0, angle / np.where(sine > 0.0, sine, 1.0), 1.0)
    return np.where((cosine < 0.0)[:, None], beyond, ratio[:, None] * skew)


def euler_angles(rotation: Floats, tolerance: Floats) -> Floats:
    """Return intrinsic x-y-z Euler angles of rotations, (c, 3, 3) -> (c, 3) [rad].

    If the second angle is a right angle, only the sum or difference of the others is determined; it is
    assigned to the first, or to the third if the first's tolerance would not hold (MoveIt's rule).
    """
    cosine = np.hypot(rotation[:, 0, 0], rotation[:, 0, 1])
    angles = np.stack(
        (
            np.arctan2(-rotation[:, 1, 2], rotation[:, 2, 2]),
            np.arctan2(rotation[:, 0, 2], cosine),
            np.arctan2(-rotation[:, 0, 1], rotation[:, 0, 0]),
        ),
        axis=1,
    )
    for row in np.flatnonzero(cosine < 1e-9).tolist():
        angle = np.arctan2(rotation[row, 2, 1], rotation[row, 1, 1])
        first = abs(angle) <= tolerance[0]
        angles[row, 0], angles[row, 2] = (angle, 0.0) if first else (0.0, angle)
    return angles


def _prove(
    motion: JudgedMotion,
    moving: RelativeMotion,
    when: When,
    *,
    tolerance: Floats,
    sizes: Sizes,
    changes: Changes,
) -> Proof:
    """Prove that three sizes stay below their tolerances, at the end or at all times.

    Args:
        tolerance: Of the three sizes, shape (3,).
        sizes: At rotations (c, 3, 3) and points (c, 3), shape (c, 3).
        changes: Bounds on the change from the middle and on the bulge over the chord between the ends, each
            of shape (c, 3), given the sizes in the middle and bounds on rates.
    """
    if when is When.END:
        reached = sizes(*moving.placements(np.array((motion.duration,))))[0]
        return proof_at_end(motion, float((reached - tolerance).max()))

    def excess(begin: Floats, end: Floats) -> Excess:
        times = np.concatenate((begin, (begin + end) / 2, end))
        start, middle, stop = np.split(sizes(*moving.placements(times)), 3)
        bounds = moving.bounds(begin, end)
        change, curvature = changes(middle, bounds)
        bulge = curvature * ((end - begin) ** 2 / 8.0)[:, None]
        bound = np.minimum(middle + change, np.maximum(start, stop) + bulge)
        over = np.stack([_excess(size, tolerance) for size in (start, middle, stop)])
        worst = over.argmax(axis=0)
        rows = np.arange(len(begin))
        return Excess(
            over[worst, rows],
            times.reshape(3, -1)[worst, rows],
            _excess(bound, tolerance),
        )

    return prove_over_time(motion, excess)


def _excess(sizes: Floats, tolerance: Floats) -> Floats:
    bounded = np.isfinite(tolerance)
    return np.asarray((sizes[:, bounded] - tolerance[bounded]).max(axis=1))


def _position_changes(middle: Floats, bounds: RateBounds) -> tuple[Floats, Floats]:
    spread = (1, middle.shape[1])
    return np.tile(bounds.shift[:, None], spread), np.tile(bounds.point_acceleration[:, None], spread)


def _vector_changes(middle: Floats, bounds: RateBounds) -> tuple[Floats, Floats]:
    """Bound changes of the rotation vector's components; beyond pi it starts again from -pi."""
    angle = np.linalg.norm(middle, axis=1) + bounds.turn
    capped = np.minimum(angle, np.pi)
    stretch = _ratio(capped)
    rate = stretch * bounds.turn_rate
    curvature = stretch * bounds.turn_acceleration + _twist(capped) * rate * bounds.turn_rate
    curvature = np.where(angle < np.pi, curvature, np.inf)
    spread = (1, middle.shape[1])
    return np.tile((stretch * bounds.turn)[:, None], spread), np.tile(curvature[:, None], spread)


def _ratio(angle: Floats) -> Floats:
    """(a/2) / sin(a/2): the norm of the inverse left Jacobian of rotations at angle a."""
    return 1.0 / np.asarray(np.sinc(angle / (2.0 * np.pi)), dtype=np.float64)


def _twist(angle: Floats) -> Floats:
    """Bound the derivative of the inverse left Jacobian I - [e]/2 + c [e]^2 along a unit step of e.

    It is at most 1/2 + c'(a) a^2 + 2 c(a) a, where c and c' increase with the angle a up to pi.
    """
    a = np.maximum(angle, 0.1)
    c = 1.0 / a**2 - 1.0 / (2.0 * a * np.tan(a / 2.0))
    slope = -2.0 / a**3 + 1.0 / (2.0 * a**2 * np.tan(a / 2.0)) + 1.0 / (4.0 * a * np.sin(a / 2.0) ** 2)
    return 0.5 + slope * a**2 + 2.0 * c * a


def _euler_changes(middle: Floats, bounds: RateBounds) -> tuple[Floats, Floats]:
    """Bound changes of Euler angles; infinite once the second may be a right angle."""
    second = middle[:, 1] + bounds.turn
    regular = second < np.pi / 2.0 - 1e-6
    cosine = np.cos(np.where(regular, second, 0.0))
    change = np.stack((bounds.turn / cosine, bounds.turn, bounds.turn / cosine), axis=1)
    change[~regular] = np.inf
    change[:, 1] = bounds.turn
    square = bounds.turn_rate**2
    curvature = bounds.turn_acceleration / cosine + 2.0 * square / cosine**2
    curved = np.tile(curvature[:, None], (1, 3))
    curved[~regular] = np.inf
    curved[middle + change >= np.pi] = np.inf
    return change, curved


@quantities.register
def _(requirement: AxisAlignment, motion: JudgedMotion) -> tuple[Quantity, ...]:
    moving = RelativeMotion(motion, requirement.frame, reference=requirement.reference, offset=np.zeros(3))
    return (
        Quantity(
            kind="axis",
            name="angle to the direction",
            subject=requirement.frame,
            unit="rad",
            limit=requirement.tolerance,
            states=lambda times: moving.placements(times)[0] @ requirement.axis,
            number=lambda axes: _angles(axes, requirement.direction),
            bound=None,
        ),
    )


@check_requirement.register
def _(requirement: AxisAlignment, motion: JudgedMotion, when: When) -> tuple[Check, ...]:
    moving = RelativeMotion(motion, requirement.frame, reference=requirement.reference, offset=np.zeros(3))

    def axes(times: Floats) -> Floats:
        return moving.placements(times)[0] @ requirement.axis

    def excess(begin: Floats, end: Floats) -> Excess:
        times = np.concatenate((begin, (begin + end) / 2, end))
        angles = np.stack(np.split(_angles(axes(times), requirement.direction), 3))
        bounds = moving.bounds(begin, end)
        bulge = (bounds.turn_acceleration + bounds.turn_rate**2) * (end - begin) ** 2 / 8.0
        upper = np.minimum(angles[1] + bounds.turn, _chord_bound(angles[[0, 2]].max(axis=0), bulge))
        worst = angles.argmax(axis=0)
        rows = np.arange(len(begin))
        tolerance = requirement.tolerance
        return Excess(
            angles[worst, rows] - tolerance,
            times.reshape(3, -1)[worst, rows],
            upper - tolerance,
        )

    if when is When.END:
        reached = _angles(axes(np.array((motion.duration,))), requirement.direction)[0]
        proof = proof_at_end(motion, float(reached) - requirement.tolerance)
    else:
        proof = prove_over_time(motion, excess)
    angle = float(_angles(axes(np.array((proof.time,))), requirement.direction)[0])
    return (
        requirement_check(
            when,
            kind="axis",
            subject=requirement.frame,
            unit="rad",
            component=Component("angle to the direction", angle, requirement.tolerance),
            proof=proof,
        ),
    )


def _chord_bound(angle: Floats, bulge: Floats) -> Floats:
    """Bound the angle over intervals at whose ends it is at most `angle`.

    The axis is off the chord between its ends by at most `bulge`, so its part along the direction is
    at least cos(angle) - bulge, and its part across at most sin(angle) + bulge if angle <= pi / 2.
    """
    along = np.arccos(np.clip(np.cos(angle) - bulge, -1.0, 1.0))
    across = np.arcsin(np.minimum(np.sin(angle) + bulge, 1.0))
    return np.where((angle <= np.pi / 2) & (along < np.pi / 2), np.minimum(along, across), along)


@quantities.register
def _(requirement: Gaze, motion: JudgedMotion) -> tuple[Quantity, ...]:
    """A target in the view cone of a camera, and in its range.

    While the target moves by s as seen from the camera, at distance r, its direction turns by at most
    asin(s / r). A cone of half angle up to a right angle is convex: between two times at which the target is
    within an angle, the chord is too, and the target is off the chord by at most the bulge.
    """
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
    return np.arctan2(np.linalg.norm(np.cross(points, axis), axis=1), points @ axis)


def _turn(shift: Floats, distance: Floats) -> Floats:
    """Largest turn of the direction to a point that moves by a shift, at a distance, each (c,) [rad]."""
    clear = shift < distance
    return np.where(clear, np.arcsin(np.where(clear, shift / np.where(clear, distance, 1.0), 0.0)), np.pi)


@relative_speeds.register
def _(goal: FramePlacement, motion: JudgedMotion, time: float) -> tuple[float, float]:
    """Speeds along and about the axes that the placement does not leave free."""
    poses, rates = motion.poses(np.array((time,))), _rates(motion, time)
    rotation, translation = poses.rotation[0], poses.translation[0]
    joint, place = motion.reduced.attachment(goal.frame)
    base, seen_from = motion.reduced.attachment(goal.reference)
    point = rotation[joint] @ (place * goal.offset) + translation[joint]
    moved, turning = _carried(motion, joint, point, rotation, translation, rates)
    # The reference carries along what is at rest in it: its point where the frame's point is.
    taken, turned = _carried(motion, base, point, rotation, translation, rates)
    axes = rotation[base] @ seen_from.rotation @ goal.placement.rotation
    moves, turns = (moved - taken) @ axes, (turning - turned) @ axes
    held, upright = np.isfinite(goal.position_tolerance), goal.rotation_tolerance < np.pi
    return float(np.linalg.norm(moves[held])), float(np.linalg.norm(turns[upright]))


def _carried(
    motion: JudgedMotion, joint: int, point: Floats, rotation: Floats, translation: Floats, rates: Floats
) -> tuple[Floats, Floats]:
    kinematics = motion.kinematics
    velocity, turning = np.zeros(3), np.zeros(3)
    for number in kinematics.chain(joint):
        axis = rotation[number] @ kinematics.axes[number] * rates[number - 1]
        if kinematics.revolute[number]:
            velocity = velocity + np.cross(axis, point - translation[number])
            turning = turning + axis
        else:
            velocity = velocity + axis
    return velocity, turning


def _rates(motion: JudgedMotion, time: float) -> Floats:
    rates = motion.moving(1)
    piece = min(int(np.searchsorted(rates.times, time, side="right")) - 1, len(rates.times) - 2)
    since = np.array((time - float(rates.times[piece]),))
    return rates.at(np.array((piece,), dtype=np.int64), since)[0]
