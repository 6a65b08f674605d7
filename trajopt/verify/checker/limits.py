"""Limits of joints at all times, and the state at the ends."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from intervals import down, exactly, up
from kinematics import GridKinematics
from statement import StatedJoint, Statement

KINDS = ("lower", "upper", "velocity", "acceleration", "jerk")


def check(statement: Statement, arm: GridKinematics) -> Iterator[str]:
    """Yield faults: limits that joints may pass, and ends that are not as stated."""
    for joint in statement.joints:
        within = joint.followed(arm.motion.bounds[0]) + exactly(joint.offset)
        least = up(joint.lower - down(statement.excess * max(1.0, abs(joint.lower))))
        most = down(joint.upper + down(statement.excess * max(1.0, abs(joint.upper))))
        below = (within.low >= least) | (joint.lower == -np.inf)
        keeps = f"{joint.name} keeps its limit of "
        yield from arm.unshown(below & ((within.high <= most) | (joint.upper == np.inf)), keeps + "position")
        for order, limit in enumerate((joint.velocity, joint.acceleration, joint.jerk), start=1):
            if np.isfinite(limit):
                reached = arm.motion.bounds[order][:, joint.coordinate].size
                most = down(down(1.0 + statement.excess) * limit)
                yield from arm.unshown(up(reached * abs(joint.factor)) <= most, keeps + KINDS[1 + order])
        if np.isfinite(joint.jerk):
            yield from _jumps(statement, arm, joint)
    yield from _ends(statement, arm)


def _jumps(statement: Statement, arm: GridKinematics, joint: StatedJoint) -> Iterator[str]:
    """Yield a fault if the acceleration of a joint with a limit of jerk may jump, also at the ends."""
    starts, ends = (each[:, joint.coordinate] for each in arm.motion.accelerations)
    jumps = [starts[:1] - exactly(statement.ends.accelerations[[joint.coordinate]]), starts[1:] - ends[:-1]]
    jumps += [ends[-1:]] * statement.ends.rests
    jump = up(np.concatenate([each.size for each in jumps]) * abs(joint.factor))
    scale = joint.acceleration if np.isfinite(joint.acceleration) else joint.jerk
    if not (jump <= down(statement.excess * scale)).all():
        yield f"the acceleration of {joint.name} may jump, but its jerk is limited"


def _ends(statement: Statement, arm: GridKinematics) -> Iterator[str]:
    ends, motion, own = statement.ends, arm.motion, slice(len(statement.motion.coordinates))
    stated = [
        ("start where it must", motion.positions[0, own], ends.positions, ends.tolerance),
        ("start with the velocity that is stated", motion.velocities[0, own], ends.velocities, ends.speed),
    ]
    if ends.accelerations.any():
        start = motion.accelerations[0][0, own]
        stated += [("start with the acceleration that is stated", start, ends.accelerations, ends.speed)]
    if ends.rests:
        stated += [("end at rest", motion.velocities[-1, own], np.zeros(own.stop), ends.speed)]
    for words, found, at, tolerance in stated:
        if not ((found - exactly(at)).size <= tolerance).all():
            yield f"the motion does not {words}"
