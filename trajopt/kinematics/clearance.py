"""Which of many configurations keep clear of everything."""

import numpy as np

from trajopt.arrays import Bools, Floats, number
from trajopt.errors import ShapeError
from trajopt.model.reduced import ReducedModel
from trajopt.query import Query


def clear(query: Query, positions: Floats, margin: Floats) -> Bools:
    """Say at which configurations no pair is nearer than its margin.

    Args:
        query: Measures.
        positions: Shape (S, n) [rad | m].
        margin: Clearance to keep, one for each pair, shape (p,) [m].

    Returns:
        Shape (S,).
    """
    free = np.ones(len(positions), dtype=np.bool_)
    free[query.close_pairs(positions, margin).sample] = False
    return free


def pair_margins(reduced: ReducedModel, margin: float | None) -> Floats:
    """Return the clearance of each pair: the scene's own when None, else the same for all, shape (p,) [m].

    It is never less than what is required of the pair.

    Raises:
        ShapeError: If the margin is negative or not finite.
    """
    if margin is None:
        return reduced.pairs.margin
    if number("margin", margin) < 0.0:
        raise ShapeError("margin", f"is negative: {margin:g} m")
    return np.maximum(margin, reduced.pairs.required)
