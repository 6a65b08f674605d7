"""Rules: an axis of a frame points along a direction, at the end or at all times; a frame turns slowly."""

import numpy as np
from flint import arb
from intervals import dot, down, enclosed, exactly, normalised, turned, up
from kinematics import SAFE, GridKinematics
from reading import Fields, below, demand, direction, flag, record, size, text
from requirement import Bools, FrameView, StatedRequirement, off_chord, span
from statement import FixedPlace, Statement, place_in


def read(value: Fields, statement: Statement) -> StatedRequirement:
    """Read the rule of an axis: axis and direction are in the frames of the two joints."""
    joint, axis_of = below(len(statement.joints) + 1), direction(3, normalised)
    readers = {"kind": text, "frame": text, "joint": joint, "axis": axis_of, "reference": joint}
    _, name, carrier, axis, reference, along, tolerance, always = record(
        "axis alignment", value, {**readers, "direction": axis_of, "tolerance": size, "always": flag}
    )
    seen = FrameView(FixedPlace(carrier, exactly(np.eye(3)), exactly(np.zeros(3))), reference)
    angle = max(float(down(tolerance + statement.excess)), 0.0)
    demand(angle <= 3.14, "an axis must be aligned to within 3.14 rad")

    def holds(arm: GridKinematics) -> Bools:
        turn, _ = seen.placed(arm)
        inner = dot(turned(turn, axis), along).low
        least = enclosed(arb(angle).cos())[1]
        if not always:
            return inner[-1:] >= least
        return np.minimum(inner[:-1], inner[1:]) - off_chord(arm, seen.turning(arm)) - 1e-15 >= least

    one, other = (", ".join(f"{each:.6g}" for each in side.low.round(6) + 0.0) for side in (axis, along))
    words = f"{span(always)} axis ({one}) of {name}{seen.named(statement)} along ({other})"
    return StatedRequirement(f"{words}, within {tolerance:.6g} rad", holds)


def read_speed(value: Fields, statement: Statement) -> StatedRequirement:
    """Read the rule of an angular speed in the world.

    A joint that turns at a rate w with derivatives a and j takes the bounds v, u and k of the angular
    velocity behind it to v + w, u + w v + a and k + 2 w u + (w^2 + a) v + j.
    """
    readers = {"kind": text, "frame": text, "place": place_in(len(statement.joints)), "limit": size}
    _, name, place, limit = record("angular speed", value, readers)

    def holds(arm: GridKinematics) -> Bools:
        spin, v, u, k = exactly(np.zeros((len(arm.grid), 3))), *np.zeros((3, len(arm.grid) - 1))
        joint: int = place.joint
        while joint > 0:
            stated = statement.joints[joint - 1]
            w, a, j = (rate[:, joint] * stated.turns for rate in arm.rates)
            k, u, v = k + 2.0 * w * u + (w * w + a) * v + j, u + w * v + a, v + w
            rate = stated.followed(arm.motion.velocities)[:, None] * exactly(float(stated.turns))
            spin, joint = spin + arm.axis(joint) * rate, stated.place.joint
        speed = spin.norm().high
        most = up(np.maximum(speed[:-1], speed[1:]) + off_chord(arm, k * SAFE))
        return most <= down(limit + statement.excess)

    where = FrameView(place, 0).named(statement)
    return StatedRequirement(f"at all times {name}{where} turns at most at {limit:g} rad/s", holds)
