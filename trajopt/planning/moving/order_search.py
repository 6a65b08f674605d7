"""Order search: the soonest way through the blocked cells of a path and time, before or after each of them.

States are (start of a cell, rate of the clock, tick). All ticks at which a state can be reached are one
integer, a bit for each: a change of ten ticks is a shift by ten, a blocked cell a mask. A robot at
rest may rest until the place is blocked. So the search is complete for the rates and
changes. Safe intervals keep only the earliest time; here a later one may be needed, since
a moving robot cannot wait.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

from trajopt.planning.moving.speed_changes import FULL, RATES, TICKS, SpeedChange

HELD = tuple(0 if rate == 0.0 else round(TICKS / rate) for rate in RATES)
"""Ticks that a cell takes at each rate."""


@dataclass(frozen=True)
class TimingStep:
    """A part of a timing.

    Attributes:
        begin: The cell at whose start it begins.
        tick: Its first tick.
        rate: Place of the rate at its start.
        change: Change of the rate; None if it is constant.
    """

    begin: int
    tick: int
    rate: int
    change: SpeedChange | None

    @property
    def ticks(self) -> int:
        """Number of ticks; 0 of a rest, which lasts until the next step."""
        return HELD[self.rate] if self.change is None else self.change.ticks

    @property
    def cells(self) -> int:
        """Number of cells that it passes."""
        return int(self.rate > 0) if self.change is None else self.change.span


@dataclass(eq=False)
class OrderSearch:
    """Finds timings among blocked cells.

    Attributes:
        blocked: Of each cell, the blocked ticks, as bits.
        changes: The changes that can begin at the start of each cell.
        ticks: Number of ticks.
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
        """Return when the robot can rest at the start of a cell."""
        beside = self.blocked[begin] | self.blocked[max(begin - 1, 0)]
        return self._whole & ~beside

    def _onward(self, begin: int) -> Iterator[tuple[TimingStep, int, int, int]]:
        """Yield the steps from the start of a cell, with their end, rate and duration."""
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
        """Return the ticks at which a step cannot begin."""
        if step.change is None:
            return self._during(step.begin, 0, HELD[step.rate])
        found = 0
        for offset, (enters, leaves) in enumerate(step.change.passed.tolist()):
            found |= self._during(step.begin + offset, enters, leaves)
        return found

    def _during(self, cell: int, enters: int, leaves: int) -> int:
        """Return the ticks so that a cell is blocked between two offsets after them."""
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
        """Return the steps that lead to a state that was reached, by those that change least."""
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
        """Return the earliest tick at which a rest can have begun that lasts until another."""
        run = self._free(begin) & ((1 << tick + 1) - 1)
        taken = ~run & ((1 << tick + 1) - 1)
        first = taken.bit_length()
        return first + self._first(self._arrived[begin] >> first)

    @staticmethod
    def _first(bits: int) -> int:
        return (bits & -bits).bit_length() - 1


def ever_over(blocked: Sequence[int], ticks: int, stays: int) -> bool:
    """Return whether a motion with immediate stops and starts might end in time; if not, no motion does.

    Args:
        blocked: Of each cell, the blocked ticks, as bits.
        ticks: Number of ticks.
        stays: Ticks for which the last cell must not be blocked after the end.
    """
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
    """Order steps that lead to the same: staying at a rate before changes, from faster before from slower."""
    return (0 if step.change is None else 1, -step.rate)
