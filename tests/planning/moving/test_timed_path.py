"""Timing on a path: changes of speed against integration, and the search against single states."""

from collections.abc import Iterator
from itertools import pairwise

import numpy as np
import pytest

import trajopt as to
from trajopt.planning.moving.order_search import (
    FULL,
    HELD,
    RATES,
    SPANS,
    TICKS,
    Limited,
    OrderSearch,
    SpeedChange,
    TimingStep,
    change,
    ever_over,
    possible_changes,
)
from trajopt.planning.moving.timed_path import followed, stretched
from trajopt.robot.joints import JointLimits
from trajopt.timing import Retimed, retime
from trajopt.values.arrays import Floats
from trajopt.values.trajectory import Path

PAIRS = [(a, b) for a in range(len(RATES)) for b in range(len(RATES)) if a != b]
NAMES = ("one", "two", "three")
LIMITS = JointLimits(
    NAMES,
    lower=np.full(3, -9.0),
    upper=np.full(3, 9.0),
    velocity=np.array((2.0, 1.5, 3.0)),
    acceleration=np.array((6.0, 8.0, 5.0)),
    jerk=np.array((60.0, np.inf, 90.0)),
    effort=np.full(3, np.inf),
)


@pytest.fixture(scope="module")
def fastest() -> to.Trajectory:
    knots = np.array(((0.0, 0.0, 0.0), (0.5, 0.9, -0.2), (1.4, 0.7, 0.8), (1.2, -0.3, 1.5)))
    found = retime(Path(NAMES, knots), LIMITS)
    assert isinstance(found, Retimed)
    return found.trajectory


@pytest.mark.parametrize("span", SPANS[:9])
@pytest.mark.parametrize(("before", "after"), PAIRS)
def test_a_change_of_rate_passes_its_cells_in_its_ticks(before: int, after: int, span: int) -> None:
    one, cell = change(before, after, span), 0.02
    time = one.ticks * cell / TICKS
    z: Floats = np.linspace(0.0, 1.0, 20001)
    clock, rate, first, second = one.at(z, cell=cell)
    assert rate[0] == pytest.approx(RATES[before]) and rate[-1] == pytest.approx(RATES[after])
    assert abs(first[0]) < 1e-9 and abs(first[-1]) < 1e-9, "flat, so that the acceleration is continuous"
    assert rate.min() >= -1e-12 and rate.max() <= 1.0 + 1e-12, "never back, and never faster than the motion"
    # Simpson's rule, from the next derivative to each.
    for value, slope in ((clock, rate), (rate, first), (first, second)):
        steps = (slope[:-2:2] + 4.0 * slope[1:-1:2] + slope[2::2]) * time / 60000.0
        assert np.allclose(value[2::2] - value[0], np.cumsum(steps), atol=1e-9 + 1e-9 / time)
    assert clock[-1] == pytest.approx(span * cell, rel=1e-12)
    for entered, (enters, leaves) in enumerate(one.passed.tolist()):
        within = (clock >= entered * cell) & (clock <= (entered + 1) * cell)
        ticks = z[within] * one.ticks
        assert enters <= ticks.min() + 1e-3 and ticks.max() <= leaves + 1e-3
        assert leaves - enters <= np.ceil(ticks.max() - ticks.min()) + 1


def cells_of(fastest: to.Trajectory) -> tuple[to.Trajectory, int, float]:
    clock = stretched(fastest, 1.005)
    return clock, 50, clock.duration / 50


def wandering(found: dict[int, list[SpeedChange]], cells: int, rng: np.random.Generator) -> list[TimingStep]:
    """Return steps to the end of a path, with a rest wherever the motion comes to one."""
    steps, begin, tick, rate = [], 0, 0, FULL
    while begin < cells:
        ways = [one for one in found[begin] if one.before == rate and (begin or one.before)]
        if rate == 0 and begin:
            steps.append(TimingStep(begin, tick, 0, None))
            tick += int(rng.integers(1, 30))
        if ways and (rate == 0 or rng.random() < 0.5):
            one = ways[int(rng.integers(len(ways)))]
            steps.append(TimingStep(begin, tick, rate, one))
            begin, tick, rate = begin + one.span, tick + one.ticks, one.after
        elif rate:
            steps.append(TimingStep(begin, tick, rate, None))
            begin, tick = begin + 1, tick + HELD[rate]
        else:
            return []
    return steps


