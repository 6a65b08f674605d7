"""Rule: the speed of a point in the world stays below a limit at all times."""

import numpy as np
from intervals import Interval, cross, down, exactly, up
from kinematics import GridKinematics
from reading import Fields, record, size, text
from requirement import Bools, FrameView, StatedRequirement, off_chord
from statement import Statement, place_in


def read(value: Fields, statement: Statement) -> StatedRequirement:
    """Read the rule."""
    readers = {"kind": text, "frame": text, "place": place_in(len(statement.joints)), "limit": size}
    _, name, place, limit = record("tool speed", value, readers)
    seen = FrameView(place, 0)

    def holds(arm: GridKinematics) -> Bools:
        speed = _velocity(arm, place.joint, arm.placed(place)[1]).norm().high
        travel = seen.travel(arm)
        if len(statement.curve.values) == 3:
            off = off_chord(arm, travel.jerk)
        else:  # a cubic's acceleration jumps, so its velocity is only known to be near an end
            off = travel.acceleration * np.diff(arm.grid) / 2.0 * (1.0 + 1e-14)
        return up(np.maximum(speed[:-1], speed[1:]) + off) <= down(limit + statement.excess)

    return StatedRequirement(f"at all times the speed of {name} is at most {limit:g} m/s", holds)


def _velocity(arm: GridKinematics, joint: int, point: Interval) -> Interval:
    """Return the velocity of a point that a joint carries at all times, shape (g, 3) [m/s]."""
    total = exactly(np.zeros_like(point.low))
    while joint > 0:
        stated = arm.statement.joints[joint - 1]
        rate = arm.motion.velocities[:, stated.coordinate, None] * exactly(stated.factor)
        axis = arm.axis(joint)
        along = cross(axis, point - arm.translation[:, joint]) if stated.turns else axis
        total, joint = total + along * rate, stated.place.joint
    return total
