"""Cutting time intervals into pieces."""

import numpy as np

from trajopt.arrays import Floats, Ints

MOST_PIECES = 8
"""An interval is cut into so many pieces at most, and into two at least."""


def pieces_needed(needed: Floats, reserve: Floats) -> Ints:
    """Return into how many pieces to cut intervals so that a bound probably falls below a reserve.

    Args:
        needed: What the bound is in the whole interval, shape (c,); it falls with the length.
        reserve: What it may be, shape (c,).
    """
    wanted = np.ceil(1.25 * needed / np.maximum(reserve, 1e-12))
    return np.clip(wanted, 2, MOST_PIECES).astype(np.int64)


def cut(begin: Floats, end: Floats, pieces: Ints) -> tuple[Floats, Floats]:
    """Cut intervals into equal pieces that leave no gap.

    Args:
        begin: Start of each interval, shape (c,) [s].
        end: End of each, shape (c,) [s].
        pieces: Into how many pieces, 0 to leave one out, shape (c,).

    Returns:
        Start and end of the pieces, in order.
    """
    parent = np.repeat(np.arange(len(pieces)), pieces)
    step = counting(pieces)
    width = ((end - begin) / np.maximum(pieces, 1))[parent]
    left = begin[parent] + step * width
    right = np.where(step + 1 == pieces[parent], end[parent], begin[parent] + (step + 1) * width)
    return left, right


def counting(pieces: Ints) -> Ints:
    """Count from 0 within each of some groups of given sizes: (2, 3) -> (0, 1, 0, 1, 2)."""
    total = int(pieces.sum())
    return np.arange(total, dtype=np.int64) - np.repeat(np.cumsum(pieces) - pieces, pieces)
