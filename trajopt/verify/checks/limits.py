"""Joint limits: position, velocity, acceleration and jerk, judged at all times."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from trajopt.native import proof
from trajopt.robot.joints import JointLimits, joint_unit
from trajopt.scene.reduced import ReducedModel
from trajopt.values.arrays import Floats, readonly
from trajopt.values.cached import cached_per_value
from trajopt.values.errors import ProblemError, shown
from trajopt.values.printed import in_unit, in_unit_apart
from trajopt.verify.certificate import Check, CheckKind, Evidence
from trajopt.verify.kernel.motion import JudgedMotion
from trajopt.verify.specification import Criterion


def moving_limits(reduced: ReducedModel, limits: JointLimits | None) -> JointLimits:
    """Return limits of all movable joints, in the model's order.

    Limits of mimic joints are the robot's own.

    Args:
        limits: Of the group's joints, or of all movable joints; the robot's by default.
    """
    moving = reduced.moving_joints
    if limits is not None and limits.joint_names == moving:
        return limits
    stated = reduced.derived_of_robot(_stated)
    if limits is None:
        return stated
    if limits.joint_names != reduced.joint_names:
        raise ProblemError(
            f"the limits are of {', '.join(limits.joint_names)}, but group {shown(reduced.group)} has the "
            f"joints {', '.join(reduced.joint_names)}"
        )
    places = np.array([moving.index(joint) for joint in reduced.joint_names], dtype=np.int64)
    columns = [
        np.array(column)
        for column in (
            stated.lower, stated.upper, stated.velocity, stated.acceleration, stated.jerk, stated.effort,
        )
    ]  # fmt: skip
    given = (limits.lower, limits.upper, limits.velocity, limits.acceleration, limits.jerk, limits.effort)
    for column, values in zip(columns, given, strict=True):
        column[places] = values
    return JointLimits(moving, *(readonly(column) for column in columns), defaulted=limits.defaulted)


def _stated(reduced: ReducedModel) -> JointLimits:
    return reduced.scene.robot.limits.take(reduced.places_of(reduced.moving_joints))


def group_part(reduced: ReducedModel, limits: JointLimits) -> JointLimits:
    moving = reduced.moving_joints
    if moving == reduced.joint_names:
        return limits
    return limits.take(np.array([moving.index(joint) for joint in reduced.joint_names], dtype=np.int64))


def joint_words(reduced: ReducedModel, joint: str) -> str:
    mimic = reduced.scene.robot.mimics.get(joint)
    return joint if mimic is None else f"{joint}, which follows {mimic.source},"


QUANTITIES = ("joint position", "velocity", "acceleration", "jerk")


@dataclass(frozen=True, eq=False)
class _Tightest:
    """For each joint the value nearest to its limit, or farthest beyond it, shape (n,) each."""

    values: Floats
    times: Floats
    bounds: Floats
    slack: Floats
    accepted: Floats


@dataclass(frozen=True, eq=False)
class LimitCriterion(Criterion):
    """Position, velocity, acceleration and jerk limits of joints.

    Extremes of polynomials are exact to rounding, so the checks hold at all times. Under a jerk limit the
    acceleration must not jump either, including at the start (from the acceleration before it) and at the end
    (to rest).

    Attributes:
        limits: Of all movable joints, including mimic joints, in the model's order.
        start_accelerations: Of the group's joints before the motion, shape (n,) [rad/s^2 | m/s^2]; zero by
            default.
    """

    motion: JudgedMotion
    limits: JointLimits
    start_accelerations: Floats | None

    def holds(self) -> bool:
        """Decide the criterion by bounds of the polynomials, or else by their extremes."""
        motion, before = self.motion, self.start_accelerations
        bands, matrix, position = _bands(self.limits), motion.reduced.mimic_matrix, motion.moving(0)
        judged, excess = bands.judged if motion.differentiable else 2, motion.options.excess
        # Half of what is accepted: so the extremes, which are known to a thousandth of that, pass as well.
        return (
            proof.limits_hold(
                position.times,
                np.ascontiguousarray(position.coefficients),
                bands.lower[:judged] - excess / 2.0 * bands.sizes_below[:judged],
                bands.upper[:judged] + excess / 2.0 * bands.sizes_above[:judged],
                np.zeros(len(matrix)) if before is None else matrix @ before,
                excess * bands.jumps,
                motion.rests_after,
            )
            or super().holds()
        )

    def measure(self) -> Iterator[Check]:
        motion, limits = self.motion, self.limits
        for order, (lower, upper) in enumerate(_ranges(motion, limits)):
            jumps = _jumps(motion, limits, self.start_accelerations) if order == 3 else []
            yield from jumps or _of_order(motion, order, lower, upper)


@dataclass(frozen=True, eq=False)
class _Bands:
    """Limits of each derivative order.

    Attributes:
        lower: Of position, velocity, acceleration and jerk, shape (4, n), as `upper`.
        sizes_below: Scale of the accepted excess over lower limits, shape (4, n); `sizes_above` likewise.
        judged: Number of judged orders of a smooth motion: jerk only if it is limited.
        jumps: Scale of accepted jumps of the acceleration, shape (n,); empty without jerk limits.
    """

    lower: Floats
    upper: Floats
    sizes_below: Floats
    sizes_above: Floats
    judged: int
    jumps: Floats


@cached_per_value
def _bands(limits: JointLimits) -> _Bands:
    rates = (limits.velocity, limits.acceleration, limits.jerk)
    lower, upper = np.stack((limits.lower, *(-rate for rate in rates))), np.stack((limits.upper, *rates))
    below, above = np.abs(lower), np.abs(upper)
    below[0], above[0] = np.maximum(below[0], 1.0), np.maximum(above[0], 1.0)
    limited = np.isfinite(limits.jerk)
    jumps = np.where(limited, _jump_scale(limits), np.inf) if limited.any() else np.zeros(0)
    return _Bands(lower, upper, below, above, 4 if limited.any() else 3, jumps)


def _jump_scale(limits: JointLimits) -> Floats:
    """Return the scale of acceleration jumps, shape (n,); with a jerk limit only, its change in a second."""
    return np.where(np.isfinite(limits.acceleration), limits.acceleration, limits.jerk)


def _ranges(motion: JudgedMotion, limits: JointLimits) -> Iterator[tuple[Floats, Floats]]:
    yield limits.lower, limits.upper
    yield -limits.velocity, limits.velocity
    if motion.differentiable:
        yield -limits.acceleration, limits.acceleration
        if np.isfinite(limits.jerk).any():
            yield -limits.jerk, limits.jerk


def _accepted(motion: JudgedMotion, order: int, bounds: Floats) -> Floats:
    sizes = np.where(np.isfinite(bounds), np.abs(bounds), 0.0)
    return motion.options.excess * (np.maximum(sizes, 1.0) if order == 0 else sizes)


def _jumps(motion: JudgedMotion, limits: JointLimits, start_accelerations: Floats | None) -> list[Check]:
    off = np.array(motion.acceleration_jumps)
    if start_accelerations is not None:
        off[0] -= start_accelerations
    jumps = np.abs(off @ motion.reduced.mimic_matrix.T)
    limited = np.isfinite(limits.jerk)
    worst = np.where(limited, jumps.max(axis=0), 0.0)
    scale = _jump_scale(limits)
    checks: list[Check] = []
    if not (worst > motion.options.excess * scale).any():
        return checks
    for joint, name in enumerate(motion.reduced.moving_joints):
        if not limited[joint] or worst[joint] <= motion.options.excess * scale[joint]:
            continue
        row = int(jumps[:, joint].argmax())
        jump = in_unit(worst[joint], joint_unit(motion.reduced.scene.robot.model, name, order=2))
        checks.append(
            Check(
                kind=CheckKind.LIMIT,
                name=QUANTITIES[3],
                subject=name,
                value=None,
                bound=float(limits.jerk[joint]),
                unit=joint_unit(motion.reduced.scene.robot.model, name, order=3),
                time=float(motion.trajectory.times[row]),
                slack=None,
                evidence=Evidence.PROVEN,
                holds=False,
                detail=f"the acceleration of {joint_words(motion.reduced, name)} jumps by "
                f"{jump}, its jerk is limited",
            )
        )
    return checks


def _of_order(motion: JudgedMotion, order: int, lower: Floats, upper: Floats) -> list[Check]:
    found = _tightest(motion, order, lower, upper)
    scale = np.ones(len(lower)) if order == 0 else np.maximum(upper, 1e-12)
    relative = found.slack / np.where(np.isfinite(scale), scale, 1.0)
    checks: list[Check] = []
    for joint in (int(place) for place in np.argsort(relative)):
        holds = bool(found.slack[joint] >= -found.accepted[joint])
        if checks and holds:
            break
        name = motion.reduced.moving_joints[joint]
        limited = bool(np.isfinite(found.bounds[joint]))
        unit = joint_unit(motion.reduced.scene.robot.model, name, order=order)
        reached, bound = in_unit_apart(float(found.values[joint]), float(found.bounds[joint]), unit)
        detail = f"{joint_words(motion.reduced, name)} reaches {reached}"
        detail += f", its limit is {bound}" if limited else " and has no limit"
        checks.append(
            Check(
                kind=CheckKind.LIMIT,
                name=QUANTITIES[order],
                subject=name,
                value=float(found.values[joint]),
                bound=float(found.bounds[joint]) if limited else None,
                unit=unit,
                time=float(found.times[joint]),
                slack=float(found.slack[joint]) if limited else None,
                evidence=Evidence.PROVEN,
                holds=holds,
                detail=detail,
            )
        )
    return checks


def _tightest(motion: JudgedMotion, order: int, lower: Floats, upper: Floats) -> _Tightest:
    high, low = motion.moving(order).extremes()
    above = upper - high.values <= low.values - lower
    bounds = np.where(above, upper, lower)
    return _Tightest(
        values=np.where(above, high.values, low.values),
        times=np.where(above, high.times, low.times),
        bounds=bounds,
        slack=np.where(above, upper - high.values, low.values - lower),
        accepted=_accepted(motion, order, bounds),
    )
