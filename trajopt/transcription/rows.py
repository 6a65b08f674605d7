"""Rows of costs and constraints on the samples of a motion, whatever its knots mean."""

from collections.abc import Sequence

import numpy as np

from trajopt.arrays import Bools
from trajopt.nlp import ConstraintRows, CostRows, Rows
from trajopt.terms.motion import Motion
from trajopt.terms.residual import WHOLE, Constraint, Cost, Residual, Window


def cost_rows(costs: Sequence[Cost], motion: Motion, last: float) -> tuple[CostRows, ...]:
    """Linearise costs.

    Args:
        costs: The costs.
        motion: The samples.
        last: Place of the motion's end.
    """
    return tuple(
        CostRows(residual.name, rows, np.full(len(rows.value), cost.weight), cost.loss, type(residual))
        for cost in costs
        for residual in (cost.residual,)
        for rows in (_in_window(residual, motion, cost.window, last),)
    )


def constraint_rows(
    items: Sequence[Constraint], motion: Motion, last: float, moves: Bools
) -> tuple[ConstraintRows, ...]:
    """Linearise constraints, without rows that nothing can be done about.

    Args:
        items: The constraints.
        motion: The samples.
        last: Place of the motion's end.
        moves: Whether anything of each knot may change, shape (N,).
    """
    return tuple(_bounded(item, motion, last, moves) for item in items)


def _bounded(item: Constraint, motion: Motion, last: float, moves: Bools) -> ConstraintRows:
    rows = _in_window(item.residual, motion, item.window, last)
    lower, upper = item.bounds(rows)
    touched = rows.jacobian.any(axis=2) & moves[rows.knots]
    keep = touched.any(axis=1) & (np.isfinite(lower) | np.isfinite(upper))
    if not keep.all():
        rows, lower, upper = _take(rows, keep), lower[keep], upper[keep]
    residual = item.residual
    return ConstraintRows(residual.name, rows, lower, upper, item.tolerance, item.reach, type(residual))


def _take(rows: Rows, keep: Bools) -> Rows:
    return Rows(
        rows.value[keep], rows.jacobian[keep], rows.knots[keep], rows.component[keep], rows.place[keep]
    )


def _in_window(residual: Residual, motion: Motion, window: Window, last: float) -> Rows:
    """Linearise where the window lies."""
    if window == WHOLE:
        return residual.linearise(motion)
    first, final = window.first * last - 1e-9, window.last * last + 1e-9
    place = motion.place
    rows = residual.linearise(motion.where((place >= first) & (place <= final)))
    return _take(rows, (rows.place >= first) & (rows.place <= final))
