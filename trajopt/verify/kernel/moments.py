"""Moments at which a motion is looked at where nothing is proven.

There is one in every `sample_step`, or wherever a joint may have moved by `sample_travel` where that is less
often: a motion takes no more samples at a hundred-thousandth of its speed than at a hundredth.
"""

import numpy as np

from trajopt.arrays import Floats, Ints
from trajopt.errors import ProblemError
from trajopt.verify.kernel.intervals import counting
from trajopt.verify.kernel.motion import Motion

LEAST_OF_SLOW = 8
"""Steps in which a slow piece is looked at at least: a quintic polynomial has six coefficients."""
MOST_MOMENTS = 1_000_000
"""A motion that would need more is not judged; so many take about 0.5 GB and a few seconds."""


def steps_in_pieces(motion: Motion) -> Ints:
    """Return into how many steps each piece of a trajectory is cut, shape (k - 1,).

    Raises:
        ProblemError: If they are too many to look at.
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
