"""The protocol of every term, and its two roles, cost and constraint."""

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike

from trajopt.problem.motion import Motion
from trajopt.problem.requirements import Requirement
from trajopt.values.arrays import Floats, Loss, Rows, Value, floats, number
from trajopt.values.errors import ProblemError, shown
from trajopt.values.errors.arguments import checked


@runtime_checkable
class Residual(Protocol):
    """A vector function of a motion, with its derivative.

    An optional attribute `units`, "m" or "rad" for each component or one for all, makes reports print
    violations in millimetres or degrees.
    """

    @property
    def name(self) -> str:
        """Name in reports."""
        ...

    def linearise(self, motion: Motion) -> Rows:
        """Evaluate and differentiate at all samples of a motion.

        The number of rows may change from call to call. `Motion.rows_of_all` converts values and derivatives
        by configurations to rows.
        """
        ...


def units_of(residual: Residual) -> tuple[str, ...]:
    """Return the unit of each component of a residual, or one for all, if its class has `units`."""
    return tuple(getattr(residual, "units", ()))


@checked
@dataclass(frozen=True)
class Window:
    """Part of a motion, from one fraction of its knots to another (0: first knot, 1: last)."""

    first: float = 0.0
    last: float = 1.0


WHOLE = Window()
"""The whole motion."""
END = Window(1.0, 1.0)
"""The last knot."""
MOST_WEIGHT = 1e12
"""Largest weight of a cost; doubles have 16 digits."""


@checked
@dataclass(frozen=True, eq=False)
class Cost:
    """A residual in the role of a cost: the sum over its rows of weight times loss.

    Attributes:
        weight: Weight of every row, from 0 to 1e12.
        window: Part of the motion that counts.
    """

    residual: Residual
    weight: float = 1.0
    loss: Loss = Loss.SQUARED
    window: Window = WHOLE

    def __post_init__(self) -> None:
        """Check the weight.

        Raises:
            ShapeError: If the weight is not finite.
            ProblemError: If it is negative or above 1e12.
        """
        _check_residual("cost", self.residual)
        weight = number(f"weight of cost {shown(self.residual.name)}", self.weight)
        if weight < 0.0:
            raise ProblemError(f"cost {shown(self.residual.name)}: weight {weight:g} is negative")
        if weight > MOST_WEIGHT:
            raise ProblemError(
                f"cost {shown(self.residual.name)}: weight {weight:g} hides all other terms in rounding; "
                f"{MOST_WEIGHT:g} is the most"
            )


@checked
@dataclass(frozen=True, eq=False)
class Constraint(Value):
    """A residual in the role of a constraint: every row between bounds.

    Fields: arguments of `constraint`.
    """

    residual: Residual
    lower: Floats
    upper: Floats
    tolerance: float = 1e-3
    window: Window = WHOLE
    reach: float = np.inf

    def __post_init__(self) -> None:
        _check_residual("constraint", self.residual)
        name = self.residual.name
        lower, upper = (
            floats(side, getattr(self, side), (None,), infinite=True) for side in ("lower", "upper")
        )
        if (lower > upper).any():
            raise ProblemError(f"constraint {shown(name)}: a lower bound exceeds its upper one")
        for what, value in (("tolerance", self.tolerance), ("reach", self.reach)):
            if number(what, value, infinite=True) < 0.0:
                raise ProblemError(f"constraint {shown(name)}: {what} is negative: {value:g}")

    def bounds(self, rows: Rows) -> tuple[Floats, Floats]:
        """Return lower and upper bound of each row, shape (m,)."""
        lower, upper = (
            np.full(len(rows.value), side[0]) if len(side) == 1 else side[rows.component]
            for side in (self.lower, self.upper)
        )
        return lower, upper

    def excess(self, motion: Motion) -> float:
        """Return the largest violation at a motion's samples; 0 if within the tolerance."""
        rows = self.residual.linearise(motion)
        lower, upper = self.bounds(rows)
        worst = float(np.maximum(lower - rows.value, rows.value - upper).max(initial=0.0))
        return worst if worst > self.tolerance else 0.0


@checked
def constraint(
    residual: Residual,
    *,
    lower: ArrayLike,
    upper: ArrayLike,
    tolerance: float = 1e-3,
    window: Window = WHOLE,
    reach: float = np.inf,
) -> Constraint:
    """Require a residual to lie between bounds.

    Args:
        lower: One bound, or one for each component; -inf for none.
        upper: Likewise; inf for none.
        tolerance: Accepted violation, in the residual's unit.
        window: Part of the motion that counts.
        reach: Distance inside its bounds beyond which the residual omits a row; inf if it lists all.

    Raises:
        ShapeError: If a bound, the tolerance or the reach is not a number.
        ProblemError: If the tolerance or the reach is negative, or a lower bound exceeds its upper one.
    """
    low, high = (
        floats(name, bound, (None,) * min(np.ndim(bound), 1), infinite=True)
        for name, bound in (("lower", lower), ("upper", upper))
    )
    low, high = np.atleast_1d(low), np.atleast_1d(high)
    return Constraint(residual, low, high, tolerance, window, reach)


def _check_residual(role: str, residual: object) -> None:
    # As `isinstance` of the protocol says, in a tenth of its time.
    if not (hasattr(residual, "name") and callable(getattr(residual, "linearise", None))):
        raise ProblemError(f"{role}: {shown(residual)} is not a residual, which has a name and linearise()")


def check_path_constraint(required: object) -> None:
    if not isinstance(required, Requirement | Constraint):
        raise ProblemError(f"constraints: {shown(required)} is neither a requirement nor a Constraint")
    if isinstance(required, Constraint) and required.window not in (WHOLE, END):
        name = shown(required.residual.name)
        raise ProblemError(f"{name}: a window has no time to be judged at; use `during` and waypoints")
