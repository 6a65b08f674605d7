"""What a step's QP penalises: excess over bounds, of constraints and of costs with a kink alike."""

from dataclasses import dataclass

import numpy as np

from trajopt.arrays import Floats
from trajopt.nlp import Linearisation, Loss, Rows

REGULARISATION = 1e-9
"""Added to the Hessian's diagonal, so that directions that no cost touches stay put."""


@dataclass(frozen=True, eq=False)
class SoftenedRows:
    """Rows that cost penalty * max(0, lower - r) and penalty * max(0, r - upper).

    Attributes:
        rows: The linearised rows.
        lower: Shape (m,); -inf for none.
        upper: Shape (m,); inf for none.
        penalty: Shape (m,).
    """

    rows: Rows
    lower: Floats
    upper: Floats
    penalty: Floats


def softened_rows(at: Linearisation, penalty: float) -> list[SoftenedRows]:
    """List constraints and non-smooth costs as softened rows.

    Args:
        at: The point.
        penalty: Weight of constraint violations.
    """
    found = [
        SoftenedRows(block.rows, block.lower, block.upper, np.full(len(block.lower), penalty))
        for block in at.constraints
    ]
    for block in at.costs:
        if block.loss is not Loss.SQUARED:
            size = len(block.weight)
            lower = np.zeros(size) if block.loss is Loss.ABSOLUTE else np.full(size, -np.inf)
            found.append(SoftenedRows(block.rows, lower, np.zeros(size), block.weight))
    return found
