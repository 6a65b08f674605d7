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
    needed, there = _changing(statement, arm, witness, pairs)
    needed = up(up(required + needed) + up(off * up(up(length * length) / 8.0)))
    least = up(needed * direction.norm().high)
    if _across_knots(statement, arm, witness, carriers[pairs]).any():
        yield "a leaf of a part that follows time reaches across a knot of its motion"
    for time in (witness.begin, witness.end):
        world = turned(arm.rotation[time, seen], direction)
        gap = -up(_supports(arm, first, time, world) + _supports(arm, second, time, -world))
        broken = np.flatnonzero(~(gap > least) & there)
        if len(broken):
            leaf = int(broken[0])
            one, other = (statement.parts[int(side[leaf])].owner for side in (first, second))
            span = f"from {arm.grid[witness.begin[leaf]]:.6g} to {arm.grid[witness.end[leaf]]:.6g} s"
            apart = f"{1000.0 * required[leaf]:g} mm"
            yield f"leaf {leaf}: it is not shown that {one} and {other} keep {apart} {span}"


def _changing(
    statement: Statement, arm: GridKinematics, witness: Witness, pairs: Rows
) -> tuple[Floats, NDArray[np.bool_]]:
    """Return the largest error of both parts in each leaf, (l,) [m], and whether both are there in it."""
    begin, end = arm.grid[witness.begin], arm.grid[witness.end]
    error, there = np.zeros(len(begin)), np.ones(len(begin), dtype=np.bool_)
    for change in statement.changes:
        mine = np.array([part.owner == change.owner for part in statement.parts])[pairs]
        r, v, a = change.error
        grown = up(up(r + up(v * end)) + up(a / 2.0 * up(end * end)))
        error = up(error + up(grown * mine.sum(axis=1)))
        there &= ~mine.any(axis=1) | ((end > change.appears) & (begin < change.expires))
    return error, there


def _across_knots(
    statement: Statement, arm: GridKinematics, witness: Witness, carriers: Rows
) -> NDArray[np.bool_]:
    """Return whether leaves reach across a time at which the velocity of a part may jump."""
    knots = np.unique(
        np.concatenate(
            [np.zeros(0), *(each.times[1:][np.diff(each.times) == 0.0] for each in statement.drives)]
        )
    )
    begin, end = arm.grid[witness.begin], arm.grid[witness.end]
    driven = _moved_by(statement, drives=True)[carriers].any(axis=1)
    return driven & (np.searchsorted(knots, begin, "right") < np.searchsorted(knots, end, "left"))


def _moved_by(statement: Statement, *, drives: bool) -> NDArray[np.bool_]:
    """Return which joints the robot's coordinates move, or those that follow time; the world is number 0."""
    own, moved = len(statement.curve.names), [False]
    for joint in statement.joints:
        moved.append(moved[joint.place.joint] or (joint.coordinate >= own) == drives)
    return np.array(moved)


def left_out(statement: Statement) -> Iterator[str]:
    """Yield faults: a pair of half-spaces, and a pair that the robot can move, neither listed nor excused."""
    parts = statement.parts
    planes = [isinstance(part.shape, HalfSpace) for part in parts]
    if any(planes[one] and planes[other] for one, other, _ in statement.pairs):
        yield "two half-spaces are a pair, which no direction separates"
    names = sorted({part.owner for part in parts})
    owner = np.array([names.index(part.owner) for part in parts], dtype=np.int64)
    joint = np.array([part.place.joint for part in parts], dtype=np.int64)
    robot = _moved_by(statement, drives=False)[joint]
    due = (owner[:, None] != owner) & (joint[:, None] != joint) & (robot[:, None] | robot)
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
