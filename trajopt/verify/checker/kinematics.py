"""Forward kinematics, and bounds on how fast points move within intervals of time."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import intervals
import numpy as np
from intervals import Floats, Interval, cross, exactly, joined, product, turned, up
from motion import motion_on
from numpy.typing import NDArray
from series import Series, constant, sine_and_cosine_of
from statement import FixedPlace, StatedJoint, Statement

SAFE = 1.0 + 1e-11
"""Covers the rounding of sums and products of numbers that are not negative: each joint of a chain adds fewer
than 20 operations with a relative error of 1.2e-16, and there are at most 1,000 joints.
"""

Rows = NDArray[np.int64]


class PointTravel(NamedTuple):
    """Upper bounds of a point's speed [m/s], acceleration [m/s^2] and jerk [m/s^3], shape (m,) each."""

    velocity: Floats
    acceleration: Floats
    jerk: Floats


class GridKinematics:
    """A robot along its motion, at all times of a grid.

    Attributes:
        grid: The times, shape (g,) [s].
        rotation: Of the world's and each joint's frame at each time, shape (g, joints + 1, 3, 3).
        translation: Of their origins, shape (g, joints + 1, 3) [m].
        carried_by: Whether a joint (row) is, or hangs on, another (column); all hang on the world, number 0.
        driven: Whether a joint or the world follows time, (joints + 1,).
        moved: Likewise, whether the robot's coordinates move it.
        rates: Largest velocity, acceleration and jerk of each joint in each cell, (g - 1, joints + 1) each.
    """

    def __init__(self, statement: Statement, grid: Floats) -> None:
        self.statement, self.grid = statement, grid
        self.motion = motion_on(statement, grid)
        joints = statement.joints
        self.carried_by = np.zeros((len(joints) + 1,) * 2, dtype=np.bool_)
        self.carried_by[:, 0] = True
        for number, joint in enumerate(joints, start=1):
            self.carried_by[number] = self.carried_by[joint.place.joint]
            self.carried_by[number, number] = True
        sides = zip(*frames(joints, Series((self.motion.positions,))), strict=True)
        self.rotation, self.translation = (joined([each.terms[0] for each in side], 1) for side in sides)
        follows, own = [joint.coordinate for joint in joints], len(statement.motion.coordinates)
        by_time = np.array([False, *(coordinate >= own for coordinate in follows)])
        self.driven = np.any(self.carried_by & by_time, axis=1)
        self.moved = np.any((self.carried_by & ~by_time)[:, 1:], axis=1)
        factors = np.abs([joint.factor for joint in joints], dtype=np.float64)
        rates = [up(bound.size[:, follows] * factors) for bound in self.motion.bounds[1:4]]
        self.rates = tuple(np.pad(each, ((0, 0), (1, 0))) for each in rates)

    def unshown(self, holds: NDArray[np.bool_], words: str) -> Iterator[str]:
        """Yield a sentence for the first cell in which something does not hold, or the end if that is all."""
        for cell in np.flatnonzero(~holds)[:1].tolist():
            span = f" from {self.grid[cell]:.6g} to {self.grid[cell + 1]:.6g} s" if len(holds) > 1 else ""
            yield f"it is not shown that {words}{span}"

    def placed(self, place: FixedPlace) -> tuple[Interval, Interval]:
        turn, origin = self.rotation[:, place.joint], self.translation[:, place.joint]
        return product(turn, place.rotation), origin + turned(turn, place.translation)

    def shared(self, one: Rows, other: Rows) -> Rows:
        both = self.carried_by[one] & self.carried_by[other]
        return both.shape[1] - 1 - np.argmax(both[:, ::-1], axis=1)

    def travel(
        self, joint: int, centre: Interval, radius: float, begin: Rows, end: Rows, seen: Rows
    ) -> PointTravel:
        """Bound how the points of a sphere move, as seen from joints.

        With r the largest distance from the axis of a joint that turns, a point with velocity v, acceleration
        u and jerk k behind that joint has at most v + w r, u + 2 w v + (w^2 + a) r and
        k + 3 w u + 3 (a + w^2) v + (j + 3 w a + w^3) r before it. From the last joint that carries both, the
        joints towards the seeing one follow likewise.

        Args:
            centre: At all times, shape (g, 3) [m].
            begin: Place in the grid of the start of each of m intervals.
            seen: Reference joint of each interval.
        """
        half = up(self.grid[end] - self.grid[begin]) / 2.0
        fastest = [largest(rate, begin, end) for rate in self.rates]
        v, u, k = (np.zeros(len(begin)) for _ in range(3))
        carried, seeing = self.carried_by[joint], self.carried_by[seen]
        inward = [(number, carried[number] & ~seeing[:, number]) for number in range(len(carried) - 1, 0, -1)]
        outward = [(number, ~carried[number] & seeing[:, number]) for number in range(1, len(carried))]
        for number, moves in (*inward, *outward):
            if not moves.any():
                continue
            w, a, j = (rate[:, number] * moves for rate in fastest)
            if self.statement.joints[number - 1].turns:
                across = cross(centre - self.translation[:, number], self.axis(number))
                lever = up(across.norm().high + radius)
                r = np.maximum(lever[begin], lever[end]) + v * half
                k = k + 3.0 * w * u + 3.0 * (a + w * w) * v + (j + 3.0 * w * a + w * w * w) * r
                u = u + 2.0 * w * v + (w * w + a) * r
                v = v + w * r
            else:
                v, u, k = v + w, u + a, k + j
        return PointTravel(v * SAFE, u * SAFE, k * SAFE)

    def axis(self, joint: int) -> Interval:
        return turned(self.rotation[:, joint], self.statement.joints[joint - 1].axis)


def largest(values: Floats, begin: Rows, end: Rows) -> Floats:
    """Return the largest rows of values (g - 1, n) in cells from a begin to before an end, (m, n)."""
    sides = np.stack((begin, end), axis=1).ravel()
    return np.maximum.reduceat(np.pad(values, ((0, 1), (0, 0))), sides, axis=0)[::2]


def frames(joints: list[StatedJoint], positions: Series) -> list[tuple[Series, Series]]:
    """Return rotation and origin of the world's and each joint's frame: (m, 3, 3) and (m, 3) [m].

    A joint at q has the rotation A + B sin q + C cos q in its parent (Rodrigues).
    """
    count, terms = len(positions.terms[0].low), len(positions.terms)
    world = np.broadcast_to(np.eye(3), (count, 3, 3)), np.zeros((count, 3))
    found = [(constant(exactly(world[0]), terms), constant(exactly(world[1]), terms))]
    for joint in joints:
        turn, origin = found[joint.place.joint]
        fixed, at = joint.place.rotation, positions.map(joint.followed).plus(exactly(joint.offset))
        of_sine = product(fixed, intervals.skew(joint.axis * exactly(float(joint.turns))))
        of_cosine = -product(of_sine, intervals.skew(joint.axis))
        sine, cosine = sine_and_cosine_of(at)
        own = (sine.along(of_sine) + cosine.along(of_cosine)).plus(fixed - of_cosine)
        slide = turned(fixed, joint.axis * exactly(float(not joint.turns)))
        shift = at.along(slide).plus(joint.place.translation)
        found.append((turn.times(product, own), origin + turn.times(turned, shift)))
    return found
