"""Proofs that changing objects occupy all of a box of configurations, at a time or throughout an interval.

As in a cover (`trajopt/planning/infeasibility/cover.py`): at the middle of a box a pair violates its
clearance by more than its bodies can be moved apart within the box; else the box is halved. Time drives
joints too, so an interval of time is a box of theirs. Depths are the judge's, with its stated error.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property
from math import inf

import numpy as np

from trajopt.geometry import DynamicObstacles, WorkCounts, evaluator
from trajopt.planning.infeasibility.cover import halved, pair_levers
from trajopt.scene.reduced import TimedModel
from trajopt.scene.reducing import ChangingPairs
from trajopt.values.arrays import Bools, Floats, Ints
from trajopt.verify.kernel.kinematics import Kinematics, Poses
from trajopt.verify.kernel.motion import Polynomials
from trajopt.verify.kernel.options import VerifyOptions
from trajopt.verify.kernel.pair_distances import PairDistances

CLOSEST = 3
"""Number of pairs of each box to measure precisely, the most promising first."""


@dataclass(frozen=True)
class ClosingPair:
    """A pair that closes a box, at its middle.

    Attributes:
        depth: Violation of their clearance at that place and time [m].
        travel: Bound of the distance that the two can be moved apart within the box [m].
    """

    thing: str
    link: str
    depth: float
    travel: float


@dataclass(frozen=True, kw_only=True)
class Span:
    """A time for which a changing object is too near.

    Attributes:
        begin: First time at which it is too near [s].
        end: Last such time [s]; infinite if it stays.
        depth: Violation of the clearance then [m].
    """

    thing: str
    link: str
    begin: float
    end: float
    worst: float
    depth: float

    @property
    def when(self) -> str:
        return (
            f"from {self.begin:.2f} s on" if self.end == inf else f"from {self.begin:.2f} to {self.end:.2f} s"
        )


@dataclass(eq=False)
class Occupancy:
    """Finds configurations occupied by changing objects; one for each thread."""

    timed: TimedModel
    counts: WorkCounts
    _obstacles: DynamicObstacles = field(init=False)

    def __post_init__(self) -> None:
        self._obstacles = DynamicObstacles(self.timed, evaluator(self.timed.reduced, self.counts))

    def free(self, positions: Floats, times: Floats, which: Bools | None = None) -> Bools:
        free = np.ones(len(times), dtype=np.bool_)
        free[self.too_near(positions, times, which)[0]] = False
        return free

    def met(self, positions: Floats, times: Floats, which: Bools | None = None) -> tuple[Span, ...]:
        """Return the objects that seem too near to configurations (s, n) at increasing times (s,) [s].

        Returns:
            One for each object and unbroken row of times, in order of time.
        """
        sample, pair, depth = self.too_near(positions, times, which)
        things = np.array([self.names(each)[0] for each in pair.tolist()], dtype=np.str_)
        spans: list[Span] = []
        for thing in np.unique(things).tolist():
            mine = np.flatnonzero(things == thing)
            when = np.unique(sample[mine])
            for row in np.split(when, np.flatnonzero(np.diff(when) > 1) + 1):
                inside = mine[np.isin(sample[mine], row)]
                worst = inside[depth[inside].argmax()]
                spans.append(
                    Span(
                        thing=thing,
                        link=self.names(int(pair[worst]))[1],
                        begin=float(times[row[0]]),
                        end=float(times[row[-1]]),
                        worst=float(times[sample[worst]]),
                        depth=float(depth[worst]),
                    )
                )
        return tuple(sorted(spans, key=lambda span: (span.begin, span.end)))

    def too_near(
        self, positions: Floats, times: Floats, which: Bools | None = None
    ) -> tuple[Ints, Ints, Floats]:
        """Measure configurations (s, n) at times (s,) as the optimiser does: evidence, not a proof.

        Returns:
            Indices of configurations with a pair too near, the pair, and its violation [m], shape (k,) each.
        """
        kept = self._obstacles.required()
        found = self._obstacles.contacts(
            positions, times, kept if which is None else np.where(which, kept, -inf)
        )
        near = found.present & (found.least_spare < 0.0)
        return found.sample[near], found.pair[near], -found.least_spare[near]

    def is_met(self, positions: Floats, time: float, which: Bools) -> bool:
        """Return whether a pair is proven too near at a configuration (n,) at a time [s]."""
        known, times = self._pairs, np.array((time,))
        _, pair, _ = self.too_near(positions[None], times, which)
        # At the very moments at which something appears or expires contact is accepted.
        pair = pair[(known.appears[pair] < time) & (known.expires[pair] > time)]
        poses = self._kinematics.poses(self.timed.positions(positions[None], times))
        kept = known.required[pair] + known.error_at(time, pair)
        return bool((self._farthest(poses, 0, pair) < kept).any())

    @cached_property
    def fixed(self) -> Bools:
        """Whether no joint of the group moves either of a pair, shape (p,)."""
        reduced = self.timed.reduced
        own = len(reduced.joint_names) - len(self.timed.driven.names)
        moved = np.append(False, (reduced.mimic_matrix[:, :own] != 0.0).any(axis=1))
        carried = np.array([moved[list(reduced.model.supports[body.joint])].any() for body in reduced.bodies])
        return ~(carried[reduced.pairs.first] | carried[reduced.pairs.second])

    def throughout(
        self,
        lower: Floats,
        upper: Floats,
        begin: float,
        end: float,
        *,
        most: int,
        which: Bools | None = None,
    ) -> tuple[ClosingPair, ...]:
        """Prove that objects are in the way of every configuration of a box, at all times of an interval.

        Args:
            lower: Of the group's joints, shape (n,) [rad | m].
            begin: Start of the interval [s].
            end: Its end, may be the same [s].
            most: Boxes to examine before it is left undecided.
            which: The pairs that count, shape (p,); all when None.

        Returns:
            The closing pairs, first at the middle of the whole box; empty without a proof.
        """
        first, last = self._driven(begin, end)
        low, high = np.append(lower, first), np.append(upper, last)
        if not (np.isfinite(low).all() and np.isfinite(high).all()):
            return ()
        middle, half = ((low + high) / 2.0)[None], (np.maximum(high - low, 0.0) / 2.0)[None]
        met: list[ClosingPair] = []
        while len(middle):
            most -= len(middle)
            if most < 0:
                return ()
            closed, axis = np.zeros(len(middle), dtype=np.bool_), np.zeros(len(middle), dtype=np.int64)
            for box, meeting, along in self._closing(middle, half, (begin, end), which):
                axis[box] = along
                if meeting is not None:
                    closed[box] = True
                    met.append(meeting)
                elif along < 0:
                    return ()
            middle, half = halved(middle[~closed], half[~closed], axis[~closed])
        return tuple(met)

    def _closing(
        self, middle: Floats, half: Floats, span: tuple[float, float], which: Bools | None
    ) -> Iterator[tuple[int, ClosingPair | None, int]]:
        """Yield the closing pair of each box, or None and the joint to halve it along; -1 for an open box."""
        known, (begin, end) = self._pairs, span
        # At the very moments at which something appears or expires contact is accepted.
        inside = (known.appears < begin) & (known.expires > end) if begin == end else True
        counts = known.changes if which is None else known.changes & which
        there = counts & inside & (known.appears <= begin) & (known.expires >= end)
        kept = np.where(there, known.required + known.error_at(max(begin, 0.0), slice(None)), -inf)
        reach = np.where(np.isfinite(self._levers).all(axis=1), kept, -inf)
        found = self._obstacles.query.close_pairs(middle, reach)
        poses = self._kinematics.poses(middle)
        for box in range(len(middle)):
            mine = np.flatnonzero(found.sample == box)
            travel = self._levers[found.pair[mine]] @ half[box]
            order = np.argsort(found.distance[mine] - kept[found.pair[mine]] + travel, kind="stable")
            best = mine[order[:CLOSEST]]
            if not len(best):
                yield box, None, -1
                continue
            pairs = found.pair[best]
            depth = kept[pairs] - self._farthest(poses, box, pairs)
            spare = depth - self._levers[pairs] @ half[box]
            closest = int(spare.argmax())
            pair = int(pairs[closest])
            along = int((self._levers[pair] * half[box]).argmax())
            if spare[closest] > 0.0:
                yield (
                    box,
                    self._meeting(pair, float(depth[closest]), float(depth[closest] - spare[closest])),
                    along,
                )
            else:
                yield box, None, along if depth[closest] > 0.0 else -1

    def _farthest(self, poses: Poses, box: int, pairs: Ints) -> Floats:
        error = VerifyOptions().distance_error
        measured = self._distances.measure(poses, np.full(len(pairs), box, dtype=np.int64), pairs)
        return measured + self._distances.uncertainty(pairs, measured, error)

    def _meeting(self, pair: int, depth: float, travel: float) -> ClosingPair:
        thing, link = self.names(pair)
        return ClosingPair(thing, link, depth, travel)

    def travel(self, pairs: Ints, half: Floats) -> Floats:
        """Bound how far joints move pairs apart in boxes of half widths (s, n), shape (s,) [m], or inf."""
        return np.einsum("sn,sn->s", self._levers[pairs, : half.shape[1]], half)

    def names(self, pair: int) -> tuple[str, str]:
        one, other = self.timed.reduced.owners(pair)
        return (one, other) if one in self.timed.timings else (other, one)

    def _driven(self, begin: float, end: float) -> tuple[Floats, Floats]:
        driven = self.timed.driven
        first, last = np.clip((begin, end), driven.times[0], driven.times[-1])
        if last - first < 1e-9 or not len(driven.names):
            there = driven.at(np.array((begin,)))[0]
            return there, there
        low, high = Polynomials(driven.times, driven.coefficients).range(
            np.array((first,)), np.array((last,))
        )
        return low[0], high[0]

    @property
    def _pairs(self) -> ChangingPairs:
        return self._obstacles.pairs

    @cached_property
    def _levers(self) -> Floats:
        return pair_levers(self.timed.reduced)

    @cached_property
    def _kinematics(self) -> Kinematics:
        return Kinematics(self.timed.reduced)

    @cached_property
    def _distances(self) -> PairDistances:
        return PairDistances(self._kinematics, error=VerifyOptions().distance_error)
