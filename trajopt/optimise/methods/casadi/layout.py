"""How knots are laid out as variables of CasADi: plainly, or stage by stage as in optimal control."""

from dataclasses import dataclass
from typing import Protocol

import casadi as ca
import numpy as np

from trajopt.values.arrays import Bools, Floats, Ints


@dataclass(frozen=True, eq=False)
class Equalities:
    """Functions that must vanish, each of a stage.

    Attributes:
        value: Shape (e, 1).
        stage: Shape (e,).
    """

    value: ca.MX
    stage: Ints


class KnotLayout(Protocol):
    """Variables from which the ends of all segments follow."""

    @property
    def x(self) -> ca.MX:
        """The variables, shape (v, 1)."""
        ...

    @property
    def first(self) -> ca.MX:
        """First ends of the segments, shape (n, N - 1)."""
        ...

    @property
    def second(self) -> ca.MX:
        """Second ends, shape (n, N - 1)."""
        ...

    @property
    def bounds(self) -> tuple[Floats, Floats]:
        """Lower and upper bounds of the variables, shape (v,)."""
        ...

    @property
    def equalities(self) -> Equalities:
        """Equalities between the variables."""
        ...

    def differences(self, order: int) -> ca.MX:
        """Differences of the knots, shape (n, N - order)."""
        ...

    def pack(self, knots: Floats) -> Floats:
        """Return the variables for knots of shape (N, n)."""
        ...

    def unpack(self, x: Floats) -> Floats:
        """Return the knots, shape (N, n)."""
        ...


class Plain:
    """The free knots are the variables, one after the other."""

    def __init__(self, lower: Floats, upper: Floats) -> None:
        """Lay them out.

        Args:
            lower: Lower bounds of the knots, shape (N, n); equal to upper for fixed ones.
            upper: Upper bounds.
        """
        self._lower, self._upper = lower, upper
        self._moves: Bools = np.any(lower < upper, axis=1)
        joints = lower.shape[1]
        self.x = ca.MX.sym("x", int(self._moves.sum()) * joints)
        columns: list[ca.MX] = []
        at = 0
        for moves, value in zip(self._moves, lower, strict=True):
            columns.append(self.x[at : at + joints] if moves else ca.MX(value))
            at += joints * bool(moves)
        self._knots = ca.horzcat(*columns)
        self.first, self.second = self._knots[:, :-1], self._knots[:, 1:]

    @property
    def bounds(self) -> tuple[Floats, Floats]:
        """Lower and upper bounds of the variables."""
        return self._lower[self._moves].ravel(), self._upper[self._moves].ravel()

    @property
    def equalities(self) -> Equalities:
        """None."""
        return Equalities(ca.MX(0, 1), np.empty(0, dtype=np.int64))

    def differences(self, order: int) -> ca.MX:
        """Differences of the knots."""
        found = self._knots
        for _ in range(order):
            found = found[:, 1:] - found[:, :-1]
        return found

    def pack(self, knots: Floats) -> Floats:
        """Leave the fixed ones out."""
        return knots[self._moves].ravel()

    def unpack(self, x: Floats) -> Floats:
        """Put the fixed ones back."""
        knots = self._lower.copy()
        knots[self._moves] = x.reshape(-1, knots.shape[1])
        return knots


class Staged:
    """A stage for each knot: its position, the differences before it, and the step to the next as control.

    Every row and cost then is of one stage, and q_{k+1} = q_k + u_k closes the gaps: the structure of
    optimal control, which a Riccati recursion solves. Source: Vanroye et al., FATROP, IROS 2023.
    """

    def __init__(self, lower: Floats, upper: Floats, order: int) -> None:
        """Lay the stages out.

        Args:
            lower: Lower bounds of the knots, shape (N, n); equal to upper for fixed ones.
            upper: Upper bounds.
            order: Highest order of the differences in the costs, 1 to 3.
        """
        self._lower, self._upper, self._order = lower, upper, order
        count, joints = lower.shape
        self._joints, self._width = joints, (order + 1) * joints
        self.x = ca.MX.sym("x", count * order * joints + (count - 1) * joints)
        position = [self._part(stage, 0) for stage in range(count - 1)]
        self.first = ca.horzcat(*position)
        self.second = ca.horzcat(*(start + self._part(stage, order) for stage, start in enumerate(position)))

    def _part(self, stage: int, part: int) -> ca.MX:
        """Part 0 is the position, 1 ... order - 1 the differences before it, order the control."""
        begin = stage * self._width + part * self._joints
        return self.x[begin : begin + self._joints]

    @property
    def bounds(self) -> tuple[Floats, Floats]:
        """Bounds of the free positions; fixed ones are equalities."""
        count = len(self._lower)
        found: list[Floats] = []
        for bounds, without in ((self._lower, -np.inf), (self._upper, np.inf)):
            side = np.full((count, self._width), without)
            side[:, : self._joints] = np.where(self._lower < self._upper, bounds, without)
            found.append(side.ravel()[: self.x.shape[0]])
        return found[0], found[1]

    @property
    def equalities(self) -> Equalities:
        """Gaps between the stages, and fixed positions."""
        values: list[ca.MX] = []
        stages: list[int] = []
        for stage in range(len(self._lower) - 1):
            step = self._part(stage, self._order)
            values.append(self._part(stage + 1, 0) - self._part(stage, 0) - step)
            for order in range(1, self._order):
                values.append(self._part(stage + 1, order) - step)
                if order + 1 < self._order:
                    step = step - self._part(stage, order)
            stages += [stage] * (self._order * self._joints)
        values_fixed, stages_fixed = self._fixed()
        return Equalities(ca.vertcat(*values, *values_fixed), np.array(stages + stages_fixed, dtype=np.int64))

    def _fixed(self) -> tuple[list[ca.MX], list[int]]:
        values: list[ca.MX] = []
        stages: list[int] = []
        for stage, (low, high) in enumerate(zip(self._lower, self._upper, strict=True)):
            held = np.flatnonzero(low == high).tolist()
            if held:
                values.append(self._part(stage, 0)[held] - ca.MX(low[held]))
                stages += [stage] * len(held)
        for order in range(1, self._order):  # nothing is before the first knot
            values.append(self._part(0, order))
            stages += [0] * self._joints
        return values, stages

    def differences(self, order: int) -> ca.MX:
        """Differences of the knots, each of a stage's own variables."""
        columns: list[ca.MX] = []
        for stage in range(order - 1, len(self._lower) - 1):
            found = self._part(stage, self._order)
            for before in range(1, order):
                found = found - self._part(stage, before)
            columns.append(found)
        return ca.horzcat(*columns)

    def pack(self, knots: Floats) -> Floats:
        """Lay out positions, differences before and controls."""
        count, joints = knots.shape
        stages = np.zeros((count, self._order + 1, joints))
        stages[:, 0] = knots
        before = knots
        for order in range(1, self._order):
            before = np.diff(before, axis=0)
            stages[order:, order] = before
        stages[:-1, self._order] = np.diff(knots, axis=0)
        return stages.ravel()[: self.x.shape[0]]

    def unpack(self, x: Floats) -> Floats:
        """Return the positions."""
        padded = np.append(x, np.zeros(self._joints))
        return padded.reshape(len(self._lower), self._width)[:, : self._joints]
