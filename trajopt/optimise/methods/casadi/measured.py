"""Measured rows as a CasADi function with a sparse Jacobian.

Measured rows fill a fixed number of slots: one for each component and sample of a permanent row, or a few for
the rows nearest to their bound, in each segment and for each link. Their Hessian is the Gauss-Newton
approximation.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import casadi as ca
import numpy as np
from scipy.sparse import csc_matrix

from trajopt.geometry import Evaluator
from trajopt.problem.motion import Motion
from trajopt.problem.residual import Constraint, Residual
from trajopt.scene.reduced import ReducedModel
from trajopt.values.arrays import Floats, Ints
from trajopt.values.errors import ProblemError, shown

NEAREST = 6
"""Rows kept of each link in each segment, nearest first."""
FAR = 0.1
"""Value of an empty slot, and the largest value of a nearest row."""


@dataclass(frozen=True, eq=False)
class SegmentEnds:
    """The samples of a motion between the ends of its segments, which need not meet.

    Attributes:
        segment: Of each sample, shape (S,).
        fraction: In it, shape (S,).
    """

    segment: Ints
    fraction: Floats
    segments: int
    query: Evaluator

    @property
    def place(self) -> Floats:
        return self.segment + self.fraction

    def motion(self, ends: Floats) -> Motion:
        """Return the samples for ends of shape (N - 1, 2, n); knot 2 k + e is end e of segment k."""
        weight = np.stack((1.0 - self.fraction, self.fraction), axis=1)
        support = np.stack((2 * self.segment, 2 * self.segment + 1), axis=1)
        positions = np.einsum("se,sen->sn", weight, ends[self.segment])
        knots = ends.reshape(-1, ends.shape[2])
        return Motion(knots, support, weight, self.place, positions, self.query)


@dataclass(frozen=True, eq=False)
class Filled:
    """Rows and their slots; values are turned so that they must lie between the bounds."""

    slot: Ints
    value: Floats
    jacobian: Floats


class Slots(Protocol):
    """Assigns slots to measured rows."""

    @property
    def segment(self) -> Ints:
        """The segment that each slot is of."""
        ...

    @property
    def empty(self) -> float:
        """Value of empty slots."""
        ...

    def fill(self, motion: Motion) -> Filled:
        """Measure and put in place."""
        ...


@dataclass(frozen=True, eq=False)
class EverySample:
    """One slot for each component at each sample.

    Attributes:
        place: Of each sample, increasing.
    """

    residual: Residual
    components: int
    segment: Ints
    place: Floats
    empty: float = 0.0

    def fill(self, motion: Motion) -> Filled:
        rows = self.residual.linearise(motion)
        sample = np.searchsorted(self.place, rows.place - 1e-9)
        slot = sample * self.components + rows.component
        if len(np.unique(slot)) != len(self.segment):
            raise ProblemError(
                f"{shown(self.residual.name)}: its rows come and go; it has no place in this program"
            )
        return Filled(slot, rows.value, rows.jacobian)


@dataclass(frozen=True, eq=False)
class NearestRows:
    """`NEAREST` slots for each link in each segment, for the rows nearest to their one bound.

    Their values are distances inside the bound.

    Attributes:
        link: Of each component, shape (p,); all one link when empty.
    """

    item: Constraint
    link: Ints
    links: int
    segments: int
    empty: float = FAR

    @property
    def segment(self) -> Ints:
        return np.repeat(np.arange(self.segments, dtype=np.int64), self.links * NEAREST)

    def fill(self, motion: Motion) -> Filled:
        rows = self.item.residual.linearise(motion)
        lower, upper = self.item.bounds(rows)
        rising = np.isfinite(lower)
        room = np.where(rising, rows.value - lower, upper - rows.value)
        group = rows.knots[:, 0] // 2 * self.links
        if len(self.link):
            group = group + self.link[rows.component]
        order = np.lexsort((room, group))
        first = np.searchsorted(group[order], group[order])
        rank = np.arange(len(order)) - first
        kept = (rank < NEAREST) & (room[order] < FAR)
        chosen = order[kept]
        sign = np.where(rising[chosen], 1.0, -1.0)[:, None, None]
        return Filled(group[chosen] * NEAREST + rank[kept], room[chosen], sign * rows.jacobian[chosen])


def links_of_pairs(reduced: ReducedModel) -> Ints:
    joint = np.array([reduced.attachment(body.owner)[0] for body in reduced.bodies], dtype=np.int64)
    pairs = reduced.pairs
    return np.maximum(joint[pairs.first], joint[pairs.second])


class MeasuredRows(ca.Callback):
    """The slots' values as a function of the ends of all segments, (2 n, N - 1) column by column.

    Keep a reference while the program is in use.

    Attributes:
        failure: Exception raised by a user's function, if any.
    """

    def __init__(self, ends: SegmentEnds, slots: Slots) -> None:
        super().__init__()
        self._ends, self._slots = ends, slots
        self.segment = slots.segment
        joints = len(ends.query.reduced.joint_names)
        self._shape = (ends.segments, 2, joints)
        self._width = 2 * joints
        count = len(self.segment)
        columns = self.segment[:, None] * self._width + np.arange(self._width)
        pattern = csc_matrix(
            (
                np.arange(columns.size, dtype=np.float64),
                (np.repeat(np.arange(count), self._width), columns.ravel()),
            ),
            shape=(count, self._shape[0] * self._width),
        )
        row, column = (
            pattern.indices.tolist(),
            np.repeat(np.arange(pattern.shape[1]), np.diff(pattern.indptr)),
        )
        self.pattern = ca.Sparsity.triplet(*pattern.shape, row, column.tolist())
        self._order = pattern.data.astype(np.int64)
        self._at: Floats | None = None
        self._found = (np.empty(0), np.empty(0))
        self.failure: Exception | None = None
        self.construct("measured", {})
        self._slope = _Slope(self)

    def values(self, x: ca.DM) -> tuple[Floats, Floats]:
        """Return the slots' values and the nonzeros of their Jacobian, measured once for a point."""
        at = x.full().ravel()
        if self._at is None or not np.array_equal(self._at, at):
            try:
                filled = self._slots.fill(self._ends.motion(at.reshape(self._shape)))
            except Exception as failure:  # ipopt takes any error for a point that it should not have tried
                self.failure = failure
                raise
            value = np.full(len(self.segment), self._slots.empty)
            value[filled.slot] = filled.value
            slope = np.zeros((len(self.segment), self._width))
            slope[filled.slot] = filled.jacobian.reshape(-1, self._width)
            self._at, self._found = at, (value, slope.ravel()[self._order])
        return self._found

    def get_n_in(self) -> int:
        return 1

    def get_n_out(self) -> int:
        return 1

    def get_sparsity_in(self, index: int) -> ca.Sparsity:
        return ca.Sparsity.dense(self._shape[0] * self._width, 1)

    def get_sparsity_out(self, index: int) -> ca.Sparsity:
        return ca.Sparsity.dense(len(self.segment), 1)

    def eval(self, arguments: Sequence[ca.DM]) -> list[ca.DM]:
        return [ca.DM(self.values(arguments[0])[0])]

    def has_jacobian(self) -> bool:
        return True

    def get_jacobian(
        self, name: str, inputs: Sequence[str], outputs: Sequence[str], options: object
    ) -> ca.Function:
        return self._slope

    def has_jac_sparsity(self, output: int, into: int) -> bool:
        return True

    def get_jac_sparsity(self, output: int, into: int, symmetric: bool) -> ca.Sparsity:
        return self.pattern


