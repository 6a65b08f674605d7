"""Piecewise polynomials of time on other pieces."""

import numpy as np

from trajopt.values.arrays import Floats


def refined(times: Floats, knots: Floats, coefficients: Floats, degree: int) -> Floats:
    """Return piecewise polynomials on finer pieces, by Taylor's formula; they rest outside their own times.

    Args:
        times: Ends of the k finer pieces, among them all of their own that lie within, shape (k + 1,) [s].
        knots: Ends of their own j pieces, shape (j + 1,) [s].
        coefficients: By the time since the start of each piece, highest power first, shape (d + 1, j, n).
        degree: How many powers the result has, d + 1 or more.

    Returns:
        Shape (degree, k, n).
    """
    begins = times[:-1]
    piece = np.clip(np.searchsorted(knots, begins, side="right") - 1, 0, len(knots) - 2)
    since = (np.clip(begins, knots[0], knots[-1]) - knots[piece])[:, None]
    taylor = coefficients[:, piece].copy()
    for done in range(len(taylor) - 1):
        for power in range(1, len(taylor) - done):
            taylor[power] += since * taylor[power - 1]
    taylor[:-1, (begins < knots[0]) | (begins >= knots[-1])] = 0.0
    return np.pad(taylor, ((degree - len(taylor), 0), (0, 0), (0, 0)))
