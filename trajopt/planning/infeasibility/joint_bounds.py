"""Proofs by the joints' limits of speed, acceleration and jerk."""

from collections.abc import Iterator
from math import inf, isfinite, sqrt

import numpy as np

from trajopt.geometry import evaluator
from trajopt.optimise.methods.timing import tool_limits
from trajopt.optimise.terms.joint_positions import joint_box
from trajopt.problem.problem import Problem
from trajopt.problem.requirements import FramePlacement, PointOnArc, PositionInRegion, Requirement
from trajopt.robot.joints import EXCESS, JointLimits, LimitKind, joint_unit
from trajopt.scene.reduced import ReducedModel
from trajopt.values.arrays import Floats
from trajopt.values.likely_units import meant_at_distance
from trajopt.values.printed import in_length, in_unit, in_unit_apart
from trajopt.values.shapes.shapes import Plane, bounding_sphere

START_ERROR = 1e-6
"""Accepted error of a motion's start, in position and speed [rad | m, rad/s | m/s]."""


def by_then(problem: Problem, time: float) -> tuple[Floats, Floats]:
    """Return a box, shape (n,) each [rad | m], of all configurations that motions reach up to a time [s].

    Each joint is bounded by its own limits alone; infinite without limits. The start may be in motion.
    """
    return _reached(problem, time, 0.0)


def at_time(problem: Problem, time: float) -> tuple[Floats, Floats]:
    """Return a box of all configurations of motions at a time; otherwise as `by_then`.

    A joint that moves at the start is not behind where braking leaves it.
    """
    return _reached(problem, time, -inf)


def _reached(problem: Problem, time: float, least: float) -> tuple[Floats, Floats]:
    limits, start = problem.limits, problem.reduced.start_positions
    ways = list[list[float]]()
    for side in (-1.0, 1.0):
        rows = zip(
            np.maximum(side * problem.start_velocities, least).tolist(),
            np.maximum(side * problem.start_accelerations, least).tolist(),
            (limits.velocity * (1.0 + EXCESS)).tolist(),
            (limits.acceleration * (1.0 + EXCESS)).tolist(),
            (limits.jerk * (1.0 + EXCESS)).tolist(),
            strict=True,
        )
        ways.append([farthest(time, *row) for row in rows])
    lower, upper = start - ways[0] - START_ERROR, start + ways[1] + START_ERROR
    return np.maximum(lower, limits.lower - START_ERROR), np.minimum(upper, limits.upper + START_ERROR)


def farthest(time: float, speed: float, gain: float, fastest: float, hardest: float, jerk: float) -> float:
    """Bound the travel of a joint one way in a time [s], at the largest allowed acceleration [rad | m].

    Args:
        speed: Its velocity that way, negative if it moves the other way.
        gain: Its acceleration that way.
        fastest: Limit of its velocity, may be infinite.
        hardest: Limit of its acceleration, may be infinite.
        jerk: Limit of its jerk, may be infinite.
    """
    speed += START_ERROR
    fastest, hardest = max(fastest, speed), max(hardest, gain)
    travel, left = 0.0, time
    if isfinite(jerk):
        reached = (sqrt(gain**2 + 2.0 * jerk * (fastest - speed)) - gain) / jerk
        t = min(left, (hardest - gain) / jerk, reached)
        travel = t * (speed + t * (gain / 2.0 + t * jerk / 6.0))
        speed += t * (gain + t * jerk / 2.0)
        left -= t
    if isfinite(hardest) and left > 0.0:
        t = min(left, max(fastest - speed, 0.0) / hardest) if hardest > 0.0 else left
        travel += t * (speed + t * hardest / 2.0)
        left -= t
    return travel + (left * fastest if left > 0.0 else 0.0) if fastest < inf or left <= 0.0 else inf


