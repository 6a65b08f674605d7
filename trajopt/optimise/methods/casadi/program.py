"""Transcription for CasADi: the program over knots, kinematics as expressions, contacts as callbacks."""

from dataclasses import dataclass, field

import casadi as ca
import numpy as np

from trajopt.optimise.methods.casadi.measured import (
    EverySample,
    MeasuredRows,
    NearestRows,
    SegmentEnds,
    links_of_pairs,
)
from trajopt.optimise.methods.casadi.nlpsol import CasadiProgram
from trajopt.optimise.terms.clearance import Clearance
from trajopt.optimise.terms.line_of_sight import SightClearance
from trajopt.optimise.terms.requirement import Exceeded, constrain
from trajopt.optimise.terms.singularity_distance import LostManipulability, SmallestSingularValue
from trajopt.optimise.terms.symbolic import Symbolic, SymbolicKinematics
from trajopt.optimise.terms.user_functions import FunctionResidual
from trajopt.optimise.transcription.knots import KnotsNlp
from trajopt.problem.motion import Motion
from trajopt.problem.requirements import PositionInRegion, Requirement
from trajopt.problem.residual import WHOLE, Constraint, Cost, Residual, Window
from trajopt.problem.smoothness import Acceleration, Jerk, Velocity
from trajopt.scene.reduced import ReducedModel
from trajopt.values.arrays import Bools, Floats, Ints, Loss
from trajopt.values.errors import shown


@dataclass(frozen=True, eq=False)
class Equalities:
    """Functions that must vanish, each of a stage.

    Attributes:
        value: Shape (e, 1).
        stage: Shape (e,).
    """

    value: ca.MX
    stage: Ints


class Plain:
    """The free knots are the variables, in order.

    Attributes:
        x: The variables, shape (v, 1).
        first: First ends of the segments, shape (n, N - 1).
        second: Second ends, shape (n, N - 1).
    """

    def __init__(self, lower: Floats, upper: Floats) -> None:
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
        return self._lower[self._moves].ravel(), self._upper[self._moves].ravel()

    @property
    def equalities(self) -> Equalities:
        return Equalities(ca.MX(0, 1), np.empty(0, dtype=np.int64))

    def differences(self, order: int) -> ca.MX:
        found = self._knots
        for _ in range(order):
            found = found[:, 1:] - found[:, :-1]
        return found

    def pack(self, knots: Floats) -> Floats:
        return knots[self._moves].ravel()

    def unpack(self, x: Floats) -> Floats:
        knots = self._lower.copy()
        knots[self._moves] = x.reshape(-1, knots.shape[1])
        return knots


class Staged:
    """A stage for each knot: its position, the differences before it, and the step to the next as control.

    q_{k+1} = q_k + u_k closes the gaps: the structure of optimal control, which a Riccati recursion solves.
    Source: Vanroye et al., FATROP, IROS 2023.
    """

    def __init__(self, lower: Floats, upper: Floats, order: int) -> None:
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
        count = len(self._lower)
        found: list[Floats] = []
        for bounds, without in ((self._lower, -np.inf), (self._upper, np.inf)):
            side = np.full((count, self._width), without)
            side[:, : self._joints] = np.where(self._lower < self._upper, bounds, without)
            found.append(side.ravel()[: self.x.shape[0]])
        return found[0], found[1]

    @property
    def equalities(self) -> Equalities:
        """Equalities between the variables."""
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
        columns: list[ca.MX] = []
        for stage in range(order - 1, len(self._lower) - 1):
            found = self._part(stage, self._order)
            for before in range(1, order):
                found = found - self._part(stage, before)
            columns.append(found)
        return ca.horzcat(*columns)

    def pack(self, knots: Floats) -> Floats:
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
        padded = np.append(x, np.zeros(self._joints))
        return padded.reshape(len(self._lower), self._width)[:, : self._joints]


ORDERS: dict[type, int] = {Velocity: 1, Acceleration: 2, Jerk: 3}
"""Costs of differences of the knots, and their order."""
SAMPLED = (FunctionResidual, SmallestSingularValue, LostManipulability, Exceeded)
"""Measured at every sample."""
NEAR = (Clearance, SightClearance)
"""Residuals measured near their bounds only."""


def objection(residual: Residual, reduced: ReducedModel) -> str:
    if isinstance(residual, Exceeded):
        required = residual.required
        union = isinstance(required, PositionInRegion) and len(required.members) > 1
        inner = (item.residual for item in constrain(required, reduced, WHOLE))
        known = not union and not any(objection(each, reduced) for each in inner)
    else:
        known = isinstance(residual, (*ORDERS, *SAMPLED, Symbolic))
    return "" if known else f"{shown(residual.name)} has no CasADi expression, and its rows may come and go"


