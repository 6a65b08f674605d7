"""Proofs of inevitable collision: with dynamic obstacles, and from a start in motion."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise
from math import inf

import numpy as np

from trajopt.geometry import WorkCounts
from trajopt.optimise.methods.timing import stopping_motion
from trajopt.optimise.terms.joint_positions import joint_box
from trajopt.planning.infeasibility.cover import ConfigurationCover, box_breaks, pair_levers
from trajopt.planning.infeasibility.joint_bounds import at_time, by_then
from trajopt.planning.infeasibility.occupied import ClosingPair, Occupancy, Span
from trajopt.problem.problem import Problem
from trajopt.problem.requirements import Requirement
from trajopt.robot.joints import EXCESS
from trajopt.scene.reduced import TimedModel
from trajopt.values.arrays import Bools, Floats, Ints, runs_of
from trajopt.values.printed import in_length
from trajopt.values.trajectory import Trajectory

INTERVAL = 0.02
"""Sampling interval for a configuration at rest [s]: objects at 1 m/s move by 2 cm."""
LONGEST = 60.0
"""Time horizon [s]."""
FEW_BOXES, MOST_BOXES = 8, 400
"""Boxes to examine for an interval before it is halved; and for a single time or a short interval."""
LONG = 1.0
"""Longer intervals are halved first [s]: objects move too far in them."""
MOMENTS = 6
"""Moments at which a proof is tried, the most promising first."""
SAMPLES = 256
"""Reachable configurations to sample at a moment without a proof."""
SCOUTS = 32
"""Of these before a proof is tried: a clear one rules out the proof, and sampling is cheap."""
FIRST_SCOUTS = 4
"""Of these, beside the still motion, before an inevitable contact is looked for at all."""


@dataclass(frozen=True, kw_only=True)
class Sweep:
    """An obstacle that no motion within the limits escapes.

    Attributes:
        begin: Time at which it first comes too near to the robot at rest at the start [s].
        time: Time at which no motion has escaped [s].
        depth: Violation of the clearance then, for the robot at rest [m].
        travel: Bound of the distance that the two can be moved apart by then [m]; None without proof.
        boxes: Boxes that cover all configurations reachable by then; 0 without proof.
    """

    thing: str
    link: str
    begin: float
    time: float
    depth: float
    travel: float | None
    boxes: int

    @property
    def proven(self) -> bool:
        return self.boxes > 0

    @property
    def words(self) -> str:
        """Return a phrase with the obstacle, the time, and the reason why no motion escapes."""
        at = f"at {self.time:.3f} s"
        said = f"{self.thing} sweeps {self.link} at the start from {self.begin:.3f} s on"
        if self.boxes == 1 and self.travel is not None:
            return (
                f"{said}; {at} it is {in_length(self.depth)} nearer than it may be to {self.link} that "
                f"stands still, and within the limits no point of that gets farther than "
                f"{in_length(self.travel)} by then"
            )
        if self.boxes:
            return (
                f"{said}; {at} it meets everything that can be reached by then within the limits of "
                f"velocity, acceleration and jerk: boxes that cover it were closed one by one"
            )
        return f"{said}; {at} none of {SAMPLES} configurations that may be reached by then is clear of it"


@dataclass(frozen=True, kw_only=True)
class Occupied:
    """A goal that is never free.

    Attributes:
        begin: Earliest time at which a motion can be there [s].
        until: Time up to which it was examined [s]; infinite if nothing changes after.
        dwell: Required time of rest for which it is never free [s]; 0 if it is never free at all.
        longest: The longest time for which it was free [s].
    """

    things: tuple[Span, ...]
    begin: float
    until: float
    dwell: float
    longest: float
    proven: bool
    configurations: int

    @property
    def words(self) -> str:
        each = ", ".join(f"{span.thing} (at {span.link}) {span.when}" for span in self.things)
        which = f"all {self.configurations} goal configurations found are"
        which = "the goal is" if self.configurations == 1 else which
        till = "at all times" if self.until == inf else f"until at least {self.until:.2f} s"
        earliest = f", and nothing gets there before {self.begin:.2f} s" if self.begin > INTERVAL else ""
        how = f"occupied {till}"
        if self.dwell > 0.0:
            how = f"never free for {self.dwell:g} s (for {self.longest:.2f} s at the most)"
        return f"{which} {how}: {each}{earliest}"


@dataclass(eq=False)
class InTime:
    """Looks for reasons why a problem has no motion in time; one for each thread."""

    problem: Problem
    timed: TimedModel
    counts: WorkCounts
    _boxes: dict[float, tuple[Floats, Floats]] = field(
        init=False, repr=False, default_factory=dict[float, tuple[Floats, Floats]]
    )

    def may_be_inevitable(self, motion: Trajectory) -> bool:
        """Return whether at some time no known configuration is clear, a motion's included."""
        start, times = self.problem.reduced.start_positions, self.looks
        times = times[times <= motion.duration]
        times = times[~self.occupancy.free(np.tile(start, (len(times), 1)), times)]
        times = times[~self.occupancy.free(motion(times), times)]
        return bool(self._none_clear(times, FIRST_SCOUTS, None).any())

    def inevitable(self, *, proven: bool) -> Sweep | None:
        """Find an obstacle that sweeps the start and that no motion escapes.

        Obstacles of links that no joint of the group moves do not count.
        """
        # Whatever comes after the arm may have arrived sweeps no start.
        start, times = self.problem.reduced.start_positions, self._on_the_way
        moved = ~self.occupancy.fixed
        sample, pair, depth = self.occupancy.too_near(np.tile(start, (len(times), 1)), times, moved)
        rows = np.argsort(-self._spare(times[sample], pair, depth), kind="stable")
        first = np.sort(np.unique(sample[rows], return_index=True)[1])[:MOMENTS]
        likely: list[int] = rows[first].tolist()
        begin = float(times[sample].min(initial=inf))
        closed = self._none_clear(times[sample[likely]], SCOUTS, moved)
        for row in np.array(likely)[closed].tolist():
            time = float(times[sample[row]])
            met = self.occupancy.throughout(*self._by_then(time), time, time, most=MOST_BOXES, which=moved)
            if met:
                return _sweep(met, begin, time)
        for row in () if proven else likely:
            time, names = float(times[sample[row]]), self.occupancy.names(int(pair[row]))
            if self._none_clear(np.array((time,)), SAMPLES, moved).all():
                return Sweep(
                    thing=names[0], link=names[1], begin=begin, time=time, depth=float(depth[row]),
                    travel=None, boxes=0,
                )  # fmt: skip
        return None

    def goal_occupied(self, goals: Sequence[Floats], *, proven: bool) -> Occupied | None:
        """Find out whether all of the goal is occupied at all times."""
        times = self.looks[self.looks >= self.earliest]
        if not goals or not len(times) or self.goal_moves:
            return None
        spans: list[Span] = []
        longest = 0.0
        for goal in goals:
            there = np.tile(goal, (len(times), 1))
            longest = max(longest, _longest(times, self.occupancy.free(there, times)))
            if longest > 0.0 and longest >= self.problem.dwell:
                return None
            spans += self.occupancy.met(there, times)
        holds = self._never_free(times)
        if proven and not holds:
            return None
        last = float(times[-1])
        settled = self._settled <= last
        return Occupied(
            things=_joined(spans, last if settled else inf),
            begin=self.earliest,
            until=inf if settled else last,
            dwell=self.problem.dwell if longest > 0.0 else 0.0,
            longest=longest,
            proven=holds,
            configurations=len(goals),
        )

    @cached_property
    def goal_moves(self) -> bool:
        """Whether time moves a frame that the goal names."""
        return any(self._moves(goal) for goal in self.problem.goals)

    def _moves(self, goal: Requirement) -> bool:
        return any(self.problem.scene.carrier(frame) is not None for frame in goal.frames)

    def _never_free(self, times: Floats) -> bool:
        if self._settled > times[-1] and self._deadline > times[-1]:
            return False
        lower, upper = joint_box(self.problem.goals, self.problem.reduced)
        lower, upper = lower - EXCESS, upper + EXCESS  # what the judge accepts
        if self.problem.dwell > 2.0 * INTERVAL:
            return self._never_long_free(lower, upper, times)
        inside = self._moments[(self._moments > times[0]) & (self._moments < times[-1])]
        cuts: list[float] = np.unique(np.concatenate((times[:1], inside, times[-1:]))).tolist()
        return all(self._closed(lower, upper, *span) for span in pairwise((*cuts, cuts[-1])))

    def _never_long_free(self, lower: Floats, upper: Floats, times: Floats) -> bool:
        """Prove that a box is occupied at moments so near to each other that no dwell fits in between."""

        def closed(time: float) -> bool:
            return bool(self.occupancy.throughout(lower, upper, time, time, most=MOST_BOXES))

        reached, last = float(times[0]), float(times[-1])
        if not closed(last):
            return False
        while reached + self.problem.dwell < last:
            ahead = times[(times > reached) & (times <= reached + self.problem.dwell)]
            further = next((time for time in ahead[::-1].tolist() if closed(time)), None)
            if further is None:
                return False
            reached = further
        return True

    def _closed(self, lower: Floats, upper: Floats, begin: float, end: float) -> bool:
        if begin + LONG > end and self.occupancy.throughout(lower, upper, begin, end, most=FEW_BOXES):
            return True
        if end - begin < INTERVAL:
            return bool(self.occupancy.throughout(lower, upper, begin, end, most=MOST_BOXES))
        middle = (begin + end) / 2.0
        return self._closed(lower, upper, begin, middle) and self._closed(lower, upper, middle, end)

    def _spare(self, times: Floats, pairs: Ints, depths: Floats) -> Floats:
        boxes = [self._by_then(time) for time in times.tolist()]
        half = [(upper - lower) / 2.0 for lower, upper in boxes]
        return depths - self.occupancy.travel(pairs, np.array(half)) if half else depths

    def _by_then(self, time: float) -> tuple[Floats, Floats]:
        if time not in self._boxes:
            self._boxes[time] = by_then(self.problem, time)
        return self._boxes[time]

    def _none_clear(self, times: Floats, count: int, which: Bools | None) -> Bools:
        if not len(times):
            return np.zeros(0, dtype=np.bool_)
        lower, upper = np.stack([self._by_then(time) for time in times.tolist()], axis=1)
        free = self.occupancy.free(_drawn(lower, upper, count), np.repeat(times, count), which)
        return ~np.any(free.reshape(len(times), count), axis=1)

    def _under_way(self, time: float) -> bool:
        box = self._by_then(time)
        if not all(np.isfinite(side).all() for side in box):
            return False
        still = (goal for goal in self.problem.goals if not self._moves(goal))
        return any(box_breaks(goal, self.problem.reduced, *box) for goal in still)

    @property
    def earliest(self) -> float:
        """The last look by which no motion within the limits can be at the goal [s]."""
        return float(self._on_the_way[-1]) if len(self._on_the_way) else 0.0

    @cached_property
    def _on_the_way(self) -> Floats:
        looks = self.looks
        early, late = 0, len(looks)  # the goal can be reached by none of the looks before
        while early < late:
            middle = (early + late) // 2
            early, late = (middle + 1, late) if self._under_way(float(looks[middle])) else (early, middle)
        return looks[:early]

    @cached_property
    def looks(self) -> Floats:
        """Times to examine, until nothing changes or the predictions end [s]."""
        last = min(self._settled, LONGEST, self._deadline)
        return np.append(np.arange(0.0, last, INTERVAL), last)

    @property
    def _deadline(self) -> float:
        """No motion may end later: nothing is known then, or the deadline is over [s]."""
        asked = self.problem.finish_by
        return self.timed.until if asked is None else min(self.timed.until, asked)

    @cached_property
    def _settled(self) -> float:
        motions = (timing.motion for timing in self.timed.timings.values())
        ends = [motion.track.end for motion in motions if motion is not None]
        return max([0.0, *ends, *(self._moments + INTERVAL).tolist()])

    @cached_property
    def _moments(self) -> Floats:
        both = [time for timing in self.timed.timings.values() for time in (timing.appears, timing.expires)]
        return np.array([time for time in both if 0.0 < time < inf])

    @cached_property
    def occupancy(self) -> Occupancy:
        """Finder of occupied configurations."""
        return Occupancy(self.timed, self.counts)


