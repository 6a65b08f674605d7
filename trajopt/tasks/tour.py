"""Shortest tour through groups of nodes, one node of each.

A generalised travelling salesman problem with an open end, by local search (2-opt, Or-opt, insertion
of a group by any of its nodes, and the exact choice of nodes for a fixed order by dynamic programming) from a
nearest-neighbour tour, with random restarts from the best tour (iterated local search: Lourenço, Martin and
Stützle, Handbook of Metaheuristics, 2003).
"""

from collections import deque
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from trajopt.values.arrays import Floats, Ints

SHUFFLED = 8
"""Number of consecutive groups that a restart shuffles, each with a random node."""
KICKS = 60
"""Fewest restarts from the best tour; with more groups one for each."""
GAIN = 1e-9
"""Smallest improvement that counts [s]."""


@dataclass(frozen=True, eq=False)
class Tours:
    """Costs of tours.

    Attributes:
        start: Cost from the start to each node, shape (m,) [s].
        between: Cost from node to node, shape (m, m), finite [s].
        end: Cost from each node to the end, shape (m,) [s].
    """

    groups: Ints
    start: Floats
    between: Floats
    end: Floats

    def cost(self, tour: Ints) -> float:
        between = float(self.between[tour[:-1], tour[1:]].sum())
        return float(self.start[tour[0]]) + between + float(self.end[tour[-1]])

    def shortest(self, rng: np.random.Generator, kicks: int = KICKS) -> Ints:
        """Return the best tour found, one node of each group in order."""
        first = self.nearest_neighbour()
        best = self._improved(first, self.groups[first])
        least = self.cost(best)
        width = min(SHUFFLED, len(best))
        for _ in range(max(kicks, len(best))):
            at = int(rng.integers(len(best) - width + 1))
            others = rng.permutation(self.groups[best[at : at + width]])
            shuffled = np.array([rng.choice(np.flatnonzero(self.groups == group)) for group in others])
            changed = np.concatenate((best[:at], shuffled, best[at + width :]))
            tour = self._improved(changed, self.groups[shuffled])
            if (cost := self.cost(tour)) < least - GAIN:
                best, least = tour, cost
        return best

    def nearest_neighbour(self) -> Ints:
        left = np.ones(len(self.groups), dtype=bool)
        tour: list[int] = []
        cost = self.start
        while left.any():
            node = int(np.where(left, cost, np.inf).argmin())
            tour.append(node)
            left &= self.groups != self.groups[node]
            cost = self.between[node]
        return np.array(tour)

    def _improved(self, tour: Ints, groups: Ints) -> Ints:
        tour, cost = self._reordered(tour, groups), np.inf
        while (now := self.cost(tour)) < cost - GAIN:
            cost, before = now, tour
            tour = self.chosen(tour)
            tour = self._reordered(tour, self.groups[tour[tour != before]])
        return tour

    def chosen(self, tour: Ints) -> Ints:
        """Choose the node of each group for a fixed order of groups: the shortest path through the layers."""
        layers = [np.flatnonzero(self.groups == group) for group in self.groups[tour]]
        cost, links = self.start[layers[0]], list[Ints]()
        for before, layer in pairwise(layers):
            through = cost[:, None] + self.between[np.ix_(before, layer)]
            links.append(through.argmin(axis=0))
            cost = through.min(axis=0)
        place = int((cost + self.end[layers[-1]]).argmin())
        nodes = [layers[-1][place]]
        for layer, link in zip(layers[-2::-1], links[::-1], strict=True):
            place = int(link[place])
            nodes.append(layer[place])
        return np.array(nodes[::-1])

    def _reordered(self, tour: Ints, groups: Ints) -> Ints:
        """Apply 2-opt, Or-opt and insertions with don't-look bits (Bentley, ORSA J. on Computing, 1992)."""
        waiting = deque(groups.tolist())
        while waiting:
            group = waiting.popleft()
            place = int(np.flatnonzero(self.groups[tour] == group)[0])
            for move in (self._reversed, self._moved, self._inserted):
                other = move(tour, place)
                if other is not None:
                    changed = np.flatnonzero(other != tour)
                    first, last = max(int(changed[0]) - 1, 0), min(int(changed[-1]) + 1, len(tour) - 1)
                    ends = self.groups[other[[first, first + 1, last - 1, last]]].tolist()
                    waiting.extend(each for each in (group, *ends) if each not in waiting)
                    tour = other
                    break
        return tour

    def _reversed(self, tour: Ints, first: int) -> Ints | None:
        """Improve by 2-opt; None if no tour is shorter."""
        last = np.arange(first + 1, len(tour))
        if not len(last):
            return None
        forward = np.concatenate(([0.0], np.cumsum(self.between[tour[:-1], tour[1:]])))
        backward = np.concatenate(([0.0], np.cumsum(self.between[tour[1:], tour[:-1]])))
        into = self.start if first == 0 else self.between[tour[first - 1]]
        after = tour[last[:-1] + 1]
        left = np.append(self.between[tour[last[:-1]], after], self.end[tour[-1]])
        leaving = np.append(self.between[tour[first], after], self.end[tour[first]])
        old = into[tour[first]] + forward[last] - forward[first] + left
        new = into[tour[last]] + backward[last] - backward[first] + leaving
        best = int((new - old).argmin())
        if new[best] > old[best] - GAIN:
            return None
        end = int(last[best]) + 1
        return np.concatenate((tour[:first], tour[first:end][::-1], tour[end:]))

    def _moved(self, tour: Ints, place: int) -> Ints | None:
        """Improve by Or-opt of up to three nodes."""
        for size in (1, 2, 3):
            part, rest = tour[place : place + size], np.delete(tour, np.s_[place : place + size])
            if len(part) < size or not len(rest):
                return None
            into = np.concatenate((self.start[part[:1]], self.between[rest, part[0]]))
            out = np.concatenate((self.between[part[-1], rest], self.end[part[-1:]]))
            straight = np.concatenate(
                (self.start[rest[:1]], self.between[rest[:-1], rest[1:]], self.end[rest[-1:]])
            )
            added = into + out - straight
            best = int(added.argmin())
            if added[best] < added[place] - GAIN:
                return np.concatenate((rest[:best], part, rest[best:]))
        return None

    def _inserted(self, tour: Ints, place: int) -> Ints | None:
        """Insert a group elsewhere, by any of its nodes."""
        nodes, rest = np.flatnonzero(self.groups == self.groups[tour[place]]), np.delete(tour, place)
        if not len(rest):
            return None
        into = np.concatenate((self.start[nodes][None], self.between[np.ix_(rest, nodes)]))
        out = np.concatenate((self.between[np.ix_(nodes, rest)].T, self.end[nodes][None]))
        straight = np.concatenate(
            (self.start[rest[:1]], self.between[rest[:-1], rest[1:]], self.end[rest[-1:]])
        )
        added = into + out - straight[:, None]
        best, node = np.unravel_index(int(added.argmin()), added.shape)
        now = added[place, int((nodes == tour[place]).argmax())]
        if added[best, node] > now - GAIN:
            return None
        return np.concatenate((rest[:best], nodes[node : node + 1], rest[best:]))
