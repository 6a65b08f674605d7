"""Limits of joints at all times, and the state at the ends."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from intervals import Floats, Interval, down, exactly, up
from kinematics import GridKinematics
from statement import StatedJoint, Statement

QUANTITIES = ("position", "velocity", "acceleration", "jerk")


def check(statement: Statement, arm: GridKinematics) -> Iterator[str]:
    """Yield faults: limits that joints may pass, and ends that are not as stated."""
    for joint in statement.joints:
        yield from _of_joint(statement, arm, joint)
    yield from _ends(statement, arm)


def _of_joint(statement: Statement, arm: GridKinematics, joint: StatedJoint) -> Iterator[str]:
    within = arm.motion.bounds[0][:, joint.coordinate] * exactly(joint.factor) + exactly(joint.offset)
    least = up(joint.lower - down(statement.excess * max(1.0, abs(joint.lower))))
    most = down(joint.upper + down(statement.excess * max(1.0, abs(joint.upper))))
    below = (within.low >= least) | (joint.lower == -np.inf)
    yield from _first(arm, below & ((within.high <= most) | (joint.upper == np.inf)), joint, 0)
    for order, limit in enumerate((joint.velocity, joint.acceleration, joint.jerk), start=1):
        if np.isfinite(limit):
            reached = arm.motion.bounds[order][:, joint.coordinate].size
            most = down(down(1.0 + statement.excess) * limit)
            yield from _first(arm, up(reached * abs(joint.factor)) <= most, joint, order)
    if np.isfinite(joint.jerk):
        yield from _jumps(statement, arm, joint)


def _first(arm: GridKinematics, holds: np.ndarray, joint: StatedJoint, order: int) -> Iterator[str]:
    for cell in np.flatnonzero(~holds)[:1].tolist():
        span = f"from {arm.grid[cell]:.6g} to {arm.grid[cell + 1]:.6g} s"
        yield f"it is not shown that {joint.name} keeps its limit of {QUANTITIES[order]} {span}"


def _jumps(statement: Statement, arm: GridKinematics, joint: StatedJoint) -> Iterator[str]:
    """Yield a fault if the acceleration of a joint with a limit of jerk may jump, also at the ends."""
    starts, ends = (each[:, joint.coordinate] for each in arm.motion.accelerations)
    before, after = exactly(statement.ends.accelerations[joint.coordinate]), exactly(0.0)
    low = np.concatenate(([before.low], ends.low)), np.append(starts.low, after.low)
    high = np.concatenate(([before.high], ends.high)), np.append(starts.high, after.high)
    jump = up((Interval(low[1], high[1]) - Interval(low[0], high[0])).size * abs(joint.factor))
    if not statement.ends.rests:
        jump = jump[:-1]
    scale = joint.acceleration if np.isfinite(joint.acceleration) else joint.jerk
    if not (jump <= down(statement.excess * scale)).all():
        yield f"the acceleration of {joint.name} may jump, but its jerk is limited"


def _ends(statement: Statement, arm: GridKinematics) -> Iterator[str]:
    ends, motion, own = statement.ends, arm.motion, slice(len(statement.curve.names))
    if not _within(motion.positions[0, own], ends.positions, ends.tolerance):
        yield "the motion does not start where it must"
    if not _within(motion.velocities[0, own], ends.velocities, ends.speed):
        yield "the motion does not start with the velocity that is stated"
    if ends.accelerations.any() and not _within(
        motion.accelerations[0][0, own], ends.accelerations, ends.speed
    ):
        yield "the motion does not start with the acceleration that is stated"
    if ends.rests and not _within(motion.velocities[-1, own], np.zeros_like(ends.velocities), ends.speed):
        yield "the motion does not end at rest"


def _within(found: Interval, stated: Floats, tolerance: float) -> bool:
    return bool(((found - exactly(stated)).size <= tolerance).all())
