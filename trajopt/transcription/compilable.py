"""Programs over the samples of a curve in parts for the core: which terms it can evaluate, and how.

Terms that are linear are handed over as the rows that they have where all knots are zero; distances as what
they are measured against. Other terms of the library are evaluated in Python at every point, where their
formulas are. Of a term that is none of these nothing is known before: it leaves the program to Python.
"""

from dataclasses import dataclass

import numpy as np

from trajopt.arrays import Floats, Ints
from trajopt.nlp import ConstraintRows, CostRows, Rows
from trajopt.query import Query
from trajopt.solvers.compiled import (
    Block,
    CompiledProgram,
    DistancePart,
    LinearPart,
    Part,
    PythonPart,
    Samples,
    Taper,
)
from trajopt.terms.axis_alignment import AxisAngle
from trajopt.terms.clearance import Clearance
from trajopt.terms.coupled_joints import JointSum
from trajopt.terms.distance_between import PointDistance
from trajopt.terms.expression import Expression
from trajopt.terms.follows_curve import CurveError
from trajopt.terms.frame_placement import FramePlacementError
from trajopt.terms.gaze import ViewAngle, ViewDistance
from trajopt.terms.gravity_torque import GravityShare, HoldingTorque
from trajopt.terms.joint_positions import JointPosition
from trajopt.terms.line_of_sight import SightClearance
from trajopt.terms.motion import Motion
from trajopt.terms.point_on_arc import ArcCoordinates
from trajopt.terms.position_in_region import RegionCoordinates
from trajopt.terms.residual import Constraint, Cost
from trajopt.terms.residual_from_function import FunctionResidual
from trajopt.terms.rest_posture import RestPosture
from trajopt.terms.rolling import Rolling
from trajopt.terms.singularity_distance import LostManipulability, SmallestSingularValue
from trajopt.terms.smoothness import Acceleration, Jerk, Velocity
from trajopt.terms.soft_clearance import SoftClearance
from trajopt.transcription.margins import ShrunkMargins, TaperedMargins, shrinkable
from trajopt.transcription.motion_nlp import MotionNlp
from trajopt.transcription.tapered_bounds import TaperedConstraint

LINEAR = {Velocity, Acceleration, Jerk, RestPosture, JointPosition, JointSum}
"""Terms whose rows are linear in the knots, and all there at every point."""
IN_PYTHON = {
    *(AxisAngle, FramePlacementError, RegionCoordinates, PointDistance, ArcCoordinates, CurveError),
    *(ViewAngle, ViewDistance, SightClearance, SmallestSingularValue, LostManipulability),
    *(GravityShare, HoldingTorque, Rolling, FunctionResidual, Expression),
}
"""Terms whose rows each depend on the knots of one sample, or on two neighbours."""
BOUNDED = {Constraint, TaperedConstraint}
"""Constraints whose bounds depend on the component and the place of a row only."""


@dataclass(eq=False)
class CompilableMotionNlp(MotionNlp):
    """A program over the variables of a curve that may be evaluated in the core; see `CompilableNlp`."""

    def compiled(self, sampling: Ints) -> CompiledProgram | None:
        """Return the program in parts on given samples; None if one of its terms is unknown to the core."""
        if type(self).linearise is not MotionNlp.linearise or type(self.query) is not Query:
            return None
        motion = self.motion(np.zeros_like(self.lower), sampling)
        costs = [self._cost_part(cost, motion) for cost in self.problem.costs or ()]
        constraints = [self._constraint_part(item, motion) for item in self.constraints]
        parts = [part for part in (*costs, *constraints) if part is not None]
        if len(parts) < len(costs) + len(constraints):
            return None
        return CompiledProgram(
            self.lower,
            self.upper,
            self.scale,
            sampling,
            self.query.core,
            tuple(parts[: len(costs)]),
            tuple(parts[len(costs) :]),
            max(
                1,
                _span(motion.support),
                *map(_span, (part.at_zero.rows.knots for part in parts if isinstance(part, LinearPart))),
            ),
        )

    def python_rows(self, x: Floats, sampling: Ints) -> tuple[Block, ...]:
        """Return the rows of those parts that the core asks for, at a point."""
        motion = self.motion(x, sampling)
        costs = [item for item in self.problem.costs or () if type(item.residual) in IN_PYTHON]
        constraints = [item for item in self.constraints if type(item.residual) in IN_PYTHON]
        return (
            *(self.cost_rows(item, motion) for item in costs),
            *(self.constraint_rows(item, motion) for item in constraints),
        )

    def _cost_part(self, cost: Cost, motion: Motion) -> Part | None:
        """Return a cost as a part; None where its term is unknown."""
        residual = cost.residual
        if type(residual) in LINEAR:
            return LinearPart(self.cost_rows(cost, motion))
        if type(residual) in IN_PYTHON:
            return PythonPart(cost.loss)
        if isinstance(residual, Clearance | SoftClearance):
            none = _no_rows(motion)
            empty = CostRows(residual.name, none, np.array((cost.weight,)), cost.loss, type(residual))
            return _distance_part(empty, residual, self.samples_within(motion, cost.window))
        return None

    def _constraint_part(self, item: Constraint, motion: Motion) -> Part | None:
        """Return a constraint as a part; None where its term or its kind of bounds is unknown."""
        residual = item.residual
        if type(item) not in BOUNDED:
            return None
        if type(residual) in LINEAR:
            return LinearPart(self.constraint_rows(item, motion))
        if type(residual) in IN_PYTHON:
            return PythonPart(item.tolerance)
        if isinstance(residual, Clearance | SoftClearance) and type(item) is Constraint:
            none = _no_rows(motion)
            empty = ConstraintRows(
                residual.name, none, item.lower, item.upper, item.tolerance, item.reach, type(residual)
            )
            return _distance_part(empty, residual, self.samples_within(motion, item.window))
        return None


def _distance_part(empty: Block, residual: Clearance | SoftClearance, motion: Motion) -> DistancePart | None:
    samples = Samples(motion.support, motion.weight, motion.place)
    reduced = motion.query.reduced
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


def _no_rows(motion: Motion) -> Rows:
    """Return no rows, over stencils of the motion's samples."""
    none = np.zeros(0, dtype=np.int64)
    return motion.rows(none, np.zeros(0), np.zeros((0, motion.knots.shape[1])), none)


def _span(knots: Ints) -> int:
    """Return how many knots the widest row spans."""
    return int(np.ptp(knots, axis=1).max()) if knots.size else 0
