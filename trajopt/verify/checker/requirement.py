"""A requirement as the kernel sees it, and the helpers of all rules."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from intervals import Floats, Interval, product, turned
from kinematics import SAFE, GridKinematics, PointTravel, Rows
from numpy.typing import NDArray
from statement import FixedPlace, Statement

Bools = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class StatedRequirement:
    """A requirement of a proof.

    Attributes:
        holds: Returns whether it is shown in each cell, shape (g - 1,); at the end, shape (1,).
    """

    words: str
    holds: Callable[[GridKinematics], Bools]


def span(always: bool) -> str:
    return "at all times" if always else "at the end"


@dataclass(frozen=True, eq=False)
class FrameView:
    """A frame as seen from a joint, or the world.

    Attributes:
        place: Its placement, in the frame of the joint that carries it.
    """

    place: FixedPlace
    reference: int

    def named(self, statement: Statement) -> str:
        names = ["the world", *(joint.name for joint in statement.joints)]
        seen = f", seen from {names[self.reference]}," if self.reference else ""
        return f" on {names[self.place.joint]}{seen}"

    def placed(self, arm: GridKinematics) -> tuple[Interval, Interval]:
        turn, origin = arm.placed(self.place)
        inward = arm.rotation[:, self.reference].transposed
        return product(inward, turn), turned(inward, origin - arm.translation[:, self.reference])

    def travel(self, arm: GridKinematics) -> PointTravel:
        begin, end, seen = self.cells(arm)
        return arm.travel(self.place.joint, arm.placed(self.place)[1], 0.0, begin, end, seen)

    def turning(self, arm: GridKinematics) -> Floats:
        """Bound the accelerations of unit vectors in each cell."""
        turns = np.array([False, *(joint.turns for joint in arm.statement.joints)])
        moves = turns & (arm.carried_by[self.place.joint] ^ arm.carried_by[self.reference])
        rate, increase = (each[:, moves].sum(axis=1) for each in arm.rates[:2])
        return (rate * rate + increase) * SAFE

    def cells(self, arm: GridKinematics) -> tuple[Rows, Rows, Rows]:
        begin = np.arange(len(arm.grid) - 1, dtype=np.int64)
        return begin, begin + 1, np.full(len(begin), self.reference, dtype=np.int64)


def off_chord(arm: GridKinematics, second: Floats) -> Floats:
    """Bound how far a function is from its chord in each cell, given a bound of its second derivative."""
    return second * np.diff(arm.grid) ** 2 / 8.0 * (1.0 + 1e-14)