def _drawn(lower: Floats, upper: Floats, count: int) -> Floats:
    """Draw as many configurations of each box, half of them corners, shape (boxes * count, n)."""
    share = np.random.default_rng(0).random((count, lower.shape[1]))
    share[: count // 2] = np.round(share[: count // 2])
    return (lower[:, None] + share * (upper - lower)[:, None]).reshape(-1, lower.shape[1])


STOPPING = 24
"""Moments until the joints have stopped at which a contact may be inevitable."""


@dataclass(frozen=True, kw_only=True)
class MetBraking:
    """A contact that no motion from a start in motion avoids.

    Attributes:
        time: Time at which no motion has avoided it [s].
        required: Their required clearance [m].
        boxes: Boxes that cover all configurations reachable by then; 0 without proof.
    """

    first: str
    second: str
    time: float
    required: float
    boxes: int

    @property
    def words(self) -> str:
        how = "collide"
        if self.required > 0.0:
            how = f"come nearer than the required {in_length(self.required)} or collide"
        met = f"{self.first} and {self.second} {how} at {self.time:.3f} s, however the joints brake"
        where = f"none of {SAMPLES} configurations that may be reached by then is free"
        return f"{met}: {where}" if not self.boxes else met


def met_braking(problem: Problem, counts: WorkCounts) -> MetBraking | None:
    """Find a contact that no motion from a start in motion avoids, with things that stand still."""
    reduced, times = problem.reduced, np.linspace(0.0, stopping_motion(problem).duration, STOPPING + 1)[1:]
    lower, upper = np.stack([at_time(problem, time) for time in times.tolist()], axis=1)
    if not np.isfinite((lower, upper)).all():
        return None
    query, required = problem.evaluator(reduced, counts), np.array(reduced.pairs.required)
    required[[pair for pair, _ in reduced.pairs.allowances]] = -inf

    def none_free(rows: Ints, count: int) -> Ints:
        drawn = _drawn(lower[rows], upper[rows], count)
        touching = np.isin(np.arange(len(drawn)), query.close_pairs(drawn, required).sample)
        return rows[touching.reshape(-1, count).all(axis=1)]

    middle, half = (lower + upper) / 2.0, (upper - lower) / 2.0
    met = query.close_pairs(middle, required)
    away = np.einsum("mn,mn->m", pair_levers(reduced)[met.pair], half[met.sample])
    likely_first = np.argsort(met.distance - required[met.pair] + away, kind="stable")
    sample, pair = met.sample[likely_first], met.pair[likely_first]
    closed = none_free(np.unique(sample), SCOUTS)
    likely = [row for row in dict.fromkeys(sample.tolist()) if row in closed][:MOMENTS]
    cover = ConfigurationCover(reduced, MOMENTS * MOST_BOXES, counts=counts)
    for row in likely:
        if (found := cover.close(middle[row], half[row])) is not None:
            return _met(problem, found.pairs[0], float(times[row]), found.boxes)
    for row in none_free(np.array(likely, dtype=np.int64), SAMPLES).tolist():
        names = reduced.owners(int(pair[np.argmax(sample == row)]))
        return _met(problem, names, float(times[row]), 0)
    return None


def _met(problem: Problem, names: tuple[str, str], time: float, boxes: int) -> MetBraking:
    required = problem.scene.clearance_of(*names)
    return MetBraking(first=names[0], second=names[1], time=time, required=required, boxes=boxes)


def _sweep(met: tuple[ClosingPair, ...], begin: float, time: float) -> Sweep:
    first = met[0]
    return Sweep(
        thing=first.thing, link=first.link, begin=begin, time=time, depth=first.depth, travel=first.travel,
        boxes=len(met),
    )  # fmt: skip


def _longest(times: Floats, free: Bools) -> float:
    """Return the longest unbroken time that is free, infinite if it does not end [s]."""
    ends = np.append(times, inf)
    # From the last look that was not free to the next that is not.
    runs = runs_of(free)
    return max((float(ends[end] - times[max(begin - 1, 0)]) for begin, end in runs.tolist()), default=0.0)


def _joined(spans: Sequence[Span], last: float) -> tuple[Span, ...]:
    found: list[Span] = []
    for thing in dict.fromkeys(span.thing for span in sorted(spans, key=lambda span: span.begin)):
        mine = [span for span in spans if span.thing == thing]
        end = max(span.end for span in mine)
        worst = max(mine, key=lambda span: span.depth)
        found.append(replace(worst, begin=min(span.begin for span in mine), end=inf if end == last else end))
    return tuple(found)


@dataclass(frozen=True, kw_only=True)
class FixedLinkMet:
    """An obstacle that comes too near to a link that no joint of the group moves, before a motion is over.

    Attributes:
        over: Earliest end of a motion [s]: of all motions within the limits if proven, else of those found.
    """

    span: Span
    over: float
    dwell: float
    proven: bool

    @property
    def words(self) -> str:
        over = f"no motion within the limits is over before {self.over:.2f} s"
        if not self.proven:
            over = f"the motion without what changes takes {self.over:.2f} s"
        stays = f" and then stays for {self.dwell:g} s" if self.dwell > 0.0 else ""
        return f"{met_words(self.span)}, whatever the robot does, and {over}{stays}"


def met_words(span: Span) -> str:
    return (
        f"{span.thing} meets {span.link}, which no joint of the group moves, {span.when} "
        f"({in_length(span.depth)} nearer than it may be at {span.worst:.2f} s)"
    )


@dataclass(eq=False)
class FixedLinks:
    """Checks the links that no joint of the group moves; one for each thread."""

    in_time: InTime

    def met(self, takes: float | None = None) -> FixedLinkMet | None:
        dwell, least = self.in_time.problem.dwell, self.in_time.earliest
        over = least if takes is None else max(least, takes)
        if not self._too_near(over + dwell):
            return None
        proven = self._is_met(least + dwell)
        if takes is None and not proven:
            return None
        return FixedLinkMet(span=self.spans[0], over=least if proven else over, dwell=dwell, proven=proven)

    @cached_property
    def spans(self) -> tuple[Span, ...]:
        looks = self.in_time.looks
        return self.in_time.occupancy.met(self._start(len(looks)), looks, self.in_time.occupancy.fixed)

    def _too_near(self, until: float) -> list[float]:
        looks, occupancy = self.in_time.looks, self.in_time.occupancy
        looks = looks[looks <= until]
        sample, _, depth = occupancy.too_near(self._start(len(looks)), looks, occupancy.fixed)
        return looks[sample[np.argsort(-depth, kind="stable")]].tolist()

    def _is_met(self, until: float) -> bool:
        occupancy = self.in_time.occupancy
        return any(
            occupancy.is_met(self._start(1)[0], time, occupancy.fixed) for time in self._too_near(until)[:1]
        )

    def _start(self, count: int) -> Floats:
        return np.tile(self.in_time.problem.reduced.start_positions, (count, 1))
