"""Which limits decide how fast a motion is."""

from collections.abc import Mapping

import numpy as np

from trajopt.model.trajectory import Trajectory
from trajopt.retime.course import Course
from trajopt.retime.peaks import Peaks, factors

BINDS = 0.97
"""Part of its speed to which a limit must hold a piece of the motion to count as the one that decides."""


def binding(course: Course, peaks: Peaks, *, measured: Trajectory, final: Trajectory) -> Mapping[str, float]:
    """Say for which part of its duration each kind of limit decides how fast a motion is.

    Args:
        course: The path on the grid of the trajectory.
        peaks: What was measured.
        measured: The trajectory of which it was.
        final: The same, stretched uniformly.

    Returns:
        Kind of limit -> part of the duration, the largest first; those that never decide are left out.
    """
    used = factors(course, peaks) * (measured.duration / final.duration)
    joints, speeds, rows = course.dq.shape[1], course.slope.shape[1], peaks.low.shape[1]
    kinds = np.array(
        ["velocity"] * joints
        + ["tool speed"] * (speeds - joints)
        + ["acceleration"] * joints
        + ["torque"] * (rows - joints)
        + ["jerk"] * (used.shape[1] - speeds - rows)
    )
    decides, share = kinds[used.argmax(axis=1)], np.diff(final.times) / final.duration
    bound = used.max(axis=1) >= BINDS
    parts = {str(kind): float(share[bound & (decides == kind)].sum()) for kind in dict.fromkeys(kinds)}
    return {kind: part for kind, part in sorted(parts.items(), key=lambda item: -item[1]) if part > 0.0}