def requirement_objection(required: Requirement, reduced: ReducedModel) -> str:
    residuals = (item.residual for item in constrain(required, reduced, WHOLE))
    found = (objection(each, reduced) for each in residuals if not isinstance(each, NEAR))
    return "; ".join(text for text in found if text)


@dataclass(eq=False)
class CasadiTranscription:
    """A program over knots in CasADi's form, on fixed samples; `callbacks` are kept alive with it."""

    nlp: KnotsNlp
    layout: Plain | Staged
    sampling: Ints
    callbacks: list[MeasuredRows] = field(default_factory=list[MeasuredRows])

    def program(self) -> CasadiProgram:
        writer = _Writer(self)
        for cost in self.nlp.problem.costs or ():
            writer.add_cost(cost)
        for item in self.nlp.constraints:
            writer.add_constraint(item)
        return writer.program()

    def pack(self, program: CasadiProgram, knots: Floats) -> Floats:
        """Return the variables for knots; slacks of costs with a kink are 0."""
        x = self.layout.pack(knots)
        return np.concatenate((x, np.zeros(program.x.shape[0] - len(x))))

    def raise_failure(self) -> None:
        for callback in self.callbacks:
            if callback.failure is not None:
                raise callback.failure

    def unpack(self, x: Floats) -> Floats:
        knots = self.layout.unpack(x[: self.layout.x.shape[0]])
        return np.clip(knots, self.nlp.lower, self.nlp.upper)


