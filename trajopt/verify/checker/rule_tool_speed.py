"""Rules: the speed of a point in the world stays below a limit at all times; it is steady for a time."""

import numpy as np
from intervals import Floats, Interval, cross, dot, down, exactly, up
from kinematics import SAFE, GridKinematics
from reading import Fields, number, record, size, text
from requirement import Bools, FrameView, StatedRequirement, off_chord
from statement import FixedPlace, Statement, place_in


def read(value: Fields, statement: Statement) -> StatedRequirement:
    """Read the rule of a limit."""
    readers = {"kind": text, "frame": text, "place": place_in(len(statement.joints)), "limit": size}
    _, name, place, limit = record("tool speed", value, readers)

    def holds(arm: GridKinematics) -> Bools:
        return _fastest(arm, place) <= down(limit + statement.excess)

    where = FrameView(place, 0).named(statement)
    return StatedRequirement(f"at all times the speed of {name}{where} is at most {limit:g} m/s", holds)


def read_steady(value: Fields, statement: Statement) -> StatedRequirement:
    """Read the rule of a steady speed: at least so fast between two times, over at least half of the way.

    Along the direction n of its middle, a velocity is at least the smaller one of the ends less its distance
    from the chord.
    """
    readers = {"kind": text, "frame": text, "place": place_in(len(statement.joints))}
    _, name, place, least, since, until = record(
        "steady speed", value, {**readers, "least": size, "since": number, "until": number}
    )

    def holds(arm: GridKinematics) -> Bools:
        inside = (arm.grid[:-1] >= since) & (arm.grid[1:] <= until)
        velocity = _velocity(arm, place.joint, arm.placed(place)[1])
        middle = velocity.low[:-1] + velocity.low[1:]
        length = exactly(middle).norm().high
        along = [dot(velocity[side], exactly(middle)).low for side in (slice(-1), slice(1, None))]
        slowest = down(down(np.minimum(*along) / length) - _off_chord(arm, place))
        reached, span = slowest >= max(least - statement.excess, 0.0), np.diff(arm.grid)
        outside = (_fastest(arm, place) * span)[~inside].sum() * SAFE
        return (reached | ~inside) & (outside <= (slowest * span)[inside & reached].sum() / SAFE)

    words = f"from {since:.6g} to {until:.6g} s, over half of the way or more, the speed of {name}"
    words += FrameView(place, 0).named(statement)
    return StatedRequirement(f"{words} is at least {least:g} m/s", holds)


def _fastest(arm: GridKinematics, place: FixedPlace) -> Floats:
    speed = _velocity(arm, place.joint, arm.placed(place)[1]).norm().high
    return up(np.maximum(speed[:-1], speed[1:]) + _off_chord(arm, place))


def _off_chord(arm: GridKinematics, place: FixedPlace) -> Floats:
    travel = FrameView(place, 0).travel(arm)
    if len(arm.statement.motion.values) == 3:
        return off_chord(arm, travel.jerk)
    # A cubic's acceleration jumps, so its velocity is only known to be near an end.
    return travel.acceleration * np.diff(arm.grid) / 2.0 * (1.0 + 1e-14)


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
