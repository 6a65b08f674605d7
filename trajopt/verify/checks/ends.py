"""The ends of a motion: it starts as the robot is and moves, and ends at rest unless it meets what moves."""

import numpy as np

from trajopt.arrays import Floats
from trajopt.model.description.pinocchio_model import joint_unit
from trajopt.model.printed import in_unit
from trajopt.verify.certificate import Check, CheckKind, Evidence
from trajopt.verify.kernel.motion import Motion


def end_checks(
    motion: Motion, start_velocities: Floats | None = None, start_accelerations: Floats | None = None
) -> tuple[Check, ...]:
    """Judge the start and, where the trajectory states velocities, those at both ends.

    Args:
        motion: The motion.
        start_velocities: Of the group's joints at the start, shape (n,) [rad/s | m/s]; at rest when None.
        start_accelerations: The same of accelerations, shape (n,) [rad/s^2 | m/s^2]; not judged where None or
            zero, but for the jumps that a limit of jerk forbids.
    """
    off = np.abs(motion.trajectory.positions[0] - motion.reduced.start_positions)
    checks = [_check(motion, "start", off, time=0.0, bound=motion.options.start_error, order=0)]
    velocities = motion.trajectory.velocities
    if velocities is not None:
        rests = start_velocities is None or not start_velocities.any()
        begin = velocities[0] if start_velocities is None else velocities[0] - start_velocities
        ends = [("start at rest" if rests else "start velocity", np.abs(begin), 0.0)]
        ends += [("end at rest", np.abs(velocities[-1]), motion.duration)] * motion.rests_after
        for name, speeds, time in ends:
            rest = motion.options.rest_speed
            checks.append(_check(motion, name, speeds, time=time, bound=rest, order=1))
    if start_accelerations is not None and start_accelerations.any() and motion.differentiable:
        off = np.abs(motion.trajectory(0.0, 2) - start_accelerations)
        error = motion.options.start_acceleration_error
        checks.append(_check(motion, "start acceleration", off, time=0.0, bound=error, order=2))
    return tuple(checks)


def ends_hold(
    motion: Motion, start_velocities: Floats | None = None, start_accelerations: Floats | None = None
) -> bool:
    """Say whether all `end_checks` hold."""
    options, velocities = motion.options, motion.trajectory.velocities
    off = np.abs(motion.trajectory.positions[0] - motion.reduced.start_positions).max()
    if velocities is not None:
        begin = velocities[0] if start_velocities is None else velocities[0] - start_velocities
        end = velocities[-1] if motion.rests_after else np.zeros_like(begin)
        if not ((np.abs(begin) <= options.rest_speed) & (np.abs(end) <= options.rest_speed)).all():
            return False
    moving = start_accelerations is not None and start_accelerations.any() and motion.differentiable
    if moving:
        return all(check.holds for check in end_checks(motion, start_velocities, start_accelerations))
    return bool(off <= options.start_error)


def _check(motion: Motion, name: str, sizes: Floats, *, time: float, bound: float, order: int) -> Check:
    joint = int(sizes.argmax())
    subject = motion.reduced.joint_names[joint]
    value = float(sizes[joint])
    unit = joint_unit(motion.reduced.scene.robot.model, subject, order=order)
    return Check(
        kind=CheckKind.ENDS,
        name=name,
        subject=subject,
        value=value,
        bound=bound,
        unit=unit,
        time=time,
        slack=bound - value,
        evidence=Evidence.PROVEN,
        holds=value <= bound,
        detail=f"{subject} {'moves at' if name.endswith('rest') else 'is off by'} {in_unit(value, unit)}",
    )
