"""The search for a proof that bodies keep apart at all times, in plain Python."""

from dataclasses import dataclass

import numpy as np

from tests.oracles.judge_distances import PlainDistances
from trajopt.values.arrays import Bools, Floats, Ints
from trajopt.verify.kernel.clearance_search import Contact, Findings, Gap, Tally, Windows
from trajopt.verify.kernel.kinematics import Kinematics, Poses, Travel, relative_chain
from trajopt.verify.kernel.motion import JudgedMotion, counting, cut, pieces_needed

_FIRST_INTERVALS = 16
_NEAR_ENOUGH = 0.75
"""Share of the measured clearance at which a bound is near enough, however coarse the resolution."""
_SURVEYED = 65
"""Once a contact is found, all pairs are measured at so many times to find the deepest."""
_MOST_DOUBTED = 50
_FIRST_MEASURED = 64
"""Most promising items that are measured first, so that the others need not be."""


class PairTravel:
    """Bounds on the relative travel of every pair of bodies.

    Joints that carry both bodies do not count. Against a half-space on a moving link, which has no
    bound of its own, the other body is moved as seen from that link.
    """

    def __init__(self, kinematics: Kinematics, distances: PlainDistances) -> None:
        """Lay out which joints move which body against which."""
        joint = distances.joint.tolist()
        finite = np.isfinite(distances.radius)
        carrier, chains = list(joint), [kinematics.chain(number) for number in joint]
        sphere = list(range(len(joint)))
        rows: list[tuple[int, int, int, int]] = []
        for one, other in zip(distances.first.tolist(), distances.second.tolist(), strict=True):
            chain, own = relative_chain(kinematics, joint[one], joint[other])
            if finite[one] and finite[other]:
                rows.append((one, own, other, len(chain) - own))
                continue
            body, plane = (one, other) if finite[one] else (other, one)
            chain, _ = relative_chain(kinematics, joint[body], joint[plane])
            rows.append((len(chains), len(chain), plane, 0))
            carrier.append(joint[body])
            chains.append(chain)
            sphere.append(body)
        self._rows: Ints = np.array(rows, dtype=np.int64).reshape(-1, 4)
        self._bodies = len(joint)
        self._travel = Travel(
            kinematics,
            carrier=carrier,
            centre=distances.centre[sphere],
            radius=np.where(finite, distances.radius, 0.0)[sphere],
            chains=chains,
        )

    def centres(self, poses: Poses) -> Floats:
        """Place the centres of all spheres in the world, bodies first, shape (c, w, 3) [m]."""
        return self._travel.centres(poses)

    def bound(self, poses: Poses, centres: Floats, moved: Floats, cell: Ints, pair: Ints) -> Floats:
        """Bound by how much the distance of pairs can change.

        Args:
            poses: Of the robot at c configurations.
            centres: What `centres` returns.
            moved: By how much each joint moves at most, shape (c, joints) [rad | m].
            cell: Which configuration, shape (i,).
            pair: Which pair, shape (i,).

        Returns:
            Shape (i,) [m].
        """
        travel = self._travel.bound(poses, centres, moved).travel
        first, own, second, other = self._rows[pair].T
        return travel[cell, first, own] + travel[cell, second, other]


@dataclass(frozen=True, eq=False)
class Items:
    """What is still to be proven: pairs over intervals.

    Attributes:
        begin: Start of each interval, shape (c,) [s].
        end: End of each, shape (c,) [s].
        cell: Interval of each item, shape (i,).
        pair: Pair of each item, shape (i,).
    """

    begin: Floats
    end: Floats
    cell: Ints
    pair: Ints


class PlainSearch:
    """The search; run it once.

    Attributes:
        free: What is known of the pairs at times when they must keep apart.
        accepted: The same for times when their contact is accepted.
        contacts: Contacts found that are not accepted.
        gap: First interval without proof, if the search was given up.
    """

    def __init__(self, motion: JudgedMotion, distances: PlainDistances) -> None:
        """Set up the search over a motion."""
        self._motion, self._distances = motion, distances
        self._options, self._before = motion.options, distances.calls
        self._travel = PairTravel(motion.kinematics, distances)
        self._windows = Windows(motion.reduced.pairs, motion.reduced.pairs.required, motion.duration)
        self._count = len(distances.first)
        self._required = motion.reduced.pairs.required
        self._levels, self._level = np.unique(self._required, return_inverse=True)
        self.free, self.accepted = _unknown(self._count), _unknown(self._count)
        self.contacts: list[Contact] = []
        self.gap: Gap | None = None

    def run(self) -> Findings:
        """Search until every pair is proven, a contact is found or the search is given up."""
        # At the ends, too, bodies that surfaces enclose are found: to get inside in between, or out, a strict
        # pair would have to meet. One that was let through a surface is looked for at all times.
        # Like the native search, this one measures where its first intervals meet.
        self._survey(np.linspace(0.0, self._motion.duration, _FIRST_INTERVALS + 1))
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
        lowest = floor(self._windows, time, pair)
        deep = np.flatnonzero((lowest < 0.0) & (distance <= lowest))[:_MOST_DOUBTED]
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
        return np.where(self._windows.accept(time, pair), floor(self._windows, time, pair), wanted)

    def _note(self, pair: Ints, distance: Floats, time: Floats) -> None:
        """Take in measured distances, apart for times at which contact is accepted."""
        accepted = self._windows.accept(time, pair)
        for tally, mine in ((self.free, ~accepted), (self.accepted, accepted)):
            _note(tally, pair[mine], distance[mine], time[mine])

    def _judge(self, pair: Ints, distance: Floats, time: Floats) -> None:
        """Take in measured distances, and note contacts that are not accepted."""
        self._note(pair, distance, time)
        self.contacts += [
            Contact(int(pair[item]), float(time[item]), float(distance[item]))
            for item in np.flatnonzero(distance <= floor(self._windows, time, pair))
        ]

    def _cut(self, items: Items, left: Bools, travel: Floats, reserve: Floats) -> Items:
        """Cut the intervals of the items left into as many pieces as their proofs seem to need."""
        cell, pair = items.cell[left], items.pair[left]
        pieces = np.zeros(len(items.begin), dtype=np.int64)
        np.maximum.at(pieces, cell, pieces_needed(travel[left], reserve[left]))
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


def _unknown(count: int) -> Tally:
    """Start with nothing known about a number of pairs."""
    return Tally(np.full(count, np.inf), np.full(count, np.inf), np.zeros(count))


def _note(tally: Tally, pair: Ints, distance: Floats, time: Floats) -> None:
    """Take in measured distances."""
    falling = np.argsort(-distance, kind="stable")
    falling = falling[distance[falling] < tally.measured[pair[falling]]]
    tally.measured[pair[falling]] = distance[falling]
    tally.time[pair[falling]] = time[falling]


def floor(windows: Windows, time: Floats, pair: Ints) -> Floats:
    """Return what distances of pairs must exceed at times: what is required, or minus the accepted depth.

    Args:
        windows: When contact is accepted.
        time: Shape (i,) [s].
        pair: Shape (i,).

    Returns:
        Shape (i,) [m].
    """
    until, since, first_depth, last_depth = windows.rows(pair, 0.0).T
    first = np.where(time <= until, first_depth, np.inf)
    last = np.where(time >= since, last_depth, np.inf)
    depth = np.minimum(first, last)
    return np.where(np.isfinite(depth), -depth, windows.required[pair])
