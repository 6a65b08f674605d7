"""Motions along another's path that stop, slow down, or pass before."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import groupby
from math import ceil, floor

import numpy as np

from trajopt.planning.moving.order_search import (
    FULL,
    RATES,
    TICKS,
    Limited,
    OrderSearch,
    SpeedChange,
    TimingStep,
    ever_over,
    possible_changes,
)
from trajopt.planning.moving.path_time import FREE, blocked_cells
from trajopt.planning.moving.sampled_checks import INTERVAL, SampledChecks
from trajopt.robot.joints import JointLimits
from trajopt.timing import InverseDynamics
from trajopt.timing.time_scaling import TimeScaling, begun_later
from trajopt.values.arrays import Floats, Ints
from trajopt.values.trajectory import Interpolation, Trajectory

CELLS = (24, 200)
"""Least and most cells of a path: each as long as the sampling interval, within these bounds."""
SLOWER = 1.005
"""The clock is slower than the fastest by this, so that a change that holds all limits at samples does so
between them too.
"""
GROWN = (0, 1, 2)
"""Cells by which blocked regions are enlarged, in turn: a cell is sampled in its middle only."""
POINTS = 12
"""Least points of a change of speed, besides the motion's, so that the error of quintics stays below the
reserve of the slower clock.
"""
APART = 2e-4
"""Least distance of points [s]: between nearer ones rounding would cause a jerk."""


@dataclass(frozen=True, eq=False)
class TimedOnPath:
    """A motion timed among dynamic obstacles.

    Attributes:
        remarks: Its waits and changes of speed with their causes, in sentences.
    """

    trajectory: Trajectory
    remarks: tuple[str, ...]


@dataclass(eq=False)
class PathTiming:
    """Times motions among dynamic obstacles; one for each thread."""

    checks: SampledChecks
    limits: JointLimits
    inverse_dynamics: InverseDynamics | None
    dwell: float = 0.0

    def timings(self, fastest: Trajectory, until: float) -> Iterator[TimedOnPath]:
        """Yield motions along the path that seem clear and are over before `until` [s], the soonest first."""
        if fastest.interpolation is not Interpolation.QUINTIC or until <= fastest.duration:
            return
        at_rest = not fastest(0.0, 1).any()
        clock = stretched(fastest, SLOWER) if at_rest else fastest
        cells = int(np.clip(ceil(clock.duration / INTERVAL), *CELLS))
        cell = clock.duration / cells
        stays = ceil(self.dwell / cell)
        moments = floor(until / cell) + stays
        self.checks.start_at(clock(np.zeros(1)))
        edges: Floats = np.linspace(0.0, clock.duration, cells + 1)
        times: Floats = np.linspace(0.0, moments * cell, moments + 1)
        pairs = blocked_cells(self.checks, clock, edges, times, hurried=True)
        changes: Mapping[int, Sequence[SpeedChange]] = {}
        last: list[TimingStep] = []
        for grown in GROWN:
            blocked = [_bits(row) for row in _grown(pairs != FREE, grown)]
            if not ever_over(blocked, moments * TICKS, stays * TICKS):
                return
            changes = changes or possible_changes(
                Limited.of(clock, cells, self.limits, self.inverse_dynamics)
            )
            steps = OrderSearch(blocked, changes, moments * TICKS, at_rest, stays * TICKS).steps()
            if not steps:
                return
            if steps != last:
                remarks = tuple(remarks_of(steps, pairs, self.checks, clock(edges), cell / TICKS))
                yield TimedOnPath(followed(clock, steps, cell), remarks)
            last = steps


def stretched(motion: Trajectory, factor: float) -> Trajectory:
    velocities, accelerations = motion.velocities, motion.accelerations
    return replace(
        motion,
        times=motion.times * factor,
        velocities=None if velocities is None else velocities / factor,
        accelerations=None if accelerations is None else accelerations / factor**2,
    )


def _grown(blocked: Ints, by: int) -> Ints:
    for _ in range(by):
        wide = np.pad(blocked, 1)
        blocked = wide[1:-1, 1:-1] | wide[:-2, 1:-1] | wide[2:, 1:-1] | wide[1:-1, :-2] | wide[1:-1, 2:]
    return blocked


def _bits(row: Ints) -> int:
    ticks = np.repeat(row, TICKS)
    return int.from_bytes(np.packbits(ticks, bitorder="little").tobytes(), "little")


def followed(clock: Trajectory, steps: Sequence[TimingStep], cell: float) -> Trajectory:
    """Return the motion that steps make of another.

    Args:
        steps: From the start of its first cell to the end of the last.
    """
    waits = steps[0].rate == 0 and steps[0].begin == 0 and steps[0].change is None
    moving = steps[1:] if waits else steps
    begins = moving[0].tick
    rows: list[tuple[Floats, ...]] = []
    last: TimingStep | None = None
    for step in moving:
        goes_on = last is not None and last.change is None and step.change is None and last.rate == step.rate
        rows.append(_points(clock, step, cell, begins, goes_on=goes_on))
        last = step
    end = moving[-1]
    rest = np.array([(end.tick + end.ticks - begins) * cell / TICKS]), np.array([clock.duration]), *_ends(end)
    t, c, rate, first = (np.concatenate(each) for each in zip(*rows, rest, strict=True))
    kept = np.append(np.diff(t) > APART, True)
    t, c, rate, first = t[kept], c[kept], rate[kept], first[kept]
    t[0] = 0.0
    found = TimeScaling(t, c, rate, first).applied_to(clock)
    return begun_later(found, begins * cell / TICKS) if begins else found


def _ends(step: TimingStep) -> tuple[Floats, Floats]:
    rate = RATES[step.rate if step.change is None else step.change.after]
    return np.array([rate]), np.zeros(1)


def _points(
    clock: Trajectory, step: TimingStep, cell: float, begins: int, *, goes_on: bool
) -> tuple[Floats, ...]:
    """Return times, clock, rates and their derivatives at points of a step without its end.

    If it keeps the rate of the last step, its beginning is not a point.
    """
    at, since = (step.tick - begins) * cell / TICKS, step.begin * cell
    if step.change is None:
        if step.rate == 0:
            return tuple(np.array([value]) for value in (at, since, 0.0, 0.0))
        rate, end = RATES[step.rate], since + cell
        c = _inner(clock, since, end) if goes_on else np.append(since, _inner(clock, since + APART, end))
        return at + (c - since) / rate, c, np.full(len(c), rate), np.zeros(len(c))
    taken = step.change.ticks * cell / TICKS
    z = np.linspace(0.0, 1.0, 1 + 64 * step.change.span)
    inner = _inner(clock, since + APART, since + step.change.span * cell)
    exact = np.interp(inner - since, step.change.at(z, cell=cell)[0], z)
    count = max(POINTS, 2 * step.change.span)
    even = np.linspace(0.0, 1.0, count + 1)[:-1]
    beside = np.abs(even[1:, None] - exact).min(axis=1, initial=1.0) * taken < APART
    z = np.union1d(even[np.append(True, ~beside)], exact)
    c, rate, first, _ = step.change.at(z, cell=cell)
    return at + z * taken, since + c, rate, first


def _inner(clock: Trajectory, begin: float, end: float) -> Floats:
    return clock.times[(clock.times >= begin) & (clock.times < end)]


def waits(seconds: float, cause: str = "what changes with time") -> str:
    return f"waits {seconds:.3f} s before it moves, for {cause}"


def remarks_of(
    steps: Sequence[TimingStep], pairs: Ints, checks: SampledChecks, rows: Floats, tick: float
) -> list[str]:
    """Describe the stops and slower parts of a timing.

    Args:
        pairs: The pair that blocks each cell, or FREE.
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
    """A part of a timing not at the full rate.

    Attributes:
        cell: At whose start it rests, or is slowest first.
        ends: The tick at which it ends.
    """

    cell: int
    slowest: int
    rests: int
    ends: int


def _delays(steps: Sequence[TimingStep]) -> Iterator[_Delay]:
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
    later = [step for step in steps if step.cells and step.tick >= delay.ends - step.ticks]
    cells = np.concatenate([np.arange(step.begin, step.begin + step.cells) for step in later])
    ticks = np.concatenate([step.tick + np.arange(step.cells) * step.ticks // step.cells for step in later])
    for sooner in range(1, delay.ends):
        earlier = np.maximum(ticks - sooner, 0) // TICKS
        hit = pairs[cells, np.minimum(earlier, pairs.shape[1] - 1)]
        if (hit != FREE).any():
            return checks.mover(int(hit[hit != FREE][0]))
    return "what changes with time"
