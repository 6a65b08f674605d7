"""Clearance of a motion: the pair that is nearest, and the smallest distances over time."""

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum

import numpy as np

from trajopt.geometry import evaluator
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.timed import ChangingPairs
from trajopt.values.arrays import Bools, Floats

REACHES = (0.03, 0.15, 0.6, np.inf)
"""Increasing search distances for the nearest pair [m]."""


class PairKind(Enum):
    """Kinds of pairs of bodies."""

    SURROUNDINGS = "links to surroundings"
    SELF = "links to links"
    CARRIED = "carried objects"


@dataclass(frozen=True, eq=False)
class Nearest:
    """The pair with the smallest clearance beyond the required one, at one time.

    The error of a dynamic obstacle's track is subtracted from the distance.

    Attributes:
        owners: The two links or objects.
        distance: Signed: positive apart, negative in penetration [m].
        required: Required clearance [m].
        margin: Margin of the optimiser, at least the required clearance [m].
        points: Nearest points of the two, on their tracks, in the world, shape (2, 3) [m].
        error: Error of the track [m], which is subtracted from the distance.
    """

    owners: tuple[str, str]
    distance: float
    required: float
    margin: float
    points: Floats
    error: float = 0.0


class ClearanceQuery:
    """Measures clearances along a motion; owns scratch memory, so one per thread.

    Pairs with intended contact, or with an object that does not exist at that time, are left out.

    Attributes:
        timed: The dynamic obstacles; None in a static scene.
        reduced: Robot and scene, with joints driven by time among dynamic obstacles.
        query: Evaluates them.
    """

    def __init__(self, reduced: ReducedModel, duration: float) -> None:
        """Build the query for a motion of that duration [s]."""
        self.timed = reduced.timed
        self.reduced = reduced if self.timed is None else self.timed.reduced
        self._duration = duration
        self._changing = None if self.timed is None else ChangingPairs.of(self.timed)
        self.query = evaluator(self.reduced)

    def positions(self, times: Floats, positions: Floats) -> Floats:
        """Return positions of all joints of `reduced` at times (S,), given the group's (S, n) [rad | m]."""
        return positions if self.timed is None else self.timed.positions(positions, times)

    def nearest(self, t: float, positions: Floats) -> Nearest | None:
        """Return the pair with the least clearance beyond the required one, or None without pairs.

        Args:
            t: Time [s].
            positions: The group's at that time, shape (n,) [rad | m].
        """
        return next(iter(self.nearest_pairs(t, positions, 1)), None)

    def nearest_pairs(self, t: float, positions: Floats, count: int) -> tuple[Nearest, ...]:
        """Return the pairs with the least clearance beyond the required one, the nearest first.

        Args:
            t: Time [s].
            positions: The group's at that time, shape (n,) [rad | m].
            count: Largest number of pairs.
        """
        pairs, moment = self.reduced.pairs, np.array([t])
        checked, error = ~self.meant(moment)[0], self.error(moment)[0]
        at, nearest = self.positions(moment, positions[None]), dict[frozenset[str], Nearest]()
        for reach in REACHES:
            nearest.clear()
            found = self.query.close_pairs(at, np.where(checked, reach + pairs.required + error, -np.inf))
            distance = found.distance - error[found.pair]
            for place in np.argsort(distance - pairs.required[found.pair], kind="stable").tolist():
                pair = int(found.pair[place])
                each = Nearest(
                    self.reduced.owners(pair),
                    float(distance[place]),
                    float(pairs.required[pair]),
                    float(pairs.margin[pair]),
                    np.stack((found.point_first[place], found.point_second[place])),
                    float(error[pair]),
                )
                nearest.setdefault(frozenset(each.owners), each)
                if len(nearest) == count:
                    return tuple(nearest.values())
        return tuple(nearest.values())

    def smallest(self, times: Floats, positions: Floats, reach: float) -> Mapping[PairKind, Floats]:
        """Return the smallest clearance of each kind of pair over time.

        Args:
            times: Shape (S,) [s].
            positions: The group's at those times, shape (S, n) [rad | m].
            reach: Larger clearances are not measured [m].

        Returns:
            For each kind that has pairs, shape (S,) [m]; inf beyond `reach`.
        """
        kinds = self.kinds()
        errors = self.error(times)
        found = self.query.close_pairs(self.positions(times, positions), reach + errors.max(axis=0))
        distance = found.distance - errors[found.sample, found.pair]
        counted = ~self.meant(times)[found.sample, found.pair] & (distance < reach)
        result: dict[PairKind, Floats] = {}
        for kind in PairKind:
            mine = np.array([other is kind for other in kinds], dtype=bool)
            if mine.any():
                chosen = counted & mine[found.pair]
                smallest = np.full(len(times), np.inf)
                np.minimum.at(smallest, found.sample[chosen], distance[chosen])
                result[kind] = smallest
        return result

    def meant(self, times: Floats) -> Bools:
        """Return whether each pair is excused at each time: by intended contact or absence, (S, pairs)."""
        pairs = self.reduced.pairs
        result = np.zeros((len(times), len(pairs.first)), dtype=bool)
        for pair, allowance in pairs.allowances:
            result[:, pair] |= (times < allowance.first) | (times > self._duration - allowance.last)
        if self._changing is not None:
            result |= times[:, None] < self._changing.appears
            result |= times[:, None] > self._changing.expires
        return result

    def error(self, times: Floats) -> Floats:
        """Return the track error of each pair at each time, (S,) -> (S, pairs) [m]."""
        if self._changing is None:
            return np.zeros((len(times), len(self.reduced.pairs.first)))
        return self._changing.error_at(times[:, None], slice(None))

    def kinds(self) -> tuple[PairKind, ...]:
        """Return the kind of each pair."""
        bodies, objects, robot = self.reduced.bodies, self.reduced.scene.objects, self._robot_joints
        result: list[PairKind] = []
        for a, b in zip(self.reduced.pairs.first, self.reduced.pairs.second, strict=True):
            things = [body for body in (bodies[int(a)], bodies[int(b)]) if body.owner in objects]
            if any(0 < thing.joint < robot for thing in things):
                result.append(PairKind.CARRIED)
            else:
                result.append(PairKind.SURROUNDINGS if things else PairKind.SELF)
        return tuple(result)

    @property
    def _robot_joints(self) -> int:
        """Number of the robot's joints, the world included; the others are driven by time."""
        return self.reduced.model.njoints - (0 if self.timed is None else len(self.timed.driven.names))
