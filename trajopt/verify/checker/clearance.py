"""Clearance: every pair of parts that can move against each other keeps apart, unless excused.

Over a leaf of length h a direction n that rests with the last joint that carries both parts separates them if
at both ends min n.y - max n.x > |n| (c + u h^2 / 8), for points x of the first part and y of the second, with
the clearance c, and u the sum of bounds of both accelerations as seen from that joint.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from intervals import Floats, Interval, dot, exactly, joined, on_bounds, turned, up
from kinematics import GridKinematics, Rows
from numpy.typing import NDArray
from shapes import HalfSpace
from statement import ConvexPart, Statement
from witness import Witness


def check(statement: Statement, witness: Witness, arm: GridKinematics) -> Iterator[str]:
    """Yield faults: pairs that are left out, leaves that do not hold."""
    yield from _left_out(statement, arm)
    if not len(witness.pair):
        return
    pairs = np.array([pair[:2] for pair in statement.pairs])[witness.pair]
    required = np.array([pair[2] for pair in statement.pairs])[witness.pair]
    carriers = np.array([part.place.joint for part in statement.parts])[pairs]
    planes = np.array([isinstance(part.shape, HalfSpace) for part in statement.parts])[pairs]
    seen = arm.shared(*carriers.T)
    if planes.all(axis=1).any():
        yield "two half-spaces are a pair, which no direction separates"
    if (planes & (carriers != seen[:, None])).any():
        yield "a half-space moves, as seen from the other part of its pair"
    begin, end = arm.grid[witness.begin], arm.grid[witness.end]
    if (arm.driven[carriers].any(axis=1) & _across_knots(statement, begin, end)).any():
        yield "a leaf of a part that follows time reaches across a knot of its motion"
    normals = joined([part.place.rotation[:, 2] for part in statement.parts], 0)[pairs]
    direction = on_bounds(
        lambda bounds: np.select([planes[:, :1], planes[:, 1:]], bounds[:2], bounds[2]),
        [normals[:, 0], -normals[:, 1], exactly(witness.direction)],
    )
    error, there = _changing(statement, begin, end, pairs)
    length, off = up(end - begin), up(sum(_accelerations(arm, witness, side, seen) for side in pairs.T))
    needed = up(up(required + error) + up(off * up(up(length * length) / 8.0)))
    least = up(needed * direction.norm().high)
    for time in (witness.begin, witness.end):
        world = turned(arm.rotation[time, seen], direction)
        touch = up(_supports(arm, pairs[:, 0], time, world) + _supports(arm, pairs[:, 1], time, -world))
        for leaf in np.flatnonzero(~(-touch > least) & there)[:1]:
            one, other = (statement.parts[int(part)].owner for part in pairs[leaf])
            span = f"{1000.0 * required[leaf]:g} mm from {begin[leaf]:.6g} to {end[leaf]:.6g} s"
            yield f"leaf {leaf}: it is not shown that {one} and {other} keep {span}"


def _left_out(statement: Statement, arm: GridKinematics) -> Iterator[str]:
    """Yield pairs that the robot can move, but that are neither listed nor excused."""
    listed = {frozenset(pair[:2]) for pair in statement.pairs}
    excused = {frozenset(pair[:2]) for pair in statement.excused}
    moved = [(one, first) for one, first in enumerate(statement.parts) if arm.moved[first.place.joint]]
    for one, first in moved:
        for other, second in enumerate(statement.parts):
            owners, joints = frozenset((first.owner, second.owner)), (first.place.joint, second.place.joint)
            due = len(owners) == 2 and joints[0] != joints[1]
            if due and frozenset((one, other)) not in listed and owners not in excused:
                yield f"{first.owner} and {second.owner} are neither a pair nor excused"


def _changing(
    statement: Statement, begin: Floats, end: Floats, pairs: Rows
) -> tuple[Floats, NDArray[np.bool_]]:
    """Return the largest error of both parts in each leaf, (l,) [m], and whether they must keep apart."""
    error, there = np.zeros(len(begin)), np.ones(len(begin), dtype=np.bool_)
    for change in statement.changes:
        mine = np.array([part.owner == change.owner for part in statement.parts])[pairs]
        r, v, a = change.error
        grown = up(up(r + up(v * end)) + up(a / 2.0 * up(end * end)))
        error = up(error + up(grown * mine.sum(axis=1)))
        there &= ~mine.any(axis=1) | ((end > change.appears) & (begin < change.expires))
    owners = [part.owner for part in statement.parts]
    for one, other, since, until in statement.contacts:
        named = [{owners[int(first)], owners[int(second)]} == {one, other} for first, second in pairs]
        there &= ~np.array(named) | ((end > since) & (begin < until))
    return error, there


def _across_knots(statement: Statement, begin: Floats, end: Floats) -> NDArray[np.bool_]:
    """Return whether leaves reach across a knot of a drive, where velocities may jump."""
    knots = np.sort(np.concatenate([np.zeros(0), *(each.times for each in statement.drives)]))
    return np.searchsorted(knots, begin, "right") < np.searchsorted(knots, end, "left")


def _by_part(statement: Statement, side: Rows) -> Iterator[tuple[ConvexPart, NDArray[np.bool_]]]:
    for number in np.unique(side).tolist():
        yield statement.parts[number], side == number


def _accelerations(arm: GridKinematics, witness: Witness, side: Rows, seen: Rows) -> Floats:
    """Bound the accelerations of one side's parts in each leaf, as seen from joints, (l,) [m/s^2]."""
    found = np.zeros(len(side))
    for part, rows in _by_part(arm.statement, side):
        if part.place.joint == 0:
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
        base = dot(towards, arm.translation[time[rows], place.joint]) + dot(inward, place.translation)
        local = turned(place.rotation.transposed, inward)
        found[rows] = up(base.high + part.shape.support(local))
    return found
