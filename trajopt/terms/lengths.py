"""Lengths of vectors and their derivatives."""

import numpy as np

from trajopt.arrays import Floats

ZERO = 1e-12
"""A shorter vector has no direction."""


def lengths(vectors: Floats, rate: Floats, aside: int | None = None) -> tuple[Floats, Floats]:
    """Return the lengths of vectors and their derivatives.

    Where a vector vanishes its length has no derivative. Zero is taken for one that is bounded above;
    for one that must grow, the rate along an axis, so that there is a way out.

    Args:
        vectors: Shape (s, d).
        rate: Their derivatives, shape (s, d, n).
        aside: The axis along which vectors of no length are taken to grow; none when None.

    Returns:
        Lengths, shape (s,), and derivatives, shape (s, n).
    """
    length = np.linalg.norm(vectors, axis=1)
    unit = vectors / np.maximum(length, ZERO)[:, None]
    if aside is not None:
        unit[length < ZERO] = np.eye(vectors.shape[1])[aside]
    return length, np.einsum("sd,sdn->sn", unit, rate)