class _Writer:
    def __init__(self, given: CasadiTranscription) -> None:
        self._given, self._layout = given, given.layout
        nlp = given.nlp
        self._kinematics = SymbolicKinematics(nlp.query.reduced)
        self._last = len(nlp.lower) - 1
        motion = Motion.through(np.zeros_like(nlp.lower), given.sampling, nlp.query)
        segment = motion.support[:, 0]
        self._moves = np.any(nlp.lower < nlp.upper, axis=1)
        self._ends = SegmentEnds(segment, motion.weight[:, 1], self._last, nlp.query)
        self._objective = ca.MX(0.0)
        self._slacks: list[ca.MX] = []
        equal = self._layout.equalities
        nothing = np.zeros(len(equal.stage))
        self._values = [equal.value]
        self._sides = [(nothing, nothing)]
        self._stages = [equal.stage]
        self._elastic = [np.zeros(len(equal.stage), dtype=np.bool_)]

    def add_cost(self, cost: Cost) -> None:
        order = ORDERS.get(type(cost.residual))
        if order is not None:
            first = np.arange(self._last + 1 - order)
            kept = first[_inside(cost.window, first.astype(np.float64) + order / 2, self._last)]
            differences = self._layout.differences(order)[:, kept.tolist()]
            column, stage = ca.vec(differences), np.repeat(kept, differences.shape[0])
        else:
            column, stage = self._column(cost.residual, cost.window)
        if cost.loss is Loss.SQUARED:
            self._objective += cost.weight * ca.sumsqr(column)
            return
        slack = ca.MX.sym("slack", column.shape[0])
        self._slacks.append(slack)
        self._objective += cost.weight * ca.sum1(slack)
        self._add(column - slack, -np.inf, 0.0, stage, elastic=False)
        if cost.loss is Loss.ABSOLUTE:
            self._add(-column - slack, -np.inf, 0.0, stage, elastic=False)

    def add_constraint(self, item: Constraint) -> None:
        if isinstance(item.residual, NEAR):
            value, stage = self._nearest(item)
            self._add(value, 0.0, np.inf, stage)
            return
        value, stage = self._column(item.residual, item.window, constrained=True)
        dim = value.shape[0] // max(len(self._samples(item.window, constrained=True)), 1)
        lower, upper = (np.broadcast_to(side, (dim,)) for side in (item.lower, item.upper))
        kept = np.isfinite(lower) | np.isfinite(upper)
        count = value.shape[0] // max(dim, 1)
        rows = np.flatnonzero(np.tile(kept, count))
        self._add(value[rows.tolist()], np.tile(lower, count)[rows], np.tile(upper, count)[rows], stage[rows])

    def program(self) -> CasadiProgram:
        lower, upper = self._layout.bounds
        slacks = sum(slack.shape[0] for slack in self._slacks)
        stages = np.concatenate(self._stages)
        order = np.argsort(stages, kind="stable")
        least, most = (np.concatenate([sides[which] for sides in self._sides])[order] for which in (0, 1))
        return CasadiProgram(
            ca.vertcat(self._layout.x, *self._slacks),
            self._objective,
            ca.vertcat(*self._values)[order.tolist()],
            np.concatenate((lower, np.zeros(slacks))),
            np.concatenate((upper, np.full(slacks, np.inf))),
            least,
            most,
            np.concatenate(self._elastic)[order],
        )

    def _add(
        self,
        value: ca.MX,
        lower: float | Floats,
        upper: float | Floats,
        stage: Ints,
        *,
        elastic: bool = True,
    ) -> None:
        size = value.shape[0]
        self._elastic.append(np.full(size, elastic))
        self._values.append(value)
        self._sides.append((np.array(np.broadcast_to(lower, size)), np.array(np.broadcast_to(upper, size))))
        self._stages.append(stage)

    def _samples(self, window: Window, *, constrained: bool) -> Ints:
        inside = _inside(window, self._ends.place, self._last)
        return np.flatnonzero(inside & self._movable()) if constrained else np.flatnonzero(inside)

    def _movable(self) -> Bools:
        ends, fraction = self._ends, self._ends.fraction
        first, second = self._moves[ends.segment], self._moves[ends.segment + 1]
        return (first & (fraction < 1.0)) | (second & (fraction > 0.0))

    def _column(self, residual: Residual, window: Window, *, constrained: bool = False) -> tuple[ca.MX, Ints]:
        samples = self._samples(window, constrained=constrained)
        if not isinstance(residual, Symbolic):
            return self._at_every_sample(residual, samples)
        symbolic = residual.expression(self._kinematics)
        function = ca.Function("residual", [self._kinematics.q], [symbolic])
        if len(samples) == 0:
            return ca.MX(0, 1), np.empty(0, dtype=np.int64)
        values = function.map(len(samples))(self._positions(samples))
        return ca.vec(values), np.repeat(self._ends.segment[samples], symbolic.shape[0])

    def _positions(self, samples: Ints) -> ca.MX:
        segment = self._ends.segment[samples].tolist()
        fraction = ca.MX(self._ends.fraction[samples]).T
        first, second = self._layout.first[:, segment], self._layout.second[:, segment]
        joints = first.shape[0]
        share = ca.MX(np.ones(joints)) @ fraction
        return first + share * (second - first)

    def _at_every_sample(self, residual: Residual, samples: Ints) -> tuple[ca.MX, Ints]:
        nlp, ends = self._given.nlp, self._ends
        taken = SegmentEnds(ends.segment[samples], ends.fraction[samples], ends.segments, ends.query)
        probe = residual.linearise(Motion.each(nlp.query.reduced.start_positions[None], nlp.query))
        components = int(probe.component.max(initial=-1)) + 1
        segment = np.repeat(taken.segment, components)
        slots = EverySample(residual, components, segment, taken.place)
        return self._measured(taken, slots), segment

    def _nearest(self, item: Constraint) -> tuple[ca.MX, Ints]:
        link = np.empty(0, dtype=np.int64)
        links = 1
        if isinstance(item.residual, Clearance):
            link = np.unique(links_of_pairs(self._given.nlp.query.reduced), return_inverse=True)[1]
            links = int(link.max(initial=0)) + 1
        samples = self._samples(item.window, constrained=True)
        ends = self._ends
        taken = SegmentEnds(ends.segment[samples], ends.fraction[samples], ends.segments, ends.query)
        slots = NearestRows(item, link, links, self._last)
        return self._measured(taken, slots), slots.segment

    def _measured(self, ends: SegmentEnds, slots: EverySample | NearestRows) -> ca.MX:
        callback = MeasuredRows(ends, slots)
        self._given.callbacks.append(callback)
        joined = ca.vertcat(self._layout.first, self._layout.second)
        return callback(ca.vec(joined))


def _inside(window: Window, place: Floats, last: int) -> Bools:
    return (place >= window.first * last - 1e-9) & (place <= window.last * last + 1e-9)


def plainly(nlp: KnotsNlp, sampling: Ints) -> CasadiTranscription:
    return CasadiTranscription(nlp, Plain(nlp.lower, nlp.upper), sampling)


def by_stages(nlp: KnotsNlp, sampling: Ints) -> CasadiTranscription:
    orders = [ORDERS.get(type(cost.residual), 1) for cost in nlp.problem.costs or ()]
    return CasadiTranscription(nlp, Staged(nlp.lower, nlp.upper, max(orders, default=1)), sampling)
