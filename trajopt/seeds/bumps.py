"""Straight lines bent to random sides: first guesses for when the straight one ends in a local minimum."""

from collections.abc import Iterator
from itertools import count

import numpy as np

from trajopt.arrays import Floats

BEND = 0.6
"""Standard deviation of the first bends, in ordinary steps of each joint."""
GROWTH = 12
"""After so many lines the bends are twice as wide, after twice as many three times, ..."""
SWAY = 0.5
"""Share of the whole wave, to one side and then the other, beside the half wave."""


def bumps(line: Floats, scale: Floats, rng: np.random.Generator) -> Iterator[Floats]:
    """Yield the line plus a half and a whole sine wave of random heights in every joint, without end.

    Args:
        line: Knots, shape (N, n); the ends stay.
        scale: A step of ordinary size in each joint, shape (n,).
        rng: Draws the heights.
    """
    phase = np.linspace(0.0, np.pi, len(line))[:, None]
    half, whole = np.sin(phase), np.sin(2.0 * phase)
    half[-1] = whole[-1] = 0.0
    for index in count():
        spread = BEND * (1.0 + index / GROWTH) * scale
        yield line + half * rng.normal(scale=spread) + SWAY * whole * rng.normal(scale=spread)
