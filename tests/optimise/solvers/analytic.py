"""Small programs with known answers, as `Nlp`s without a robot."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from trajopt.optimise.nlp import ConstraintRows, CostRows, Linearisation
from trajopt.values.arrays import Floats, Ints, Loss, Rows

Function = Callable[[Floats], tuple[Floats, Floats]]
"""x (n,) -> values (m,), Jacobian (m, n)."""


def rows_of(function: Function, x: Floats) -> Rows:
    value, jacobian = function(x[0])
    m = len(value)
    return Rows(value, jacobian[:, None, :], np.zeros((m, 1), dtype=np.int64), np.arange(m), np.zeros(m))


@dataclass(frozen=True, eq=False)
class AnalyticNlp:
    """One knot; residuals as cost, constraints between bounds."""

    lower: Floats
    upper: Floats
    residual: Function
    weight: float
    loss: Loss
    constraint: Function
    bounds: tuple[Floats, Floats]

    @property
    def scale(self) -> Floats:
        return np.ones(self.lower.shape[1])

    def sampling(self, x: Floats, *, fine: bool) -> Ints:
        return np.ones(len(x), dtype=np.int64)

    def linearise(self, x: Floats, sampling: Ints) -> Linearisation:
        cost = rows_of(self.residual, x)
        held = rows_of(self.constraint, x)
        return Linearisation(
            x,
            (CostRows("cost", cost, np.full(len(cost.value), self.weight), self.loss),),
            (ConstraintRows("constraint", held, *self.bounds, 1e-6),),
            sampling,
        )
