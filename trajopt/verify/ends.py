"""The two ends of a motion: it starts where the robot is, and starts and ends at rest."""

import numpy as np

from trajopt.arrays import Floats
from trajopt.verify.certificate import Check, Evidence
from trajopt.verify.joint_unit import joint_unit
from trajopt.verify.motion import Motion


def end_checks(motion: Motion) -> tuple[Check, ...]:
    """Judge the start and, where the trajectory states velocities, rest at both ends."""
    off = np.abs(motion.trajectory.positions[0] - motion.reduced.start_positions)
    checks = [_check(motion, "start", off, time=0.0, bound=motion.options.start_error, order=0)]
    velocities = motion.trajectory.velocities
    if velocities is not None:
        for name, row, time in (
            ("start at rest", 0, 0.0),
            ("end at rest", -1, motion.duration),
        ):
            speeds = np.abs(velocities[row])
            rest = motion.options.rest_speed
            checks.append(_check(motion, name, speeds, time=time, bound=rest, order=1))
    return tuple(checks)


def _check(motion: Motion, name: str, sizes: Floats, *, time: float, bound: float, order: int) -> Check:
    joint = int(sizes.argmax())
    subject = motion.reduced.joint_names[joint]
    value = float(sizes[joint])
    return Check(
        name=name,
        subject=subject,
        value=value,
        bound=bound,
        unit=joint_unit(motion.reduced.scene.robot, subject, order=order),
        time=time,
        slack=bound - value,
        evidence=Evidence.PROVEN,
        holds=value <= bound,
        detail=f"{subject} is off by {value:.3g}" if order == 0 else f"{subject} moves at {value:.3g}",
    )
