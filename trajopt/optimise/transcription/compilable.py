"""Programs over the samples of a curve in parts for the core.

Terms without a formula in the core are evaluated in Python at every point; a term of another package makes
Python evaluate the whole program.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from trajopt.geometry import Query
from trajopt.native import descent
from trajopt.optimise.nlp import ConstraintRows, CostRows
from trajopt.optimise.solvers.parts import (
    Block,
    ChangingDistancePart,
    CompiledProgram,
    DistancePart,
    FramePart,
    LinearPart,
    Part,
    PythonPart,
    Samples,
    Taper,
    TorquePart,
)
from trajopt.optimise.terms.alignment import AxisAngle, ViewAngle, ViewDistance
from trajopt.optimise.terms.clearance import Clearance, SoftClearance
from trajopt.optimise.terms.frame_placement import CurveError, FramePlacementError
from trajopt.optimise.terms.gravity_torque import GravityShare, HoldingTorque
from trajopt.optimise.terms.joint_positions import JointPosition, JointSum, RestPosture, Rolling
from trajopt.optimise.terms.line_of_sight import SightClearance
from trajopt.optimise.terms.positions import ArcCoordinates, PointDistance, RegionCoordinates
from trajopt.optimise.terms.singularity_distance import LostManipulability, SmallestSingularValue
from trajopt.optimise.terms.user_functions import Expression, FunctionResidual
from trajopt.optimise.transcription.margins import (
    ShrunkMargins,
    TaperedConstraint,
    TaperedMargins,
    shrinkable,
)
from trajopt.optimise.transcription.motion_nlp import MotionNlp
from trajopt.optimise.transcription.spline_terms import ClearanceInTime, SplineRate, SplineTorque
from trajopt.problem.motion import Motion, MotionInTime
from trajopt.problem.requirements import Region, RotationCoordinates
from trajopt.problem.residual import WHOLE, Constraint, Cost, units_of
from trajopt.problem.smoothness import Acceleration, Jerk, Velocity
from trajopt.scene.reduced import ReducedModel
from trajopt.values.arrays import Floats, Ints, Rows
from trajopt.values.shapes.shapes import Box, Cylinder, Plane, Sphere

OF_KNOTS = {Velocity, Acceleration, Jerk, SplineRate}
"""Terms of the knots themselves, which are independent of the samples."""
LINEAR = OF_KNOTS | {RestPosture, JointPosition, JointSum}
"""Terms whose rows are linear in the knots, and all there at every point."""
OF_FRAMES = {ArcCoordinates, CurveError, SightClearance, SmallestSingularValue, LostManipulability}
"""Terms of frames without a formula in the core: with one of these Python evaluates all terms of frames,
which share the placements of the samples.
"""
OTHERS = {GravityShare, HoldingTorque, Rolling, FunctionResidual, Expression}
"""Other terms, whose rows depend on the knots of one sample too, or on two neighbours."""
BOUNDED = {Constraint, TaperedConstraint}
"""Constraints whose bounds depend on the component and the place of a row only."""


@dataclass(eq=False)
class CompilableMotionNlp(MotionNlp):
    """A program over the variables of a curve that may be evaluated in the core; see `CompilableNlp`."""

    _linear_of_knots: dict[Cost | Constraint, LinearPart] = field(
        init=False, repr=False, default_factory=dict[Cost | Constraint, LinearPart]
    )

    def compiled(self, sampling: Ints) -> CompiledProgram | None:
        if type(self).linearise is not MotionNlp.linearise or type(self.query) is not Query:
            return None
        motion = self.motion(np.zeros_like(self.lower), sampling)
        parts: list[Part] = []
        placed = False
        for item in (*(self.problem.costs or ()), *self.constraints):
            part = self._part(item, motion, placed=placed)
            if part is None:
                return None
            placed = placed or (isinstance(part, FramePart) and item.window == WHOLE)
            parts.append(part)
        count = len(self.problem.costs or ())
        return CompiledProgram(
            self.lower,
            self.upper,
            self.scale,
            sampling,
            self.query.core,
            tuple(parts[:count]),
            tuple(parts[count:]),
            motion.support,
        )

    def python_rows(self, x: Floats, sampling: Ints) -> tuple[Block, ...]:
        motion, terms = self.motion(x, sampling), self._python_terms
        costs = [item for item in self.problem.costs or () if type(item.residual) in terms]
        constraints = [item for item in self.constraints if type(item.residual) in terms]
        return (
            *(self.cost_rows(item, motion) for item in costs),
            *(self.constraint_rows(item, motion) for item in constraints),
        )

    @cached_property
    def _python_terms(self) -> frozenset[type]:
        kinds = {type(item.residual) for item in (*(self.problem.costs or ()), *self.constraints)}
        return frozenset(kinds & (OTHERS | OF_FRAMES | (FRAME_TERMS if kinds & OF_FRAMES else set())))

    def _part(self, item: Cost | Constraint, motion: Motion, *, placed: bool) -> Part | None:
        residual = item.residual
        if not isinstance(item, Cost) and type(item) not in BOUNDED:
            return None
        if type(residual) in self._python_terms:
            return PythonPart(item.loss if isinstance(item, Cost) else item.tolerance)
        if type(residual) in LINEAR:
            return self._linear(item, motion)
        within = self.samples_within(motion, item.window)
        if isinstance(residual, Clearance | SoftClearance) and type(item) is not TaperedConstraint:
            return _distance_part(_empty(item, within), residual, within)
        if type(residual) is ClearanceInTime or type(residual) is SplineTorque:
            return self._part_in_time(item, residual, within)
        build = _BUILD.get(type(residual))
        frame = None if build is None else build(residual)
        if frame is None:
            return None
        count = 0 if placed and item.window == WHOLE else len(within.place)
        empty = _empty(item, within, frame.term.components)
        return FramePart(empty, _samples(within), frame.view, frame.term, count)

    def _part_in_time(
        self, item: Cost | Constraint, residual: ClearanceInTime | SplineTorque, within: Motion
    ) -> Part | None:
        if isinstance(item, Cost) or item.window != WHOLE or not isinstance(within, MotionInTime):
            return None
        empty = _empty(item, within)
        if isinstance(residual, ClearanceInTime):
            obstacles = residual.obstacles
            if not isinstance(obstacles.query, Query):
                return None
            driven = np.ascontiguousarray(obstacles.timed.driven.at(within.times))
            pairs = obstacles.pairs
            return ChangingDistancePart(
                empty,
                _samples(within),
                within.times,
                driven,
                obstacles.query.core,
                residual.reach,
                residual.margin,
                pairs.errors,
                pairs.appears,
                pairs.expires,
            )
        position, velocity, acceleration = (np.ascontiguousarray(weight) for weight in residual.weights)
        moments = Samples(residual.support, position, residual.place)
        dynamics = residual.dynamics.core
        return TorquePart(empty, moments, velocity, acceleration, dynamics, residual.effort, residual.listed)

    def _linear(self, item: Cost | Constraint, motion: Motion) -> LinearPart:
        part = self._linear_of_knots.get(item)
        if part is None:
            one = isinstance(item, Cost)
            part = LinearPart(self.cost_rows(item, motion) if one else self.constraint_rows(item, motion))
            if type(item.residual) in OF_KNOTS:
                self._linear_of_knots[item] = part
        return part


def _samples(motion: Motion) -> Samples:
    return Samples(motion.support, motion.weight, motion.place)


def _empty(item: Cost | Constraint, motion: Motion, components: int | None = None) -> Block:
    residual = item.residual
    none = np.zeros(0, dtype=np.int64)
    rows = motion.rows(none, np.zeros(0), np.zeros((0, motion.knots.shape[1])), none)
    if isinstance(item, Cost):
        return CostRows(residual.name, rows, np.array((float(item.weight),)), item.loss, type(residual))
    lower, upper = item.lower, item.upper
    if components is not None:
        count = len(motion.place) * components
        number = np.tile(np.arange(components, dtype=np.int64), len(motion.place))
        place = np.repeat(motion.place, components)
        lower, upper = item.bounds(Rows(np.zeros(count), rows.jacobian, rows.knots, number, place))
    kind, units = type(residual), units_of(residual)
    return ConstraintRows(residual.name, rows, lower, upper, item.tolerance, item.reach, kind, units)


def _distance_part(empty: Block, residual: Clearance | SoftClearance, motion: Motion) -> DistancePart | None:
    samples, reduced = _samples(motion), motion.query.reduced
    if type(residual) is SoftClearance:
        distance, root = residual.by_pair(reduced)
        return DistancePart(empty, samples, distance, -root, distance, None)
    if type(residual) is not Clearance:
        return None
    pairs, margin = residual.reduced.pairs, residual.margin
    reach, one = pairs.margin + residual.activation, np.ones(len(pairs.margin))
    if margin is None:
        return DistancePart(empty, samples, reach, one, pairs.margin, None)
    if type(margin) is TaperedMargins:
        return DistancePart(empty, samples, reach, one, margin.pairs.margin, taper_of(margin, 1.0))
    if type(margin) is ShrunkMargins:
        taper = taper_of(margin.margins, margin.share)
        return DistancePart(empty, samples, reach, one, margin.margins.pairs.margin, taper)
    return None


def taper_of(margins: TaperedMargins, share: float) -> Taper:
    """Return tapered margins, or a share of them, as the core needs them."""
    return Taper(
        required=margins.pairs.required,
        at_start=margins.at_start,
        at_end=margins.at_end,
        contact_until=margins.contact_until,
        contact_from=margins.contact_from,
        depth=margins.depth,
        gives=shrinkable(margins.pairs) if share < 1.0 else np.zeros(len(margins.depth), dtype=np.bool_),
        last=margins.last,
        knots=margins.taper,
        share=share,
    )


@dataclass(frozen=True, eq=False)
class FrameInCore:
    """A term of a frame, as the core needs it."""

    view: descent.View
    term: descent.FrameTerm


def _axis_angle(residual: AxisAngle) -> FrameInCore:
    need = residual.required
    view = _view(residual.reduced, need.frame, need.reference, np.zeros(3))
    return FrameInCore(view, descent.axis_angle(need.axis, need.direction, _across(need.direction)))


def _placement(residual: FramePlacementError) -> FrameInCore:
    need = residual.required
    view = _view(residual.reduced, need.frame, need.reference, need.offset)
    euler = need.coordinates is not RotationCoordinates.ROTATION_VECTOR
    rotation = np.ascontiguousarray(need.placement.rotation)
    return FrameInCore(view, descent.frame_placement(rotation, need.placement.translation, euler))


def _distance(residual: PointDistance) -> FrameInCore:
    need = residual.required
    view = _view(residual.reduced, need.first, need.second, need.first_offset)
    return FrameInCore(view, descent.point_distance(need.second_offset))


def _view_angle(residual: ViewAngle) -> FrameInCore:
    need = residual.required
    view = _view(residual.reduced, need.reference, need.frame, need.target)
    return FrameInCore(view, descent.view_angle(need.origin, need.axis, _across(need.axis)))


def _view_distance(residual: ViewDistance) -> FrameInCore:
    need = residual.required
    view = _view(residual.reduced, need.reference, need.frame, need.target)
    return FrameInCore(view, descent.view_distance(need.origin))


def _region(residual: RegionCoordinates) -> FrameInCore:
    need = residual.required
    members = [
        (*_shape(shape), np.ascontiguousarray(where.rotation), where.translation)
        for shape, where in need.members
    ]
    view = _view(residual.reduced, need.frame, need.reference, need.offset)
    return FrameInCore(view, descent.region(members))


_BUILD: Mapping[type, Callable[[Any], FrameInCore]] = {
    AxisAngle: _axis_angle,
    FramePlacementError: _placement,
    PointDistance: _distance,
    ViewAngle: _view_angle,
    ViewDistance: _view_distance,
    RegionCoordinates: _region,
}

FRAME_TERMS = frozenset(_BUILD)
"""Terms with a formula in the core."""


def _shape(shape: Region) -> tuple[descent.Shape, Floats]:
    match shape:
        case Box():
            return descent.Shape.BOX, np.array((shape.x, shape.y, shape.z)) / 2.0
        case Sphere():
            return descent.Shape.SPHERE, np.full(3, shape.radius)
        case Cylinder():
            return descent.Shape.CYLINDER, np.array((shape.radius, shape.radius, shape.length / 2.0))
        case Plane():
            return descent.Shape.HALF_SPACE, np.zeros(3)


def _view(reduced: ReducedModel, frame: str, reference: str, offset: Floats) -> descent.View:
    joint, held = reduced.attachment(frame)
    base, base_held = reduced.attachment(reference)
    return descent.View(
        joint=joint,
        rotation=np.ascontiguousarray(held.rotation),
        point=held * offset,
        base=base,
        base_rotation=np.ascontiguousarray(base_held.rotation),
        base_origin=base_held.translation,
    )


def _across(axis: Floats) -> Floats:
    return np.ascontiguousarray(np.linalg.svd(axis[None, :])[2][1])
