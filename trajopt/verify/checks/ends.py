"""The ends of a motion: it starts as the robot is and moves, and ends at rest unless it meets what moves."""

import numpy as np

from trajopt.robot.loading.pinocchio_model import joint_unit
from trajopt.values.arrays import Floats
from trajopt.values.printed import in_unit
from trajopt.verify.certificate import Check, CheckKind, Evidence
from trajopt.verify.kernel.motion import Motion
from trajopt.verify.specification import Specification


def end_checks(motion: Motion, specification: Specification) -> tuple[Check, ...]:
    """Judge the start and, where the trajectory states velocities, those at both ends.

    Args:
        motion: The motion.
        specification: Where it starts, and how fast and with which acceleration; accelerations are not judged
            where there are none, or zeros, but for the jumps that a limit of jerk forbids.
    """
    start_velocities = specification.start_velocities
    start_accelerations = specification.start_accelerations
    off = _off_start(motion, specification)
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


def ends_hold(motion: Motion, specification: Specification) -> bool:
    """Say whether all `end_checks` hold."""
    options, velocities = motion.options, motion.trajectory.velocities
    start_velocities = specification.start_velocities
    start_accelerations = specification.start_accelerations
    if not _off_start(motion, specification).max() <= options.start_error:
        return False
    if velocities is not None:
        begin = velocities[0] if start_velocities is None else velocities[0] - start_velocities
        ends = np.concatenate((begin, velocities[-1])) if motion.rests_after else begin
        if not np.abs(ends).max() <= options.rest_speed:
            return False
    if start_accelerations is None or not start_accelerations.any() or not motion.differentiable:
        return True
    # Twice the coefficient of the square of time, in the first piece.
    off = np.abs(2.0 * motion.position.coefficients[-3, 0] - start_accelerations).max()
    return bool(off <= options.start_acceleration_error)


def _off_start(motion: Motion, specification: Specification) -> Floats:
    """Return how far each joint of the group is from where it has to start, shape (n,) [rad | m]."""
    start = specification.start_positions
    return np.abs(
        motion.trajectory.positions[0] - (motion.reduced.start_positions if start is None else start)
    )


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
