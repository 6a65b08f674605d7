"""Dynamic obstacles: distances from what moves, appears and expires, at configurations and times."""

from dataclasses import dataclass
from functools import cached_property
from math import inf

import numpy as np

from trajopt.geometry.evaluation import Evaluator, MakesEvaluator, WorkCounts
from trajopt.geometry.query import evaluator
from trajopt.scene.reduced import ReducedModel, TimedModel
from trajopt.scene.reducing import ChangingPairs
from trajopt.values.arrays import Bools, Floats, Ints, Printed


@dataclass(frozen=True, eq=False)
class ObstacleContacts(Printed):
    """Pairs that come near to each other at some of s configurations and times.

    Attributes:
        sample: Index of the configuration of each, shape (m,).
        pair: Index of the pair, shape (m,).
        time: The time of the configuration, shape (m,) [s].
        spare: Distance less the clearance to keep, the error not considered, shape (m,) [m].
        jacobian: Derivative of the distance by the group's positions, shape (m, n) [m/rad | 1].
    """

    pairs: ChangingPairs
    sample: Ints
    pair: Ints
    time: Floats
    spare: Floats
    jacobian: Floats

    def error(self, time: Floats | None = None) -> Floats:
        """Return the error of the obstacle of each, at its time or at others (m,) [s], shape (m,) [m]."""
        return self.pairs.error_at(self.time if time is None else time, self.pair)

    @property
    def least_spare(self) -> Floats:
        """The spare if the obstacle is as far off its track as its error at that time, shape (m,) [m]."""
        return self.spare - self.error()

    @property
    def present(self) -> Bools:
        """Whether both of the pair are present at its time, shape (m,)."""
        return self.present_within(self.time, self.time)

    def present_within(self, first: Floats, last: Floats) -> Bools:
        """Return whether both are present at some time between two, (m,) each [s], shape (m,)."""
        return (last >= self.pairs.appears[self.pair]) & (first <= self.pairs.expires[self.pair])

    def present_throughout(self, first: Floats, last: Floats) -> Bools:
        """Return whether both are present all the time between two, (m,) each [s], shape (m,)."""
        return (first >= self.pairs.appears[self.pair]) & (last <= self.pairs.expires[self.pair])


@dataclass(frozen=True, eq=False)
class DynamicObstacles(Printed):
    """The dynamic obstacles around a robot, for one thread."""

    timed: TimedModel
    query: Evaluator

    @staticmethod
    def of(
        reduced: ReducedModel, counts: WorkCounts, make: MakesEvaluator = evaluator
    ) -> "DynamicObstacles | None":
        """Return the dynamic obstacles around a robot; None if nothing in its scene changes with time."""
        timed = reduced.timed
        return None if timed is None else DynamicObstacles(timed, make(timed.reduced, counts))

    @property
    def pairs(self) -> ChangingPairs:
        """Data of all pairs: which change with time, when both are present, and the errors."""
        return ChangingPairs.of(self.timed)

    def required(self, extra: Floats | float = 0.0) -> Floats:
        """Return the required clearance of each pair that changes and an extra one, else -inf, (p,) [m]."""
        return np.where(self.pairs.changes, self.pairs.required + extra, -inf)

    def contacts(
        self,
        positions: Floats,
        times: Floats,
        kept: Floats,
        *,
        within: Floats | float = 0.0,
        until: float | None = None,
    ) -> ObstacleContacts:
        """Measure the pairs whose distance less its error may be below the clearance to keep.

        Args:
            positions: Of the group, shape (s, n) [rad | m].
            times: Shape (s,) [s].
            kept: Clearance that each pair keeps; -inf if it is not measured, shape (p,) [m].
            within: Pairs are measured if they are nearer than `kept` and this much more, (p,) or one [m].
            until: Time, not before the last, whose error decides which pairs are measured; calls with the
                same one are cheaper [s]. The last of `times` when None.
        """
        latest = float(times.max(initial=0.0)) if until is None else until
        reach = kept + self.pairs.error_at(latest, slice(None)) + within
        found = self.query.close_pairs(self.timed.positions(positions, times), reach)
        spare = found.distance - kept[found.pair]
        jacobian = found.jacobian[:, : positions.shape[1]]
        return ObstacleContacts(self.pairs, found.sample, found.pair, times[found.sample], spare, jacobian)

    def clear(self, positions: Floats, times: Floats, kept: Floats, *, until: float | None = None) -> Bools:
        """Return which configurations keep clear at their times, shape (s,); see `contacts`."""
        found, clear = self.contacts(positions, times, kept, until=until), np.ones(len(times), dtype=np.bool_)
        clear[found.sample[found.present & (found.least_spare < 0.0)]] = False
        return clear

    def moved(self, positions: Floats, times: Floats) -> Floats:
        """Bound how far any body moves from each configuration and time to the next, shape (s - 1,) [m]."""
        rows = self.timed.positions(positions, times)
        return self.query.displacement(rows[:-1], rows[1:])

    @cached_property
    def moments(self) -> Floats:
        """Times at which obstacles appear and expire, increasing [s]."""
        both = [time for timing in self.timed.timings.values() for time in (timing.appears, timing.expires)]
        return np.unique([time for time in both if 0.0 < time < inf])

    @cached_property
    def settled(self) -> float:
        """Time from which on nothing changes [s]."""
        motions = (timing.motion for timing in self.timed.timings.values())
        ends = [motion.track.end for motion in motions if motion is not None]
        return max([0.0, *ends, *self.moments.tolist()])
