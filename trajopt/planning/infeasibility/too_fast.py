"""A start in motion that no braking keeps within a joint's limits."""

from math import inf, isfinite, sqrt

from trajopt.problem.problem import Problem
from trajopt.robot.limits import EXCESS, LimitKind
from trajopt.robot.loading.pinocchio_model import joint_unit
from trajopt.values.printed import in_unit


def too_fast(problem: Problem) -> str:
    """Say which joint must leave its limits however hard it brakes; empty if none must.

    Braking is bounded by the joint's own limits of acceleration and jerk alone, so what is said is proven.

    Args:
        problem: The problem; its start may be in motion.
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
    return ""


def least_travel(speed: float, gain: float, hardest: float, jerk: float) -> float:
    """Return how far a joint still goes before it turns back at the soonest [rad | m].

    Args:
        speed: Its velocity.
        gain: Its acceleration, at most `hardest`.
        hardest: Limit of the acceleration.
        jerk: Limit of the jerk, may be infinite.

    Returns:
        The travel; minus infinity where it need not go that way at all.
    """
    if not isfinite(jerk):
        return speed**2 / (2.0 * hardest) if speed > 0.0 else -inf
    if speed <= 0.0 and (gain <= 0.0 or gain**2 + 2.0 * jerk * speed <= 0.0):
        return -inf
    turned, settled = (gain + sqrt(gain**2 + 2.0 * jerk * speed)) / jerk, (gain + hardest) / jerk
    t = min(turned, settled)
    travel, left = t * (speed + t * (gain / 2.0 - t * jerk / 6.0)), speed + t * (gain - t * jerk / 2.0)
    return travel + (left**2 / (2.0 * hardest) if settled < turned else 0.0)
