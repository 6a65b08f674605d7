"""Rows of a linearised residual, and how a residual is penalised."""

from dataclasses import dataclass
from enum import Enum

from trajopt.values.arrays import Floats, Ints, Value


class Loss(Enum):
    """How a residual r with weight w is penalised as a cost."""

    SQUARED = "w r^2"
    ABSOLUTE = "w |r|"
    HINGE = "w max(0, r)"


@dataclass(frozen=True, eq=False)
class Rows(Value):
    """Linearised residual rows, r(x + dx) = value + sum_k jacobian[:, k] . dx[knots[:, k]].

    Attributes:
        value: Residuals, shape (m,).
        jacobian: Derivatives by the knots of the stencil, shape (m, k, n).
        knots: The knots of each row's stencil, shape (m, k).
        component: Which component of the residual (or which pair) each row is, shape (m,).
        place: Location of each row along the motion, in knots, shape (m,).
    """

    value: Floats
    jacobian: Floats
    knots: Ints
    component: Ints
    place: Floats
