"""Rules: joints are within ranges, at the end or at all times; the motion rests from a time on."""

import numpy as np
from intervals import exactly
from kinematics import GridKinematics
from reading import Fields, Reader, below, demand, every, flag, least, most, number, record, row, text
from requirement import Bools, StatedRequirement, span
from statement import StatedJoint, Statement


def joint_of(statement: Statement) -> Reader:
    def read(where: str, value: object) -> StatedJoint:
        number: int = below(len(statement.joints) + 1)(where, value)
        demand(number > 0, f"{where} must be a joint, and not the world")
        return statement.joints[number - 1]

    return read


def read(value: Fields, statement: Statement) -> StatedRequirement:
    """Read the rule."""
    ranges = row(joint_of(statement), least, most)
    readers = {"kind": text, "always": flag, "ranges": every(ranges)}
    _, always, rows = record("joint positions", value, readers)
    stated: list[tuple[StatedJoint, float, float]] = rows

    def holds(arm: GridKinematics) -> Bools:
        taken = arm.motion.bounds[0] if always else arm.motion.positions[-1:]
        within = np.ones(len(taken.low), dtype=np.bool_)
        for joint, low, high in stated:
            at = joint.followed(taken) + exactly(joint.offset)
            excess = exactly(statement.excess)
            lowest, highest = exactly(low) - excess, exactly(high) + excess
            within &= (at.low >= lowest.high) & (at.high <= highest.low)
        return within

    names = [f"{joint.name} in [{low:.6g}, {high:.6g}]" for joint, low, high in stated]
    return StatedRequirement(f"{span(always)} {', '.join(names)}", holds)


def read_rest(value: Fields, statement: Statement) -> StatedRequirement:
    """Read the rule of rest: it begins by a time; velocities are then as small as at the end."""
    _, since, by = record("rest", value, {"kind": text, "since": number, "by": most})

    def holds(arm: GridKinematics) -> Bools:
        velocities = arm.motion.bounds[1][:, : len(statement.motion.coordinates)].size
        rests = (velocities <= statement.ends.speed).all(axis=1) | (arm.grid[1:] <= since)
        return rests & statement.ends.rests & (since <= min(by, arm.grid[-1]))

    due = f", and by {by:g} s" if np.isfinite(by) else ""
    return StatedRequirement(f"the motion rests from {since:.6g} s on{due}", holds)
