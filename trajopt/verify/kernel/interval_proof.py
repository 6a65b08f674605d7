"""Proof of bounds at all times by subdivision of intervals."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from trajopt.values.arrays import Floats
from trajopt.verify.certificate import Evidence
from trajopt.verify.kernel.motion import JudgedMotion, cut, pieces_needed

_FIRST_INTERVALS = 32
_MOST_INTERVALS = 200_000


@dataclass(frozen=True, eq=False)
class Excess:
    """Violation of a bound, negative if it holds.

    Attributes:
        measured: Largest measured excess in each interval, shape (c,).
        bound: Upper bound of the excess in each whole interval, shape (c,).
    """

    measured: Floats
    time: Floats
    bound: Floats


@dataclass(frozen=True)
class Proof:
    """Result on the excess over all time.

    Attributes:
        evidence: PROVEN if it is never positive, SAMPLED if a positive excess was measured, UNPROVEN
            otherwise.
        interval: First interval without a proof [s], if any.
    """

    evidence: Evidence
    time: float
    interval: tuple[float, float] | None


def prove_over_time(motion: JudgedMotion, excess: Callable[[Floats, Floats], Excess]) -> Proof:
    """Prove that an excess is never positive, or find a time at which it is.

    Args:
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
    return np.where(np.isnan(excess), np.inf, excess)
