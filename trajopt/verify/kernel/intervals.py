"""Intervals of time: cutting them, and the moments at which a motion is sampled where nothing is proven.

There is one every `sample_step`, or every `sample_travel` of joint motion where that is less
often: a motion takes no more samples at a hundred-thousandth of its speed than at a hundredth.
"""

import numpy as np

from trajopt.values.arrays import Floats, Ints
from trajopt.values.errors import ProblemError
from trajopt.verify.kernel.motion import Motion

MOST_PIECES = 8
"""Most pieces that an interval is cut into; the fewest are two."""


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


LEAST_OF_SLOW = 8
"""Fewest steps in which a slow piece is sampled: a quintic polynomial has six coefficients."""
MOST_MOMENTS = 1_000_000
"""A motion that would need more is not judged; this many take about 0.5 GB and a few seconds."""


def steps_in_pieces(motion: Motion) -> Ints:
    """Return into how many steps each piece of a trajectory is cut, shape (k - 1,).

    Raises:
        ProblemError: If they are too many.
    """
    times, options = motion.trajectory.times, motion.options
    lengths = np.diff(times)
    steps = np.ceil(lengths / options.sample_step)
    if (steps > LEAST_OF_SLOW).any():
        speed = motion.rates(times[:-1], times[1:], order=1).max(axis=1)
        steps = np.minimum(steps, np.maximum(LEAST_OF_SLOW, np.ceil(speed * lengths / options.sample_travel)))
    if steps.sum() > MOST_MOMENTS:
        raise ProblemError(
            f"the motion takes {motion.duration:g} s in {len(lengths)} pieces: to judge it would take "
            f"{steps.sum():.3g} samples, and {MOST_MOMENTS} are the most; judge it in parts"
        )
    return steps.astype(np.int64)


def sampled_times(motion: Motion) -> Floats:
    """Return times at which a motion is sampled where nothing is proven, its own points among them [s].

    Raises:
        ProblemError: If they are too many.
    """
    times, steps = motion.trajectory.times, steps_in_pieces(motion)
    lengths = np.diff(times)
    if (steps == np.ceil(lengths / motion.options.sample_step)).all():
        even = np.linspace(
            0.0, motion.duration, int(np.ceil(motion.duration / motion.options.sample_step)) + 1
        )
        return np.unique(np.concatenate((even, times)))
    piece = np.repeat(np.arange(len(steps)), steps)
    within = times[piece] + lengths[piece] * counting(steps) / steps[piece]
    return np.unique(np.concatenate((within, times)))
