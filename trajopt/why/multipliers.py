"""Lagrange multipliers at a solution, from its linearisation alone: no solver has to return them.

At a minimum the gradient of the costs is balanced by the active rows, grad f + J^T l = 0 with l >= 0. The
balance is solved in the least-squares sense under the signs. Source: Nocedal and Wright, Numerical
Optimization (2006), chapter 12 and equation 18.21; signs by Lawson and Hanson's NNLS.
"""

from collections.abc import Hashable, Sequence
from dataclasses import dataclass
from typing import NamedTuple, TypeVar

import numpy as np

from trajopt.optimise.nlp import Linearisation
from trajopt.values.arrays import Floats
from trajopt.values.rows import Loss, Rows

ACTIVE = 2e-3
"""A row counts as active when it is no farther from its bound than this, in its own unit."""


class RowKey(NamedTuple):
    """Which rows of a linearisation belong together."""

    kind: type[object]
    name: str
    component: int


@dataclass(frozen=True, eq=False)
class Multipliers:
    """The forces of the active rows of each constraint.

    Attributes:
        rows: By class and name of the residual and component of the row: by how much the cost falls when
            the bounds of all such rows are shifted outward by one unit.
        bounds: The same of the bounds of each variable, by its place in a knot, over all knots.
        unbalanced: Share of the gradient that the active rows do not balance: 0 at a perfect solution.
    """

    rows: dict[RowKey, float]
    bounds: dict[int, float]
    unbalanced: float


def multipliers(at: Linearisation, lower: Floats, upper: Floats) -> Multipliers:
    """Balance the gradient of the costs with the active rows and bounds.

    Args:
        at: Everything linearised at the solution.
        lower: Lower bounds of the knots, shape (N, n); equal to the upper where a knot is fixed.
        upper: Upper bounds, shape (N, n).
    """
    size, free = at.x.size, (lower < upper).ravel()
    gradient = np.zeros(size)
    for cost in at.costs:
        value, weight = cost.rows.value, cost.weight
        slope = {
            Loss.SQUARED: 2.0 * value,
            Loss.ABSOLUTE: np.sign(value),
            Loss.HINGE: (value > 0.0) * 1.0,
        }[cost.loss]
        gradient += (weight * slope) @ _dense(cost.rows, size)
    columns: list[Floats] = []
    owners: list[RowKey] = []
    for block in at.constraints:
        jacobian = _dense(block.rows, size)
        for sign, side in ((1.0, block.upper), (-1.0, block.lower)):
            for row in np.flatnonzero(sign * (side - block.rows.value) <= ACTIVE).tolist():
                columns.append(sign * jacobian[row])
                owners.append(RowKey(block.kind, block.name, int(block.rows.component[row])))
    count = len(columns)
    places: list[int] = []
    for sign, side in ((1.0, upper), (-1.0, lower)):
        for place in np.flatnonzero(free & (sign * (side - at.x).ravel() <= ACTIVE)).tolist():
            columns.append(sign * np.eye(1, size, place)[0])
            places.append(place % at.x.shape[1])
    scale = float(np.linalg.norm(gradient[free]))
    if not columns:
        return Multipliers({}, {}, 1.0 if scale > 0.0 else 0.0)
    from scipy.optimize import nnls

    try:
        push, missing = nnls(np.array(columns).T[free], -gradient[free])
    except RuntimeError:  # it did not end: columns that are nearly the same let it go round in circles
        return Multipliers({}, {}, 1.0)
    return Multipliers(
        _summed(owners, push[:count]),
        _summed(places, push[count:]),
        float(missing) / scale if scale > 0.0 else 0.0,
    )


Key = TypeVar("Key", bound=Hashable)


def _summed(keys: Sequence[Key], push: Floats) -> dict[Key, float]:
    total: dict[Key, float] = {}
    for key, force in zip(keys, push.tolist(), strict=True):
        total[key] = total.get(key, 0.0) + force
    return total


def _dense(rows: Rows, size: int) -> Floats:
    """Scatter block rows into a matrix over all variables, shape (m, size)."""
    m, k, n = rows.jacobian.shape
    dense = np.zeros((m, size // n, n))
    every = np.arange(m, dtype=np.int64)
    for place in range(k):
        np.add.at(dense, (every, rows.knots[:, place]), rows.jacobian[:, place])
    return dense.reshape(m, size)