def too_fast(problem: Problem) -> str:
    """Return which limit the start exceeds, or a joint must leave even at full braking; empty if none.

    The verdict is proven: braking is bounded by the joint's own acceleration and jerk limits.
    """
    if not problem.starts_moving:
        return ""
    limits, start = problem.limits, problem.reduced.start_positions
    rows = zip(
        limits.joint_names,
        start.tolist(),
        problem.start_velocities.tolist(),
        problem.start_accelerations.tolist(),
        limits.lower.tolist(),
        limits.upper.tolist(),
        limits.velocity.tolist(),
        limits.acceleration.tolist(),
        limits.jerk.tolist(),
        strict=True,
    )
    for joint, position, velocity, acceleration, lower, upper, fastest, hardest, jerk in rows:
        units = [joint_unit(problem.scene.robot.model, joint, order=order) for order in range(3)]
        for side, limit, kind in ((1.0, upper, LimitKind.UPPER), (-1.0, lower, LimitKind.LOWER)):
            speed, gain, room = side * velocity, side * acceleration, side * (limit - position)
            needed = least_travel(speed, gain, hardest, jerk)
            if needed > room + EXCESS:
                return (
                    f"{joint} moves at {in_unit(velocity, units[1])}, {in_unit(room, units[0])} before its "
                    f"{kind.value} limit{limits.because(joint, kind)}; to stop takes it "
                    f"{in_unit(needed, units[0])}, braking as hard as its limits allow"
                )
            reached = speed + (gain**2 / (2.0 * jerk) if gain > 0.0 else 0.0)
            if reached > fastest * (1.0 + EXCESS):
                return (
                    f"{joint} gains {in_unit(acceleration, units[2])} at the start and so reaches "
                    f"{in_unit(reached, units[1])}, however its jerk limit is used; its velocity limit is "
                    f"{in_unit(fastest, units[1])}{limits.because(joint, LimitKind.VELOCITY)}"
                )
    query = problem.evaluator(problem.reduced)
    for tool in problem.tool_speeds:
        limited = tool_limits(query, (tool,))
        assert limited is not None  # a tool speed has a limit at least
        found = limited.speeds(start[None], problem.start_velocities[None])[0].tolist()
        units = [unit for limit, unit in ((tool.linear, "m/s"), (tool.angular, "rad/s")) if isfinite(limit)]
        for name, speed, limit, unit in zip(limited.names, found, limited.limit.tolist(), units, strict=True):
            if speed > limit + EXCESS:
                here, most = in_unit_apart(speed, limit, unit)
                return f"the {name} is {here} at the start; its limit is {most}"
    return ""


def least_travel(speed: float, gain: float, hardest: float, jerk: float) -> float:
    """Return the least travel of a joint before it turns back [rad | m]; -inf if it need not go that way.

    Args:
        gain: Its acceleration, at most `hardest`.
    """
    if not isfinite(jerk):
        return speed**2 / (2.0 * hardest) if speed > 0.0 else -inf
    if speed <= 0.0 and (gain <= 0.0 or gain**2 + 2.0 * jerk * speed <= 0.0):
        return -inf
    turned, settled = (gain + sqrt(gain**2 + 2.0 * jerk * speed)) / jerk, (gain + hardest) / jerk
    t = min(turned, settled)
    travel, left = t * (speed + t * (gain / 2.0 - t * jerk / 6.0)), speed + t * (gain - t * jerk / 2.0)
    return travel + (left**2 / (2.0 * hardest) if settled < turned else 0.0)


def too_late(problem: Problem) -> str:
    """Return why no motion meets the deadline of a problem; empty without a proof.

    No joint gets from start to goal in less time than its own limits allow, and no frame moves faster than
    all joints at full speed could move it.
    """
    if problem.finish_by is None:
        return ""
    needed, words = max((*_joints(problem), *_frames(problem)), default=(0.0, ""))
    # What the judge lets limits be exceeded by makes a motion shorter by no more than that.
    if needed * (1.0 - 2.0 * EXCESS) <= problem.finish_by:
        return ""
    within = "by the limits of the joints"
    return f"{words} takes {needed:.3f} s at least, {within}; the deadline is {problem.finish_by:g} s"


