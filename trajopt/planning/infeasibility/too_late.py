"""A deadline that no motion can meet: by the limits of the joints alone the goal is too far away."""

from collections.abc import Iterator
from math import inf, isfinite, sqrt

import numpy as np

from trajopt.geometry import Query
from trajopt.optimise.terms.joint_positions import joint_box
from trajopt.planning.infeasibility.chain import Chain
from trajopt.problem.problem import Problem
from trajopt.problem.requirements import FramePlacement
from trajopt.robot.limits import EXCESS, JointLimits
from trajopt.robot.loading.pinocchio_model import joint_unit
from trajopt.scene.reduced import ReducedModel
from trajopt.values.printed import in_unit


def too_late(problem: Problem) -> str:
    """Say why no motion meets the deadline of a problem; empty where that cannot be proven.

    Nothing but limits of joints is used: no joint gets from start to goal in less time than its own velocity,
    acceleration and jerk allow, and no frame moves faster than all joints at full speed could move it.

    Args:
        problem: With one goal.
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
    """Return the least time from rest to rest over a distance [s]; limits may be infinite.

    The larger of two: that of full acceleration, and that of full jerk.

    Args:
        distance: Not negative [rad | m].
        velocity: Limit [rad/s | m/s].
        acceleration: Limit [rad/s^2 | m/s^2].
        jerk: Limit [rad/s^3 | m/s^3].
    """
    if distance == 0.0:
        return 0.0
    if distance * acceleration >= velocity**2:
        hurried = distance / velocity + (velocity / acceleration if isfinite(acceleration) else 0.0)
    else:
        hurried = 2.0 * sqrt(distance / acceleration)
    return max(hurried, (32.0 * distance / jerk) ** (1.0 / 3.0))


def _joints(problem: Problem) -> Iterator[tuple[float, str]]:
    """Yield the least time of each joint that a goal of joints moves."""
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
    """Yield the least time of each frame that a goal places in the world."""
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
    """Return how far a frame has to go at least [m]; 0 where that depends on what moves."""
    reference, where = reduced.attachment(goal.reference)
    carrier, place = reduced.attachment(goal.frame)
    if reference != 0 or carrier == 0:
        return 0.0
    at = Query(reduced).kinematics(reduced.start_positions[None])
    point = at.rotation[0, carrier] @ (place * goal.offset) + at.translation[0, carrier]
    away = float(np.linalg.norm(where * goal.placement.translation - point))
    return max(away - float(np.linalg.norm(goal.position_tolerance)) - EXCESS, 0.0)