def test_all_limits_hold_for_any_steps(fastest: to.Trajectory) -> None:
    clock, cells, cell = cells_of(fastest)
    found = dict(possible_changes(Limited.of(clock, cells, LIMITS, None)))
    assert {one.before for ways in found.values() for one in ways} == set(range(len(RATES)))
    rng, tried = np.random.default_rng(1), 0
    for _ in range(40):
        steps = wandering(found, cells, rng)
        if not steps:
            continue
        motion = followed(clock, steps, cell)
        end = steps[-1].tick + steps[-1].ticks
        assert motion.duration == pytest.approx(end * cell / TICKS)
        t = np.linspace(0.0, motion.duration, 20011)
        q, v, a, j = (motion(t, order) for order in range(4))
        assert (np.abs(v) <= LIMITS.velocity).all() and (np.abs(a) <= LIMITS.acceleration * (1 + 1e-9)).all()
        assert (np.abs(j) <= LIMITS.jerk * (1 + 1e-6)).all()
        assert np.abs(np.diff(a, axis=0)).max() < 1.2 * 90.0 * (t[1] - t[0]) + 0.05, "no jump"
        # On the path: each position is one of the other motion.
        near = clock(np.linspace(0.0, clock.duration, 20001))
        for place in q[:: len(q) // 40]:
            assert np.linalg.norm(near - place, axis=1).min() < 2e-4
        tried += any(step.rate == 0 for step in steps)
    assert tried > 8, "motions that stop on the way"


State = tuple[int, int, int]


class SingleStates:
    """The same search, by single states (cell, rate, tick)."""

    def __init__(self, blocked: list[int], changes: dict[int, list[SpeedChange]], ticks: int) -> None:
        self.blocked, self.changes, self.ticks = blocked, changes, ticks

    def clear(self, cell: int, begin: int, end: int) -> bool:
        return end <= self.ticks and not any(self.blocked[cell] >> tick & 1 for tick in range(begin, end))

    def rests(self, begin: int, tick: int) -> bool:
        return self.clear(begin, tick, tick + 1) and self.clear(max(begin - 1, 0), tick, tick + 1)

    def onward(self, state: State) -> Iterator[State]:
        begin, rate, tick = state
        if begin == len(self.blocked):
            return
        if rate and self.clear(begin, tick, tick + HELD[rate]):
            yield begin + 1, rate, tick + HELD[rate]
        if rate == 0 and not self.rests(begin, tick):
            return
        if rate == 0 and self.rests(begin, tick + 1):
            yield begin, 0, tick + 1
        for one in self.changes[begin]:
            passed = enumerate(one.passed.tolist())
            if one.before == rate and all(
                self.clear(begin + k, tick + enters, tick + leaves) for k, (enters, leaves) in passed
            ):
                yield begin + one.span, one.after, tick + one.ticks

    def soonest(self, *, at_rest: bool) -> int | None:
        rates = range(1, FULL + 1) if at_rest else (FULL,)
        left, tick = [(0, rate, 0) for rate in rates], 0
        while at_rest and tick < self.ticks and self.rests(0, tick):
            left += [(0, rate, tick) for rate in rates]
            tick += 1
        seen = set(left)
        while left:
            new = {one for one in self.onward(left.pop()) if one not in seen and one[2] < self.ticks}
            seen |= new
            left += new
        return min((tick for begin, _, tick in seen if begin == len(self.blocked)), default=None)


@pytest.mark.parametrize("at_rest", [True, False])
def test_the_search_equals_a_search_over_single_states(*, at_rest: bool) -> None:
    rng, found, never = np.random.default_rng(5), 0, 0
    cells, ticks = 12, 160
    spans = [change(a, b, span) for a, b in PAIRS for span in (1, 2, 3, 4)]
    for _ in range(25):
        changes = {
            begin: [one for one in spans if rng.random() < 0.15 and begin + one.span <= cells]
            for begin in range(cells)
        }
        blocked = [0] * cells
        for _ in range(6):
            cell, since = int(rng.integers(cells)), int(rng.integers(5 if at_rest else 20, 120))
            for beside in range(cell, min(cell + 3, cells)):
                blocked[beside] |= ((1 << int(rng.integers(5, 40))) - 1) << since
        steps = OrderSearch(blocked, changes, ticks, at_rest).steps()
        expected = SingleStates(blocked, changes, ticks).soonest(at_rest=at_rest)
        assert (steps[-1].tick + steps[-1].ticks if steps else None) == expected
        # Stopping and going at once is no less than what a motion can do.
        over = ever_over(blocked, ticks, 0)
        assert over or expected is None
        never += not over
        if not steps:
            continue
        found += any(step.rate == 0 and step.begin for step in steps)
        assert steps[0].begin == steps[0].tick == 0
        for one, other in pairwise(steps):
            assert other.begin == one.begin + one.cells
            assert other.tick == one.tick + one.ticks if one.cells else other.tick > one.tick
            after = one.rate if one.change is None else one.change.after
            assert other.rate == after or (other.begin == 0 and one.rate == 0)
    assert found > 0 and never > 0, "some stop on the way, and some are never over"


def test_a_free_path_is_driven_without_delay_at_full_rate() -> None:
    steps = OrderSearch([0] * 30, {begin: [] for begin in range(30)}, 1000, at_rest=True).steps()
    assert [step.tick for step in steps] == [TICKS * cell for cell in range(30)]
    assert {step.rate for step in steps} == {FULL}
