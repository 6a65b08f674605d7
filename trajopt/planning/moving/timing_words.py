"""A timing in words: its stops and changes of speed, their durations and causes."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import groupby

import numpy as np

from trajopt.planning.moving.blocked_cells import FREE
from trajopt.planning.moving.order_search import TimingStep
from trajopt.planning.moving.sampled_checks import SampledChecks
from trajopt.planning.moving.speed_changes import FULL, RATES, TICKS
from trajopt.values.arrays import Floats, Ints


def waits(seconds: float, cause: str = "what changes with time") -> str:
    """Return a sentence on a motion that begins later.

    Args:
        seconds: Delay [s].
        cause: Its cause.
    """
    return f"waits {seconds:.3f} s before it moves, for {cause}"


def remarks_of(
    steps: Sequence[TimingStep], pairs: Ints, checks: SampledChecks, rows: Floats, tick: float
) -> list[str]:
    """Say what a timing does that the fastest motion along its path does not.

    Args:
        steps: The timing.
        pairs: What blocks each cell, or FREE.
        checks: Names the obstacle of each pair.
        rows: Configurations at the ends of the cells.
        tick: Time of one [s].
    """
    way = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(rows, axis=0), axis=1)))
    way = way / way[-1]
    said: list[str] = []
    for delay in _delays(steps):
        cause = _cause(delay, steps, pairs, checks)
        place = f"at {way[delay.cell]:.0%} of the path"
        if delay.rests and delay.cell == 0:
            said.append(waits(delay.rests * tick, cause))
        elif delay.rests:
            said.append(f"stops {place} for {delay.rests * tick:.3f} s, for {cause}")
        else:
            said.append(f"slows down to {RATES[delay.slowest]:.0%} of its speed {place}, for {cause}")
    return said


@dataclass(frozen=True)
class _Delay:
    """A part of a timing that is not at the full rate.

    Attributes:
        cell: At whose start it rests, or is slowest first.
        slowest: Place of the slowest rate.
        rests: Ticks at rest.
        ends: The tick at which it ends.
    """

    cell: int
    slowest: int
    rests: int
    ends: int


def _delays(steps: Sequence[TimingStep]) -> Iterator[_Delay]:
    """Yield the parts that are not at the full rate, each rest by itself."""
    ends = [*(step.tick for step in steps[1:]), steps[-1].tick + steps[-1].ticks]
    both = list(zip(steps, ends, strict=True))
    for slow, part in groupby(both, key=lambda one: _slowest(one[0]) < FULL):
        if not slow:
            continue
        parts = list(part)
        rests = [(step, end) for step, end in parts if not step.cells]
        for step, end in rests:
            yield _Delay(step.begin, 0, end - step.tick, end)
        if not rests:
            slowest = min(_slowest(step) for step, _ in parts)
            cell = next(step.begin for step, _ in parts if _slowest(step) == slowest)
            yield _Delay(cell, slowest, 0, parts[-1][1])


def _slowest(step: TimingStep) -> int:
    return step.rate if step.change is None else min(step.change.before, step.change.after)


def _cause(delay: _Delay, steps: Sequence[TimingStep], pairs: Ints, checks: SampledChecks) -> str:
    """Name the object that would be in the way if the rest of the timing came earlier."""
    later = [step for step in steps if step.cells and step.tick >= delay.ends - step.ticks]
    cells = np.concatenate([np.arange(step.begin, step.begin + step.cells) for step in later])
    ticks = np.concatenate([step.tick + np.arange(step.cells) * step.ticks // step.cells for step in later])
    for sooner in range(1, delay.ends):
        earlier = np.maximum(ticks - sooner, 0) // TICKS
        hit = pairs[cells, np.minimum(earlier, pairs.shape[1] - 1)]
        if (hit != FREE).any():
            return checks.mover(int(hit[hit != FREE][0]))
    return "what changes with time"