def least_time(distance: float, velocity: float, acceleration: float, jerk: float) -> float:
    """Return the least time from rest to rest over a distance >= 0 [s]; limits may be infinite.

    The larger of the times at full acceleration and at full jerk.
    """
    if distance == 0.0:
        return 0.0
    if distance * acceleration >= velocity**2:
        hurried = distance / velocity + (velocity / acceleration if isfinite(acceleration) else 0.0)
    else:
        hurried = 2.0 * sqrt(distance / acceleration)
    return max(hurried, (32.0 * distance / jerk) ** (1.0 / 3.0))


def _joints(problem: Problem) -> Iterator[tuple[float, str]]:
    reduced, limits = problem.reduced, problem.limits
    lower, upper = joint_box(problem.goals, reduced)
    start = reduced.start_positions
    away = np.maximum(lower - start, start - upper) - EXCESS
    for place in (int(each) for each in np.flatnonzero(away > 0.0)):
        joint, distance = limits.joint_names[place], float(away[place])
        unit = joint_unit(problem.scene.robot.model, joint)
        yield (
            _least_of_joint(problem, limits, place, distance),
            f"{joint} alone, {in_unit(distance, unit)} away,",
        )


def _least_of_joint(problem: Problem, limits: JointLimits, place: int, distance: float) -> float:
    velocity = float(limits.velocity[place])
    if velocity <= 0.0:
        return inf
    if problem.starts_moving:
        return distance / velocity
    return least_time(distance, velocity, float(limits.acceleration[place]), float(limits.jerk[place]))


def _frames(problem: Problem) -> Iterator[tuple[float, str]]:
    reduced = problem.reduced
    for goal in problem.goals:
        if not isinstance(goal, FramePlacement) or any(map(problem.scene.carrier, goal.frames)):
            continue
        missing = _missing(goal, reduced)
        carrier, place = reduced.attachment(goal.frame)
        levers = Chain(reduced).point_levers(carrier, place * goal.offset)
        fastest = float(levers @ np.where(levers > 0.0, problem.limits.velocity, 0.0))
        if missing > 0.0 and fastest > 0.0:
            yield missing / fastest, f"{goal.frame}, {missing:.3f} m away,"


def _missing(goal: FramePlacement, reduced: ReducedModel) -> float:
    """Return the least travel of a frame to its goal [m]; 0 if that depends on moving objects."""
    reference, where = reduced.attachment(goal.reference)
    carrier, place = reduced.attachment(goal.frame)
    if reference != 0 or carrier == 0:
        return 0.0
    at = evaluator(reduced).kinematics(reduced.start_positions[None])
    point = at.rotation[0, carrier] @ (place * goal.offset) + at.translation[0, carrier]
    away = float(np.linalg.norm(where * goal.placement.translation - point))
    return max(away - float(np.linalg.norm(goal.position_tolerance)) - EXCESS, 0.0)


ENDLESS = 1e6
"""Replaces a range without limits [rad | m]."""