class _Slope(ca.Callback):
    """The Jacobian of measured slots; its own derivative is taken as zero."""

    def __init__(self, of: MeasuredRows) -> None:
        super().__init__()
        self._of = of
        self._inputs = of.get_sparsity_in(0).size1()
        self._outputs = len(of.segment)
        self.construct("slope", {})

    def get_n_in(self) -> int:
        return 2

    def get_n_out(self) -> int:
        return 1

    def get_sparsity_in(self, index: int) -> ca.Sparsity:
        return ca.Sparsity.dense(self._inputs, 1) if index == 0 else ca.Sparsity(self._outputs, 1)

    def get_sparsity_out(self, index: int) -> ca.Sparsity:
        return self._of.pattern

    def eval(self, arguments: Sequence[ca.DM]) -> list[ca.DM]:
        return [ca.DM(self._of.pattern, self._of.values(arguments[0])[1])]

    def has_jacobian(self) -> bool:
        return True

    def get_jacobian(
        self, name: str, inputs: Sequence[str], outputs: Sequence[str], options: object
    ) -> ca.Function:
        size = self._inputs * self._outputs
        given = [
            ca.MX.sym("x", self._inputs),
            ca.MX.sym("y", ca.Sparsity(self._outputs, 1)),
            ca.MX.sym("J", ca.Sparsity(self._outputs, self._inputs)),
        ]
        return ca.Function(
            name, given, [ca.MX(size, self._inputs), ca.MX(size, self._outputs)], list(inputs), list(outputs)
        )

    def has_jac_sparsity(self, output: int, into: int) -> bool:
        return True

    def get_jac_sparsity(self, output: int, into: int, symmetric: bool) -> ca.Sparsity:
        rows = self._of.pattern.nnz() if symmetric else self._inputs * self._outputs
        return ca.Sparsity(rows, self._inputs if into == 0 else self._outputs)
