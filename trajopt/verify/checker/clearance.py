"""Clearance: every pair of parts that can move against each other keeps apart, but for those excused.

Over a leaf of length h a direction n that rests with the last joint that carries both parts separates them if
at both ends min n.y - max n.x > |n| (c + u h^2 / 8), for points x of the first part and y of the second, if c
is the clearance, and u bounds the accelerations of both as seen from that joint.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from intervals import Floats, Interval, dot, exactly, turned, up
from kinematics import GridKinematics, Rows, rotation_of
from numpy.typing import NDArray
from shapes import HalfSpace
from statement import ConvexPart, Statement
from witness import Witness


def check(statement: Statement, witness: Witness, arm: GridKinematics) -> Iterator[str]:
    """Yield faults, of which only the first counts: pairs that are left out, leaves that do not hold."""
    yield from left_out(statement)
    if not len(witness.pair):
        return
    carriers = np.array([part.place.joint for part in statement.parts])
    pairs = np.array([pair[:2] for pair in statement.pairs])[witness.pair]
    required = np.array([pair[2] for pair in statement.pairs])[witness.pair]
    first, second = pairs.T
    seen = arm.shared(carriers[first], carriers[second])
    direction = exactly(witness.direction)
    for side, sign in ((first, 1.0), (second, -1.0)):
        direction, moves = _along_planes(statement, direction, side, sign, seen)
        if moves:
            yield "a half-space moves, as seen from the other part of its pair"
    length = up(arm.grid[witness.end] - arm.grid[witness.begin])
    off = up(_accelerations(arm, witness, first, seen) + _accelerations(arm, witness, second, seen))
    least = up(up(required + up(off * up(up(length * length) / 8.0))) * direction.norm().high)
    for time in (witness.begin, witness.end):
        world = turned(arm.rotation[time, seen], direction)
        gap = -up(_supports(arm, first, time, world) + _supports(arm, second, time, -world))
        broken = np.flatnonzero(~(gap > least))
        if len(broken):
            leaf = int(broken[0])
            one, other = (statement.parts[int(side[leaf])].owner for side in (first, second))
            span = f"from {arm.grid[witness.begin[leaf]]:.6g} to {arm.grid[witness.end[leaf]]:.6g} s"
            apart = f"{1000.0 * required[leaf]:g} mm"
            yield f"leaf {leaf}: it is not shown that {one} and {other} keep {apart} {span}"


def left_out(statement: Statement) -> Iterator[str]:
    """Yield faults: a pair of half-spaces, and a pair that can move and is neither listed nor excused."""
    parts = statement.parts
    planes = [isinstance(part.shape, HalfSpace) for part in parts]
    if any(planes[one] and planes[other] for one, other, _ in statement.pairs):
        yield "two half-spaces are a pair, which no direction separates"
    names = sorted({part.owner for part in parts})
    owner = np.array([names.index(part.owner) for part in parts], dtype=np.int64)
    joint = np.array([part.place.joint for part in parts], dtype=np.int64)
    due = (owner[:, None] != owner) & (joint[:, None] != joint)
    for one, other, _ in statement.pairs:
        due[one, other] = due[other, one] = False
    excused = np.zeros((len(names), len(names)), dtype=np.bool_)
    for one, other, _ in statement.excused:
        places = [names.index(name) for name in (one, other) if name in names]
        excused[np.ix_(places, places)] = True
    for one, other in np.argwhere(due & ~excused[owner][:, owner])[:1].tolist():
        yield f"{parts[int(one)].owner} and {parts[int(other)].owner} are neither a pair nor excused"


def _along_planes(
    statement: Statement, direction: Interval, side: Rows, sign: float, seen: Rows
) -> tuple[Interval, bool]:
    low, high = direction.low.copy(), direction.high.copy()
    for part, rows in _by_part(statement, side):
        if isinstance(part.shape, HalfSpace):
            normal = rotation_of(part.place.rotation)[:, 2] * exactly(sign)
            low[rows], high[rows] = normal.low, normal.high
            if (seen[rows] != part.place.joint).any():
                return direction, True
    return Interval(low, high), False


def _by_part(statement: Statement, side: Rows) -> Iterator[tuple[ConvexPart, NDArray[np.bool_]]]:
    for number in np.unique(side):
        yield statement.parts[int(number)], side == number


def _accelerations(arm: GridKinematics, witness: Witness, side: Rows, seen: Rows) -> Floats:
    """Bound the accelerations of one side's parts in each leaf, as seen from joints, (l,) [m/s^2]."""
    found = np.zeros(len(side))
    for part, rows in _by_part(arm.statement, side):
        if part.place.joint == 0 or isinstance(part.shape, HalfSpace):
            continue
        centre, radius = part.shape.sphere
        turn, origin = arm.placed(part.place)
        middle = origin + turned(turn, exactly(centre))
        begin, end = witness.begin[rows], witness.end[rows]
        found[rows] = arm.travel(part.place.joint, middle, radius, begin, end, seen[rows]).acceleration
    return found


def _supports(arm: GridKinematics, side: Rows, time: Rows, direction: Interval) -> Floats:
    """Bound the support functions of one side's parts at times of the grid, (l,) [m]."""
    found = np.zeros(len(side))
    for part, rows in _by_part(arm.statement, side):
        place, towards = part.place, direction[rows]
        inward = turned(arm.rotation[time[rows], place.joint].transposed, towards)
        base = dot(towards, arm.translation[time[rows], place.joint])
        base = base + dot(inward, exactly(place.translation))
        if isinstance(part.shape, HalfSpace):
            found[rows] = base.high
            continue
        local = turned(rotation_of(place.rotation).transposed, inward)
        found[rows] = up(base.high + part.shape.support(local))
    return found
