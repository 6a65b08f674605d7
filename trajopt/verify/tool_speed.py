"""The judge's check of `ToolSpeed`: proven at all times, by bounds on how the velocity changes.

Over an interval of length h the velocity is within h / 2 of its middle's times a bound of its first
derivative, and within h^2 / 8 times a bound of its second derivative of the chord between its ends, on
which no velocity is larger than at one of the ends.
"""

import numpy as np

from trajopt.arrays import Floats
from trajopt.model.tool_speed import ToolSpeed
from trajopt.trajectory import Interpolation
from trajopt.verify.certificate import Check
from trajopt.verify.interval_proof import Excess, prove_over_time
from trajopt.verify.motion import Motion
from trajopt.verify.point_motion import PointMotion
from trajopt.verify.requirement import Component, When, requirement_check

KINDS = (("tool speed", "m/s"), ("tool turning", "rad/s"))


def tool_speed_checks(motion: Motion, limited: ToolSpeed) -> tuple[Check, ...]:
    """Judge the speeds of one tool.

    Args:
        motion: The motion.
        limited: The tool and its limits.

    Raises:
        FrameNotFound: If the frame is unknown.
    """
    moving = PointMotion(motion, limited.frame, offset=limited.offset)
    limits = (limited.linear, limited.angular)
    found = [_check(motion, moving, limited, which=which) for which in (0, 1) if np.isfinite(limits[which])]
    return tuple(found)


def _check(motion: Motion, moving: PointMotion, limited: ToolSpeed, *, which: int) -> Check:
    limit = (limited.linear, limited.angular)[which]
    smooth = motion.trajectory.interpolation is Interpolation.QUINTIC

    def speed(times: Floats) -> Floats:
        return np.linalg.norm(moving.speeds(times)[which], axis=1)

    def excess(begin: Floats, end: Floats) -> Excess:
        middle, length = (begin + end) / 2, end - begin
        changes = moving.changes(begin, end)
        if not smooth:  # the velocity at an end may be that of the next segment
            reached = speed(middle)
            return Excess(reached - limit, middle, reached + changes.first[:, which] * length / 2 - limit)
        times = np.stack((begin, middle, end))
        speeds = speed(times.ravel()).reshape(times.shape)
        chord = np.maximum(speeds[0], speeds[2]) + changes.second[:, which] * length**2 / 8
        bound = np.minimum(chord, speeds[1] + changes.first[:, which] * length / 2)
        worst, rows = speeds.argmax(axis=0), np.arange(len(begin))
        return Excess(speeds[worst, rows] - limit, times[worst, rows], bound - limit)

    proof = prove_over_time(motion, excess)
    kind, unit = KINDS[which]
    value = float(speed(np.array((proof.time,)))[0])
    component = Component(kind, value, limit)
    return requirement_check(
        When.ALWAYS, kind=kind, subject=limited.frame, unit=unit, component=component, proof=proof
    )
