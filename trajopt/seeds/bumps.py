"""Straight lines bent to a random side: first guesses for when the straight one ends in a local minimum."""

from collections.abc import Iterator

import numpy as np

from trajopt.arrays import Floats

BEND = 0.6
"""Standard deviation of the bend in the middle, in ordinary steps of each joint."""


def bumps(line: Floats, scale: Floats, rng: np.random.Generator) -> Iterator[Floats]:
    """Yield the line plus half a sine wave of random height in every joint, without end.

    Args:
        line: Knots, shape (N, n); the ends stay.
        scale: A step of ordinary size in each joint, shape (n,).
        rng: Draws the heights.
    """
    wave = np.sin(np.linspace(0.0, np.pi, len(line)))[:, None]
    wave[-1] = 0.0
    while True:
        yield line + wave * rng.normal(scale=BEND * scale)
