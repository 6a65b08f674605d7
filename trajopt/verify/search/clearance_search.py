"""Search for a proof that bodies keep apart at all times: conservative advancement.

A pair that is at distance d in the middle of an interval, and whose bodies travel by at most m from
there, is at distance d - m or more in all of it. Where that is not enough the interval is cut.
"""

import numpy as np

from trajopt.arrays import Bools, Floats, Ints
from trajopt.verify.kernel.distances import Distances
from trajopt.verify.kernel.intervals import counting, cut, pieces_wanted
from trajopt.verify.kernel.kinematics import Poses
from trajopt.verify.kernel.motion import Motion
from trajopt.verify.kernel.pair_travel import PairTravel
from trajopt.verify.kernel.windows import Windows
from trajopt.verify.search.clearance_record import Contact, Findings, Gap, Items, Tally

_FIRST_INTERVALS = 32
_NEAR_ENOUGH = 0.75
"""Share of the measured clearance at which a bound is near enough, however coarse the resolution."""
_SURVEYED = 65
"""Once a contact is found, all pairs are measured at so many times to find the deepest."""
_MOST_DOUBTED = 50
_FIRST_MEASURED = 64
"""Most promising items that are measured first, so that the others need not be."""


class ClearanceSearch:
    """The search; run it once.

    Attributes:
        free: What is known of the pairs at times when they must keep apart.
        accepted: The same for times when their contact is accepted.
        contacts: Contacts found that are not accepted.
        gap: First interval without proof, if the search was given up.
    """

    def __init__(self, motion: Motion, distances: Distances) -> None:
        """Set up the search over a motion."""
        self._motion, self._distances = motion, distances
        self._options, self._before = motion.options, distances.calls
        self._travel = PairTravel(motion.kinematics, distances)
        self._windows = Windows(motion.reduced.pairs, motion.duration)
        self._count = len(distances.first)
        self._required = motion.reduced.pairs.required
        self._levels, self._level = np.unique(self._required, return_inverse=True)
        self.free, self.accepted = Tally.empty(self._count), Tally.empty(self._count)
        self.contacts: list[Contact] = []
        self.gap: Gap | None = None

    def run(self) -> Findings:
        """Search until every pair is proven, a contact is found or the search is given up."""
        # At the ends, too, bodies that surfaces enclose are found: to get inside in between, or out, a strict
        # pair would have to meet. One that was let through a surface is looked for at all times.
        self._survey(np.array((0.0, self._motion.duration)))
        items = self._start()
        while len(items.cell) and self.gap is None:
            items = self._advance(items)
            if self.contacts:
                self._survey(np.linspace(0.0, self._motion.duration, _SURVEYED))
                break
        return Findings(self.free, self.accepted, tuple(self.contacts), self.gap, self._windows)

    def _survey(self, times: Floats) -> None:
        """Measure what is near at some times, of shape (c,) [s]."""
        poses = self._motion.poses(times)
        cell = np.repeat(np.arange(len(times)), self._count)
        pair = np.tile(np.arange(self._count), len(times))
        near = self._distances.apart(self._travel.centres(poses), cell, pair) <= self._required[pair]
        cell, pair = cell[near], pair[near]
        distance = self._distances.measure(poses, cell, pair)
        self._judge(pair, self._doubted(poses, cell, pair, times[cell], distance), times[cell])

    def _start(self) -> Items:
        duration = self._motion.duration
        even = np.linspace(0.0, duration, _FIRST_INTERVALS + 1)
        edges = np.unique(np.concatenate((even, self._windows.edges)))
        cells = len(edges) - 1
        return Items(
            edges[:-1],
            edges[1:],
            np.repeat(np.arange(cells), self._count),
            np.tile(np.arange(self._count), cells),
        )

    def _advance(self, items: Items) -> Items:
        """Prove what can be proven from the middle of the intervals; cut the others."""
        middle = (items.begin + items.end) / 2
        poses = self._motion.poses(middle)
        moved = self._motion.deviation(items.begin, items.end)
        centres = self._travel.centres(poses)
        travel = self._travel.bound(poses, centres, moved, items.cell, items.pair)
        time = middle[items.cell]
        accepted = self._windows.accept(time, items.pair)
        distance = self._distances.apart(centres, items.cell, items.pair)
        todo = np.flatnonzero(distance - travel <= self._target(time, items.pair))
        todo = todo[np.argsort(distance[todo], kind="stable")]
        for some in (todo[:_FIRST_MEASURED], todo[_FIRST_MEASURED:]):
            chosen = some[distance[some] - travel[some] <= self._target(time[some], items.pair[some])]
            distance[chosen] = self._measure(items, chosen, poses, travel, time)
            self._judge(items.pair[chosen], distance[chosen], time[chosen])
        bound, target = distance - travel, self._target(time, items.pair)
        proven = bound > target
        for tally, kind in ((self.free, ~accepted), (self.accepted, accepted)):
            mine = proven & kind
            np.minimum.at(tally.proven, items.pair[mine], bound[mine])
        left = ~proven
        return self._cut(items, left, travel, distance - target)

    def _measure(self, items: Items, chosen: Ints, poses: Poses, travel: Floats, time: Floats) -> Floats:
        """Measure items; a mesh in accepted contact counts as its hull, which has a depth."""
        cell, pair = items.cell[chosen], items.pair[chosen]
        distance = self._distances.measure(poses, cell, pair)
        accepted = self._windows.accept(time[chosen], pair)
        hulled = accepted & self._distances.meshed(pair) & (distance <= travel[chosen])
        hulls = self._distances.measure_hulls(poses, cell[hulled], pair[hulled])
        distance[hulled] = np.minimum(distance[hulled], hulls)
        return self._doubted(poses, cell, pair, time[chosen], distance)

    def _doubted(self, poses: Poses, cell: Ints, pair: Ints, time: Floats, distance: Floats) -> Floats:
        """Measure again, by search, what is deeper than the contact that is accepted then."""
        floor = self._windows.floor(time, pair)
        deep = np.flatnonzero((floor < 0.0) & (distance <= floor))[:_MOST_DOUBTED]
        found = self._distances.search_depths(poses, cell[deep], pair[deep])
        distance[deep] = np.maximum(distance[deep], found)
        return distance

    def _target(self, time: Floats, pair: Ints) -> Floats:
        """Return what bounds must exceed: the floor, or near the smallest distance measured; (i,) [m].

        It is the smallest distance of the pairs that must keep as far apart.
        """
        best = np.full(len(self._levels), np.inf)
        np.minimum.at(best, self._level, self.free.measured)
        least = self._levels
        near = np.maximum(best - self._options.resolution, least + _NEAR_ENOUGH * (best - least))
        wanted = np.maximum(np.minimum(near, least + self._options.far), least)[self._level[pair]]
        return np.where(self._windows.accept(time, pair), self._windows.floor(time, pair), wanted)

    def _note(self, pair: Ints, distance: Floats, time: Floats) -> None:
        """Take in measured distances, apart for times at which contact is accepted."""
        accepted = self._windows.accept(time, pair)
        for tally, mine in ((self.free, ~accepted), (self.accepted, accepted)):
            tally.note(pair[mine], distance[mine], time[mine])

    def _judge(self, pair: Ints, distance: Floats, time: Floats) -> None:
        """Take in measured distances, and note contacts that are not accepted."""
        self._note(pair, distance, time)
        self.contacts += [
            Contact(int(pair[item]), float(time[item]), float(distance[item]))
            for item in np.flatnonzero(distance <= self._windows.floor(time, pair))
        ]

    def _cut(self, items: Items, left: Bools, travel: Floats, reserve: Floats) -> Items:
        """Cut the intervals of the items left into as many pieces as their proofs seem to need."""
        cell, pair = items.cell[left], items.pair[left]
        pieces = np.zeros(len(items.begin), dtype=np.int64)
        np.maximum.at(pieces, cell, pieces_wanted(travel[left], reserve[left]))
        width = (items.end - items.begin) / np.maximum(pieces, 1)
        stuck = np.flatnonzero(width[cell] < self._options.smallest_interval)
        if self._distances.calls - self._before > self._options.most_distances:
            stuck = np.arange(len(cell))
        if len(stuck) and not self.contacts:
            first = stuck[items.begin[cell[stuck]].argmin()]
            where = cell[first]
            self.gap = Gap(int(pair[first]), float(items.begin[where]), float(items.end[where]))
        begin, end = cut(items.begin, items.end, pieces)
        copies = pieces[cell]
        first_piece = np.cumsum(pieces) - pieces
        where = np.repeat(first_piece[cell], copies) + counting(copies)
        return Items(begin, end, where, np.repeat(pair, copies))