class Chain:
    """Lengths of the chains of a reduced model.

    A point is at most as far from a joint's origin as the offsets of all joints between are long together,
    with the range of those that slide.
    """

    def __init__(self, reduced: ReducedModel) -> None:
        model, limits = reduced.model, reduced.limits
        self._reduced = reduced
        # Joints without limits turn; one that slid along with them would be far beyond any bound.
        lower, upper = np.maximum(limits.lower, -ENDLESS), np.minimum(limits.upper, ENDLESS)
        ends = np.stack([reduced.mimic_matrix @ side + reduced.mimic_offset for side in (lower, upper)])
        names = list(model.names)[1:]
        self._slides = np.array([joint_unit(model, name) == "m" for name in names], dtype=np.bool_)
        farthest = np.abs(np.where(self._slides, ends, 0.0)).max(axis=0, initial=0.0)
        offsets = [
            np.linalg.norm(model.jointPlacements[joint].translation) for joint in range(1, model.njoints)
        ]
        self._offset, self._slide = np.array(offsets, dtype=np.float64), farthest

    def joints(self, joint: int) -> list[int]:
        return [int(each) for each in self._reduced.model.supports[joint]][1:]

    def longest(self, first: int, joint: int, point: Floats) -> float:
        """Bound the distance [m] of a point, in the frame of `joint`, from `first`, nearer to the base."""
        chain = self.joints(joint)
        after = chain[chain.index(first) + 1 :]
        between = sum(self._offset[each - 1] + self._slide[each - 1] for each in after)
        return float(between + self._slide[first - 1] + np.linalg.norm(point))

    def levers(self, body: int) -> Floats:
        """Bound the motion of any point of a body when a joint of the group moves, shape (n,) [m/rad | 1].

        Turning by an angle moves a point by at most the angle times its distance from the axis.
        """
        reduced = self._reduced
        fixed, levers = reduced.bodies[body], np.zeros(len(reduced.joint_names))
        if isinstance(fixed.shape, Plane) or fixed.joint == 0:
            return levers if fixed.joint == 0 else np.full_like(levers, np.inf)
        centre, radius = bounding_sphere(fixed.shape)
        return self.point_levers(fixed.joint, fixed.placement * centre, radius)

    def point_levers(self, carrier: int, point: Floats, radius: float = 0.0) -> Floats:
        """Bound the motion of points of a ball when a joint of the group moves, shape (n,) [m/rad | 1].

        Args:
            carrier: The joint that carries the ball; 0 for the world.
            point: Its centre in the joint's frame, shape (3,) [m].
            radius: Its radius [m].
        """
        levers, away = np.zeros(len(self._reduced.joint_names)), float(np.linalg.norm(point)) + radius
        for joint in reversed(self.joints(carrier)):
            away += self._slide[joint - 1]
            arm = 1.0 if self._slides[joint - 1] else away
            levers += np.abs(self._reduced.mimic_matrix[joint - 1]) * arm
            away += self._offset[joint - 1]
        return levers

    def turns(self, carrier: int) -> Floats:
        """Bound the rotation of a joint's children when a joint of the group moves, shape (n,) [rad/rad]."""
        turns = np.zeros(len(self._reduced.joint_names))
        for joint in self.joints(carrier):
            if not self._slides[joint - 1]:
                turns += np.abs(self._reduced.mimic_matrix[joint - 1])
        return turns


ACCURACY = 1e-6
"""A smaller distance beyond reach proves nothing [m]."""


def out_of_reach(required: Requirement, reduced: ReducedModel) -> str:
    """Return how far a requirement is out of reach, as a sentence; empty without a proof.

    The bound is the sum of the lengths of the chain, so excluded goals are out of reach.
    """
    balls = _balls(required)
    if not balls or not isinstance(required, FramePlacement | PositionInRegion | PointOnArc):
        return ""
    reference, where = reduced.attachment(required.reference)
    carrier, place = reduced.attachment(required.frame)
    if reference != 0 or carrier == 0:
        return ""
    chain = Chain(reduced)
    first = chain.joints(carrier)[0]
    origin = reduced.model.jointPlacements[first].translation
    length = chain.longest(first, carrier, place * required.offset)
    missing = min(
        float(np.linalg.norm(where * centre - origin)) - radius - length for centre, radius in balls
    )
    if missing <= ACCURACY:
        return ""
    return (
        f"{required.frame} would have to be at least {length + missing:.3f} m from "
        f"{reduced.model.names[first]}, but the arm is only {length:.3f} m long from there: "
        f"{in_length(missing)} too short{meant_at_distance(length + missing, length)}"
    )


def _balls(required: Requirement) -> tuple[tuple[Floats, float], ...]:
    """Return balls in the reference that hold all possible places of the point; none if unbounded."""
    if isinstance(required, FramePlacement):
        radius = float(np.linalg.norm(required.position_tolerance))
        return ((required.placement.translation, radius),) if np.isfinite(radius) else ()
    if isinstance(required, PointOnArc):
        return ((required.centre.translation, required.radius + required.tolerance),)
    if isinstance(required, PositionInRegion):
        if any(isinstance(shape, Plane) for shape, _ in required.members):
            return ()
        spheres = [(bounding_sphere(shape), where) for shape, where in required.members]
        return tuple((where * centre, radius) for (centre, radius), where in spheres)
    return ()
