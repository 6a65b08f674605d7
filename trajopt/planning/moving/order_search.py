"""The soonest way through the blocked cells of a path and time, before or after each of them.

States are (start of a cell, rate of the clock, tick); the ticks of one state are the bits of an integer. The
search is complete for the rates and changes.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache, cached_property
from math import ceil

import numpy as np

from trajopt.robot.joints import JointLimits
from trajopt.timing import InverseDynamics
from trajopt.timing.time_scaling import RateChange
from trajopt.values.arrays import Bools, Floats, Ints
from trajopt.values.trajectory import Trajectory

TICKS = 4
"""Ticks of a cell at full rate; the time of a cell is the sampling interval."""
RATES = (0.0, 0.25, 0.5, 0.8, 1.0)
"""Of the clock; TICKS divided by each is whole. More would end little sooner, and take longer to search."""
FULL = len(RATES) - 1
"""The place of the full rate."""
SPANS = (1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 96, 128, 192)
"""Cells that a change may take, later ones at most half as many again: the shortest that holds is taken."""
FINE = 4
"""Slots of a cell: the points of a motion are a few milliseconds apart, a cell twenty."""
EVEN = 9
"""Evenly spaced samples of a change beyond slots: one that begins at rest stays long in the first slot."""
SIDE = 1e-9
"""Distance of the samples on both sides of a jump of the jerk [s]."""
TOUCH = 1e-9
"""Part of a limit by which a sample may exceed it: rounding."""


@dataclass(frozen=True, eq=False)
class SpeedChange:
    """Change of the rate from one to another, anywhere on the path.

    A `RateChange` over m whole cells of the clock and a whole number of ticks: its bulge makes up the
    difference. A change is possible if its accelerations, jerks and torques (`trajopt.timing.time_scaling`)
    hold the limits at samples.

    Attributes:
        passed: Ticks at which it enters and leaves each cell, shape (span, 2).
    """

    before: int
    after: int
    span: int
    ticks: int
    passed: Ints

    def at(self, z: Floats, *, cell: float) -> tuple[Floats, Floats, Floats, Floats]:
        """Return the clock since its start, the rate and its first two derivatives by time.

        Args:
            z: Part of its time from 0 to 1, any shape.
            cell: Time of a cell on the clock [s].
        """
        a, b = RATES[self.before], RATES[self.after]
        time = self.ticks * cell / TICKS
        return RateChange(a, b, time, bulge=self.span * cell / time - (a + b) / 2.0).at(z)


@cache
def change(before: int, after: int, span: int) -> SpeedChange:
    mean = (RATES[before] + RATES[after]) / 2.0
    ticks = ceil(span * TICKS / mean - TOUCH)
    whole = SpeedChange(before, after, span, ticks, np.zeros((span, 2), dtype=np.int64))
    z = np.linspace(0.0, 1.0, 16 * span + 1)
    clock, *_ = whole.at(z, cell=1.0)
    at = np.interp(np.arange(span + 1), clock, z * ticks)
    passed = np.stack((np.floor(at[:-1] + TOUCH), np.ceil(at[1:] - TOUCH)), axis=1).astype(np.int64)
    return SpeedChange(before, after, span, ticks, passed)


@dataclass(frozen=True, eq=False)
class Limited:
    """Shares of the limits used by a motion, by its clock: middle and range of each value in a slot.

    Attributes:
        cells: Cells of the clock, of FINE slots each.
        cell: Time of each [s].
        pull: Factors of r. and r^2 in accelerations and torques, and their values at rest, as parts of the
            limits, in the middle, shape (3, slots, j).
        pull_around: Half the range of each.
        jerk: The joints' q', q'' and q''' as parts of their limits of jerk, shape (3, slots, n).
        jerk_around: Half the range of each.
    """

    cells: int
    cell: float
    pull: Floats
    pull_around: Floats
    jerk: Floats
    jerk_around: Floats

    @staticmethod
    def of(
        motion: Trajectory, cells: int, limits: JointLimits, inverse_dynamics: InverseDynamics | None
    ) -> "Limited":
        """Sample a motion that holds the limits.

        Args:
            inverse_dynamics: Torques of the joints; None if they are not limited.
        """
        edges: Floats = np.linspace(0.0, motion.duration, FINE * cells + 1)
        # Both sides of where the jerk jumps, and the ends and the middles of slots.
        points, middles = motion.times, (edges[1:] + edges[:-1]) / 2.0
        clock = np.sort(np.concatenate((edges, middles, points - SIDE, points + SIDE)))
        clock = np.clip(clock, 0.0, motion.duration)
        q, v, a, j = (motion(clock, order) for order in range(4))
        pull = np.stack((v, a, np.zeros_like(v))) / limits.acceleration
        if inverse_dynamics is not None:
            which = np.isfinite(limits.effort)
            none, effort = np.zeros_like(q), limits.effort[which]
            held = inverse_dynamics(q, none, none)[:, which]
            along = inverse_dynamics(q, none, v)[:, which] - held
            bend = inverse_dynamics(q, v, a)[:, which] - held
            pull = np.concatenate((pull, np.stack((along, bend, held)) / effort), axis=2)
        slots = np.searchsorted(clock, edges)
        return Limited(
            cells,
            motion.duration / cells,
            *_middle_and_around(pull, slots),
            *_middle_and_around(np.stack((v, a, j)) / limits.jerk, slots),
        )

    def possible(self, of: SpeedChange, begins: Ints) -> Bools:
        z, offset = _passing(of, FINE)
        _, rate, first, second = (each[:, None] for each in of.at(z, cell=self.cell))
        at = begins[:, None] * FINE + offset
        pull = _most(self.pull, self.pull_around, at, (first, rate**2, np.ones_like(rate)))
        worst: Floats = pull.max(axis=(1, 2))
        if self.jerk[0].any():
            jerk = _most(self.jerk, self.jerk_around, at, (second, 3.0 * rate * first, rate**3))
            worst = np.maximum(worst, jerk.max(axis=(1, 2)))
        return worst <= 1.0 + TOUCH


def _middle_and_around(values: Floats, slots: Ints) -> tuple[Floats, Floats]:
    ends = values[:, slots[1:]]
    most = np.maximum(np.maximum.reduceat(values, slots[:-1], axis=1), ends)
    least = np.minimum(np.minimum.reduceat(values, slots[:-1], axis=1), ends)
    return (most + least) / 2.0, (most - least) / 2.0


def _most(middle: Floats, around: Floats, at: Ints, factors: tuple[Floats, Floats, Floats]) -> Floats:
    total, apart = np.zeros(1), np.zeros(1)
    for value, off, factor in zip(middle, around, factors, strict=True):
        total, apart = total + value[at] * factor, apart + off[at] * np.abs(factor)
    return np.abs(total) + apart


@cache
def _passing(of: SpeedChange, fine: int) -> tuple[Floats, Ints]:
    z: Floats = np.linspace(0.0, 1.0, 32 * of.span * fine + 1)
    clock = of.at(z, cell=float(fine))[0]
    middles = np.interp(np.arange(of.span * fine) + 0.5, clock, z)
    times = np.union1d(middles, np.linspace(0.0, 1.0, EVEN))
    slot = np.floor(np.interp(times, z, clock)).astype(np.int64)
    return times, np.clip(slot, 0, of.span * fine - 1)


def possible_changes(limited: Limited) -> Mapping[int, list[SpeedChange]]:
    """Return the changes that can begin at the start of each cell: to each rate the shortest that holds."""
    found: dict[int, list[SpeedChange]] = {begin: [] for begin in range(limited.cells)}
    for before in range(len(RATES)):
        for after in range(len(RATES)):
            if before == after:
                continue
            left = np.arange(limited.cells)
            for span in SPANS:
                left = left[left + span <= limited.cells]
                if not len(left):
                    break
                one = change(before, after, span)
                held = limited.possible(one, left)
                for begin in left[held].tolist():
                    found[begin].append(one)
                left = left[~held]
    return found


HELD = tuple(0 if rate == 0.0 else round(TICKS / rate) for rate in RATES)
"""Ticks that a cell takes at each rate."""


@dataclass(frozen=True)
class TimingStep:
    """A part of a timing.

    Attributes:
        change: Change of the rate; None if it is constant.
    """

    begin: int
    tick: int
    rate: int
    change: SpeedChange | None

    @property
    def ticks(self) -> int:
        return HELD[self.rate] if self.change is None else self.change.ticks

    @property
    def cells(self) -> int:
        return int(self.rate > 0) if self.change is None else self.change.span


@dataclass(eq=False)
class OrderSearch:
    """Finds timings among blocked cells.

    Attributes:
        at_rest: Whether the motion begins at rest, and so may begin later and at any rate.
        stays: Ticks for which the last cell must not be blocked after the end.
    """

    blocked: Sequence[int]
    changes: Mapping[int, Sequence[SpeedChange]]
    ticks: int
    at_rest: bool
    stays: int = 0
    _reached: list[list[int]] = field(default_factory=list[list[int]])
    _arrived: list[int] = field(default_factory=list[int])
    _wide: dict[tuple[int, int], int] = field(default_factory=dict[tuple[int, int], int])

    def steps(self) -> list[TimingStep]:
        """Return the steps that are over soonest; none if no timing is clear."""
        self._search()
        over = self._whole >> self.stays
        if self.stays:
            over &= ~self._during(len(self.blocked) - 1, 0, self.stays)
        ends = [
            (self._first(bits & over), -rate) for rate, bits in enumerate(self._reached[-1]) if bits & over
        ]
        if not ends:
            return []
        tick, rate = min(ends)
        return self._traced(len(self.blocked), -rate, tick)

    @cached_property
    def _whole(self) -> int:
        return (1 << self.ticks) - 1

    def _search(self) -> None:
        cells = len(self.blocked)
        self._reached = [[0] * len(RATES) for _ in range(cells + 1)]
        self._arrived = [0] * (cells + 1)
        for begin in range(cells):
            here = self._reached[begin]
            if begin == 0:
                resting = 1 | _carried(1, self._free(0))
                here[:] = [resting] * len(RATES) if self.at_rest else [*[0] * FULL, 1]
            elif here[0]:
                self._arrived[begin] = here[0] & self._free(begin)
                here[0] = _carried(here[0], self._free(begin))
            for step, end, rate, ticks in self._onward(begin):
                if here[step.rate]:
                    clear = here[step.rate] & ~self._in_the_way(step)
                    self._reached[end][rate] |= clear << ticks & self._whole

    def _free(self, begin: int) -> int:
        beside = self.blocked[begin] | self.blocked[max(begin - 1, 0)]
        return self._whole & ~beside

    def _onward(self, begin: int) -> Iterator[tuple[TimingStep, int, int, int]]:
        for rate in range(1, len(RATES)):
            yield TimingStep(begin, 0, rate, None), begin + 1, rate, HELD[rate]
        for change in self.changes[begin]:
            if begin or change.before or not self.at_rest:
                yield (
                    TimingStep(begin, 0, change.before, change),
                    begin + change.span,
                    change.after,
                    change.ticks,
                )

    def _in_the_way(self, step: TimingStep) -> int:
        if step.change is None:
            return self._during(step.begin, 0, HELD[step.rate])
        found = 0
        for offset, (enters, leaves) in enumerate(step.change.passed.tolist()):
            found |= self._during(step.begin + offset, enters, leaves)
        return found

    def _during(self, cell: int, enters: int, leaves: int) -> int:
        if not self.blocked[cell]:
            return 0
        length = leaves - enters
        if (cell, length) not in self._wide:
            bits, done = self.blocked[cell], 1
            while done < length:
                more = min(done, length - done)
                bits |= bits >> more
                done += more
            self._wide[cell, length] = bits
        return self._wide[cell, length] >> enters

    def _traced(self, end: int, rate: int, tick: int) -> list[TimingStep]:
        into: list[list[tuple[TimingStep, int, int]]] = [[] for _ in range(end + 1)]
        for begin in range(end):
            for step, stop, after, ticks in self._onward(begin):
                into[stop].append((step, after, ticks))
        steps: list[TimingStep] = []
        while end > 0:
            if rate == 0 and end < len(self.blocked):
                since = self._since(end, tick)
                if since < tick:
                    steps.append(TimingStep(end, since, 0, None))
                tick = since
            kept = [
                (step, ticks)
                for step, after, ticks in into[end]
                if after == rate and tick >= ticks and self._could(step, tick - ticks)
            ]
            step, ticks = min(kept, key=lambda one: _effort(one[0]))
            tick -= ticks
            end, rate = step.begin, step.rate
            steps.append(TimingStep(step.begin, tick, step.rate, step.change))
        if tick > 0:
            steps.append(TimingStep(0, 0, 0, None))
        return steps[::-1]

    def _could(self, step: TimingStep, tick: int) -> bool:
        possible = self._reached[step.begin][step.rate] & ~self._in_the_way(step)
        return bool(possible >> tick & 1)

    def _since(self, begin: int, tick: int) -> int:
        run = self._free(begin) & ((1 << tick + 1) - 1)
        taken = ~run & ((1 << tick + 1) - 1)
        first = taken.bit_length()
        return first + self._first(self._arrived[begin] >> first)

    @staticmethod
    def _first(bits: int) -> int:
        return (bits & -bits).bit_length() - 1


def ever_over(blocked: Sequence[int], ticks: int, stays: int) -> bool:
    """Return whether a motion with immediate stops and starts might end in time; if not, no motion does."""
    whole, before, reached = (1 << ticks) - 1, blocked[0], 1
    for cell in blocked:
        reached = reached | _carried(reached, whole & ~(cell & before))
        passing = cell
        for tick in range(1, TICKS):
            passing |= cell >> tick
        reached = (reached & ~passing) << TICKS & whole
        before = cell
    return bool(reached & whole >> stays)


def _carried(begins: int, free: int) -> int:
    """Return all bits of the runs in `free` from the bits in `begins`, which are in `free`, upward."""
    begins &= free
    return (((free + begins) ^ free) | begins) & free


def _effort(step: TimingStep) -> tuple[int, int]:
    return (0 if step.change is None else 1, -step.rate)
