"""Nlp: a nonlinear program over knots x, shape (N, n), as block rows with stencils.

Every row of a residual touches few knots: a solver may use the structure or flatten it.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Protocol, runtime_checkable

import numpy as np

from trajopt.values.arrays import Floats, Ints, Loss, Rows, Value


@dataclass(frozen=True, eq=False)
class CostRows(Value):
    """Penalised rows.

    Attributes:
        weight: Shape (m,).
        kind: Class of the residual, which distinguishes residuals of the same name.
    """

    name: str
    rows: Rows
    weight: Floats
    loss: Loss
    kind: type[object] = object

    @cached_property
    def cost(self) -> float:
        """The cost's value."""
        return float(self.each.sum())

    @cached_property
    def each(self) -> Floats:
        """Cost of each row, shape (m,)."""
        value = self.rows.value
        if self.loss is Loss.SQUARED:
            return self.weight * value**2
        return self.weight * (np.abs(value) if self.loss is Loss.ABSOLUTE else np.maximum(value, 0.0))


@dataclass(frozen=True, eq=False)
class ConstraintRows(Value):
    """Rows that must lie between bounds.

    Attributes:
        lower: Shape (m,); -inf for none.
        upper: Shape (m,); inf for none.
        tolerance: Largest violation that counts as satisfied, in the residual's unit.
        reach: Rows farther inside their bounds are left out, as far pairs are; inf if all are always there.
        units: Unit of each component, or one of all: "m", "rad"; empty if unknown.
    """

    name: str
    rows: Rows
    lower: Floats
    upper: Floats
    tolerance: float
    reach: float = np.inf
    kind: type[object] = object
    units: tuple[str, ...] = ()

    def unit_of(self, row: int) -> str:
        """Return the unit of a row; empty if unknown."""
        component = int(self.rows.component[row])
        return self.units[component if len(self.units) > 1 else 0] if self.units else ""

    @cached_property
    def violation(self) -> Floats:
        """Distance of each row outside its bounds, shape (m,), >= 0."""
        value = self.rows.value
        return np.maximum(0.0, np.maximum(self.lower - value, value - self.upper))

    @cached_property
    def worst(self) -> float:
        """Largest violation; 0 without rows."""
        return float(self.violation.max(initial=0.0))


@dataclass(frozen=True, eq=False)
class Linearisation(Value):
    """Costs and constraints around one point.

    Attributes:
        x: The point, shape (N, n).
        sampling: Samples per segment that the rows were taken on, shape (N - 1,).
    """

    x: Floats
    costs: tuple[CostRows, ...]
    constraints: tuple[ConstraintRows, ...]
    sampling: Ints

    @cached_property
    def cost(self) -> float:
        """Sum of all costs."""
        return sum(block.cost for block in self.costs)

    @cached_property
    def violation(self) -> float:
        """Sum of all violations (the L1 norm)."""
        return float(sum(block.violation.sum() for block in self.constraints))

    @property
    def feasible(self) -> bool:
        """Whether every constraint holds within its tolerance."""
        return all(block.worst <= block.tolerance for block in self.constraints)


@runtime_checkable
class Restartable(Protocol):
    """A program whose linearisations may depend on earlier ones, within their accuracy."""

    def restart(self) -> None:
        """Make later linearisations independent of earlier ones."""
        ...


class Nlp(Protocol):
    """A program over knots: minimise costs subject to constraints and bounds."""

    @property
    def lower(self) -> Floats:
        """Lower bounds of the knots, shape (N, n); equal to upper for fixed knots."""
        ...

    @property
    def upper(self) -> Floats:
        """Upper bounds of the knots, shape (N, n)."""
        ...

    @property
    def scale(self) -> Floats:
        """A step of ordinary size in each variable, shape (n,); the trust region's unit."""
        ...

    def sampling(self, x: Floats, *, fine: bool) -> Ints:
        """Return the number of samples that each segment needs at x, shape (N - 1,)."""
        ...

    def linearise(self, x: Floats, sampling: Ints) -> Linearisation:
        """Evaluate and linearise everything at knots (N, n) on given samples per segment, shape (N - 1,).

        Only points on equal samples can be compared.
        """
        ...
