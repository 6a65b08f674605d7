"""Proof that something stays within its bounds at all times, by cutting intervals where needed."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from trajopt.values.arrays import Floats
from trajopt.verify.certificate import Evidence
from trajopt.verify.kernel.motion import Motion, cut, pieces_needed

_FIRST_INTERVALS = 32
_MOST_INTERVALS = 200_000


@dataclass(frozen=True, eq=False)
class Excess:
    """By how much something is out of its bounds; negative when within.

    Attributes:
        measured: Largest of the measured excesses in each interval, shape (c,).
        time: When it was measured, shape (c,) [s].
        bound: What the excess stays below in all of each interval, shape (c,).
    """

    measured: Floats
    time: Floats
    bound: Floats


@dataclass(frozen=True)
class Proof:
    """What was found out about the excess over all time.

    Attributes:
        evidence: PROVEN if it is never positive, SAMPLED if it was measured to be positive,
            UNPROVEN otherwise.
        time: When the measured excess is largest [s].
        interval: First interval without proof [s], if there is one.
    """

    evidence: Evidence
    time: float
    interval: tuple[float, float] | None


def prove_over_time(motion: Motion, excess: Callable[[Floats, Floats], Excess]) -> Proof:
    """Prove that an excess is never positive, or find out when it is.

    Args:
        motion: The motion.
        excess: Bounds the excess over intervals, given the start and end of each, shape (c,) [s].
            No interval spans a jump of velocity.
    """
    accepted = motion.options.excess
    even: Floats = np.linspace(0.0, motion.duration, _FIRST_INTERVALS + 1)
    knots: Floats = np.zeros(0) if motion.differentiable else motion.group[0].times
    edges: Floats = np.unique(np.concatenate((even, knots)))
    begin, end = edges[:-1], edges[1:]
    worst, when, total = -np.inf, 0.0, 0
    while len(begin):
        found = excess(begin, end)
        measured, bound = _known(found.measured), _known(found.bound)
        total += len(begin)
        at = int(measured.argmax())
        if measured[at] > worst:
            worst, when = float(measured[at]), float(found.time[at])
        if worst > accepted:
            return Proof(Evidence.SAMPLED, when, None)
        left = bound > accepted
        begin, end = begin[left], end[left]
        needed, reserve = bound[left] - measured[left], accepted - measured[left]
        pieces = pieces_needed(needed, reserve)
        narrow = (end - begin) / pieces < motion.options.smallest_interval
        if narrow.any() or total > _MOST_INTERVALS:
            return Proof(Evidence.UNPROVEN, when, (float(begin[0]), float(end[0])))
        begin, end = cut(begin, end, pieces)
    return Proof(Evidence.PROVEN, when, None)


def _known(excess: Floats) -> Floats:
    """Return excesses with the largest in the place of those that are no numbers: nothing is known there."""
    return np.where(np.isnan(excess), np.inf, excess)
