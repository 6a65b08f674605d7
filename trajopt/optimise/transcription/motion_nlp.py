"""A problem's costs and constraints on the samples of a curve, independent of the curve's variables."""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from trajopt.geometry import Evaluator, Query, WorkCounts
from trajopt.optimise.nlp import ConstraintRows, CostRows, Linearisation
from trajopt.problem.motion import Motion
from trajopt.problem.problem import Problem
from trajopt.problem.residual import WHOLE, Constraint, Cost, Window, units_of
from trajopt.values.arrays import Bools, Floats, Ints, Rows

ROUNDING = 1e-9
"""Samples this far outside a window still belong to it [knots]."""


@dataclass(eq=False)
class MotionNlp(ABC):
    """The program over the variables of a curve; owns the query, so one per thread."""

    problem: Problem
    counts: WorkCounts
    lower: Floats
    upper: Floats
    scale: Floats
    query: Evaluator
    constraints: tuple[Constraint, ...]

    @abstractmethod
    def sampling(self, x: Floats, *, fine: bool) -> Ints:
        """Return samples per segment: few, or as many as the sweep of the bodies demands."""

    @abstractmethod
    def motion(self, x: Floats, sampling: Ints) -> Motion:
        """Sample the curve."""

    def restart(self) -> None:
        if isinstance(self.query, Query):
            self.query.forget()

    def linearise(self, x: Floats, sampling: Ints) -> Linearisation:
        motion = self.motion(x, sampling)
        costs = tuple(self.cost_rows(cost, motion) for cost in self.problem.costs or ())
        constraints = tuple(self.constraint_rows(item, motion) for item in self.constraints)
        return Linearisation(x, costs, constraints, sampling)

    def cost_rows(self, cost: Cost, motion: Motion) -> CostRows:
        residual = cost.residual
        rows = self._rows(residual.linearise(self.samples_within(motion, cost.window)), cost.window)
        weight = np.full(len(rows.value), cost.weight)
        return CostRows(residual.name, rows, weight, cost.loss, type(residual))

    def constraint_rows(self, item: Constraint, motion: Motion) -> ConstraintRows:
        rows = item.residual.linearise(self.samples_within(motion, item.window))
        return self._bounded(item, self._rows(rows, item.window))

    def samples_within(self, motion: Motion, window: Window) -> Motion:
        return motion if window == WHOLE else motion.where(self._within(motion.place, window))

    def _rows(self, rows: Rows, window: Window) -> Rows:
        """Return the rows within a window: differences reach beyond the samples that they are taken of."""
        return rows if window == WHOLE else _take(rows, self._within(rows.place, window))

    def _within(self, place: Floats, window: Window) -> Bools:
        last = self.problem.knots - 1
        return (place >= window.first * last - ROUNDING) & (place <= window.last * last + ROUNDING)

    def _bounded(self, item: Constraint, rows: Rows) -> ConstraintRows:
        lower, upper = item.bounds(rows)
        touched = rows.jacobian.any(axis=2) & self._moves[rows.knots]
        keep = touched.any(axis=1) & (np.isfinite(lower) | np.isfinite(upper))
        if not keep.all():
            rows, lower, upper = _take(rows, keep), lower[keep], upper[keep]
        residual = item.residual
        kind, units = type(residual), units_of(residual)
        return ConstraintRows(residual.name, rows, lower, upper, item.tolerance, item.reach, kind, units)

    @cached_property
    def _moves(self) -> Bools:
        return np.any(self.lower < self.upper, axis=1)


def _take(rows: Rows, keep: Bools) -> Rows:
    return Rows(
        rows.value[keep], rows.jacobian[keep], rows.knots[keep], rows.component[keep], rows.place[keep]
    )
