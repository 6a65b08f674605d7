"""Bounds of the coordinates and their derivatives in each cell of a grid of times."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from intervals import Floats, Interval, exactly, hull, on_bounds
from statement import HermiteCurve, Statement


@dataclass(frozen=True, eq=False)
class GridMotion:
    """The coordinates over the g - 1 cells of a grid.

    Attributes:
        positions: At the times of the grid, shape (g, n).
        bounds: Of position and its derivatives up to the fourth within each cell, shape (g - 1, n) each.
        accelerations: At the start and the end of each cell, shape (g - 1, n) each.
    """

    positions: Interval
    velocities: Interval
    bounds: tuple[Interval, ...]
    accelerations: tuple[Interval, Interval]


def motion_on(statement: Statement, grid: Floats) -> GridMotion:
    """Bound all coordinates in the cells of a grid that has all knots.

    A polynomial lies between its smallest and its largest Bernstein coefficient. Source: Farouki, The
    Bernstein polynomial basis: a centennial retrospective, CAGD 2012.
    """
    parts = [_on(curve, grid) for curve in (statement.motion, *statement.drives)]
    beside = (on_bounds(np.hstack, each) for each in zip(*parts, strict=True))
    positions, velocities, begins, ends, *bounds = beside
    return GridMotion(positions, velocities, tuple(bounds), (begins, ends))


def _on(curve: HermiteCurve, grid: Floats) -> list[Interval]:
    """Bound positions and velocities at the grid, accelerations at the ends of cells, and all within."""
    piece = np.searchsorted(curve.times, grid[:-1], side="right") - 1
    length = _lengths(curve)[piece]
    begin, end = (
        (exactly(side[:, None]) - exactly(curve.times[piece][:, None])) / length
        for side in (grid[:-1], grid[1:])
    )
    cells = [_restricted([each[piece] for each in order], begin, end) for order in _bernstein(curve)]
    return [_at_grid(cells[0]), _at_grid(cells[1]), cells[2][0], cells[2][-1], *map(hull, cells)]


def _lengths(curve: HermiteCurve) -> Interval:
    return exactly(curve.times[1:, None]) - exactly(curve.times[:-1, None])


def _bernstein(curve: HermiteCurve) -> list[list[Interval]]:
    """Return the Bernstein coefficients of position and its derivatives in each piece, (k - 1, n) each."""
    h = _lengths(curve)
    starts, ends = ([exactly(rows[side]) for rows in curve.values] for side in (slice(-1), slice(1, None)))
    degree = 2 * len(curve.values) - 1
    slope = exactly(float(degree)) * ((ends[0] - starts[0]) / h)
    if degree == 3:
        velocity = [starts[1], slope - starts[1] - ends[1], ends[1]]
    else:
        quarter = h * exactly(0.25)
        after, before = starts[1] + starts[2] * quarter, ends[1] - ends[2] * quarter
        # The mean of the velocity's coefficients is the mean velocity.
        velocity = [starts[1], after, slope - starts[1] - after - before - ends[1], before, ends[1]]
    position = [starts[0]]
    for coefficient in velocity[:-1]:
        position.append(position[-1] + coefficient * h / exactly(float(degree)))
    acceleration = _derivative(velocity, h)
    jerk = _derivative(acceleration, h)
    fourth = _derivative(jerk, h) or [exactly(np.zeros_like(jerk[0].low))]
    return [[*position, ends[0]], velocity, acceleration, jerk, fourth]


def _derivative(coefficients: list[Interval], length: Interval) -> list[Interval]:
    degree = exactly(float(len(coefficients) - 1))
    return [(after - before) * degree / length for before, after in pairwise(coefficients)]


def _restricted(coefficients: list[Interval], begin: Interval, end: Interval) -> list[Interval]:
    """Return the coefficients over a part of the unit interval: values of the polynomial's blossom."""
    degree = len(coefficients) - 1
    before, after = exactly(1.0) - begin, exactly(1.0) - end
    found: list[Interval] = []
    for ends in range(degree + 1):
        row = coefficients
        for step in range(degree):
            rest, at = (after, end) if step < ends else (before, begin)
            row = [one * rest + other * at for one, other in pairwise(row)]
        found.append(row[0])
    return found


def _at_grid(cells: list[Interval]) -> Interval:
    """Return values at the grid: those before and after each time, which may differ in drives."""
    begin, end = cells[0], cells[-1]
    return hull([on_bounds(np.vstack, [begin, end[-1:]]), on_bounds(np.vstack, [begin[:1], end])])
