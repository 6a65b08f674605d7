"""How many samples a segment needs so that no body moves far between two of them."""

import numpy as np

from trajopt.arrays import Floats, Ints
from trajopt.query import Query

SWEEP = 0.02
"""No body moves farther than this between two samples, in the end [m]."""
COARSE_SAMPLES = 3
"""Samples per segment while the motion is not free yet."""
MOST_SAMPLES = 400
"""Samples per segment at most."""
TURN = 0.5
"""Up to such a turn a body travels hardly farther than it ends up displaced [rad | m]."""


def swept_samples(query: Query, corners: Floats, least: int = COARSE_SAMPLES) -> Ints:
    """Return how many samples each segment of a polyline needs, shape (N - 1,).

    Args:
        query: Measures how far bodies move.
        corners: Shape (N, n) [rad | m].
        least: Samples that every segment gets.
    """
    segments = len(corners) - 1
    parts = max(1, int(np.ceil(np.abs(np.diff(corners, axis=0)).max(initial=0.0) / TURN)))
    share = np.arange(parts * segments + 1) / parts
    first = np.minimum(share.astype(np.int64), segments - 1)
    fine = corners[first] + (share - first)[:, None] * (corners[first + 1] - corners[first])
    swept = query.displacement(fine[:-1], fine[1:]).reshape(segments, parts).sum(axis=1)
    return np.clip(np.ceil(swept / SWEEP), least, MOST_SAMPLES).astype(np.int64)
