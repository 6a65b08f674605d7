"""Clearance of a motion: the pair that is nearest, and the smallest distances over time."""

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum

import numpy as np

from trajopt.arrays import Bools, Floats
from trajopt.model.reduced import ReducedModel
from trajopt.query import Query

REACHES = (0.03, 0.15, 0.6, np.inf)
"""Distances within which the nearest pair is searched, one after the other [m]."""


class PairKind(Enum):
    """Kinds of pairs of bodies."""

    SURROUNDINGS = "links to surroundings"
    SELF = "links to links"
    CARRIED = "carried objects"


@dataclass(frozen=True, eq=False)
class Nearest:
    """The pair with the smallest clearance beyond what is required of it, at one time.

    Attributes:
        owners: The two links or objects.
        distance: Signed: positive apart, negative in penetration [m].
        required: Clearance that is required [m].
        margin: Clearance that the optimiser keeps where it can, never less than is required [m].
        points: Nearest points of the two, in the world, shape (2, 3) [m].
    """

    owners: tuple[str, str]
    distance: float
    required: float
    margin: float
    points: Floats


class ClearanceQuery:
    """Measures clearances along a motion; owns scratch memory, so one per thread.

    A pair with intended contact at a time is left out at that time.
    """

    def __init__(self, reduced: ReducedModel, duration: float) -> None:
        """Build the query for a motion of that duration [s]."""
        self._reduced = reduced
        self._duration = duration
        self.query = Query(reduced)

    def nearest(self, t: float, positions: Floats) -> Nearest | None:
        """Return the pair with the least clearance beyond what is required, or None where nothing can meet.

        Args:
            t: Time [s].
            positions: The group's at that time, shape (n,) [rad | m].
        """
        pairs = self._reduced.pairs
        checked = ~self.meant(np.array([t]))[0]
        for reach in REACHES:
            found = self.query.close_pairs(
                positions[None], np.where(checked, reach + pairs.required, -np.inf)
            )
            if len(found.distance):
                best = int((found.distance - pairs.required[found.pair]).argmin())
                pair = int(found.pair[best])
                return Nearest(
                    self._reduced.owners(pair),
                    float(found.distance[best]),
                    float(pairs.required[pair]),
                    float(pairs.margin[pair]),
                    np.stack((found.point_first[best], found.point_second[best])),
                )
        return None

    def smallest(self, times: Floats, positions: Floats, reach: float) -> Mapping[PairKind, Floats]:
        """Return the smallest clearance of each kind of pair over time.

        Args:
            times: Shape (S,) [s].
            positions: The group's at those times, shape (S, n) [rad | m].
            reach: Clearances beyond it are not measured [m].

        Returns:
            For each kind that has pairs, shape (S,) [m]; inf where nothing is within reach.
        """
        kinds = self.kinds()
        found = self.query.close_pairs(positions, np.full(len(kinds), reach))
        counted = ~self.meant(times)[found.sample, found.pair]
        result: dict[PairKind, Floats] = {}
        for kind in PairKind:
            mine = np.array([other is kind for other in kinds], dtype=bool)
            if mine.any():
                chosen = counted & mine[found.pair]
                smallest = np.full(len(times), np.inf)
                np.minimum.at(smallest, found.sample[chosen], found.distance[chosen])
                result[kind] = smallest
        return result

    def meant(self, times: Floats) -> Bools:
        """Return whether contact of each pair is intended at each time, (S,) -> (S, pairs)."""
        pairs = self._reduced.pairs
        result = np.zeros((len(times), len(pairs.first)), dtype=bool)
        for pair, allowance in pairs.allowances:
            result[:, pair] |= (times < allowance.first) | (times > self._duration - allowance.last)
        return result

    def kinds(self) -> tuple[PairKind, ...]:
        """Return the kind of each pair."""
        bodies, objects = self._reduced.bodies, self._reduced.scene.objects
        result: list[PairKind] = []
        for a, b in zip(self._reduced.pairs.first, self._reduced.pairs.second, strict=True):
            things = [body for body in (bodies[int(a)], bodies[int(b)]) if body.owner in objects]
            if any(thing.joint > 0 for thing in things):
                result.append(PairKind.CARRIED)
            else:
                result.append(PairKind.SURROUNDINGS if things else PairKind.SELF)
        return tuple(result)
