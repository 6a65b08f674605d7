"""Signed distance of the pairs that change with time by themselves, less the margin that each must keep.

Linearised as `Clearance`, with what moves where it is at each sample's time.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from trajopt.geometry import Query
from trajopt.optimise.terms.clearance import ACTIVATION
from trajopt.problem.motion import Motion, MotionInTime
from trajopt.scene.timed import ChangingPairs, TimedModel
from trajopt.values.arrays import Floats, Printed, Rows
from trajopt.values.errors import ProblemError


@dataclass(frozen=True, eq=False)
class ClearanceInTime(Printed):
    """Distance less error and margin of every pair that is near at a time at which both are there [m].

    The component of a row is the index of its pair in the timed model.

    Attributes:
        timed: The model among what changes.
        query: Of the timed model; its owner's, so one per thread.
        pairs: What is known of its pairs.
        margin: Clearance to keep, shape (p,) [m].
        duration: Of the motion [s].
    """

    timed: TimedModel
    query: Query
    pairs: ChangingPairs
    margin: Floats
    duration: float
    name = "clearance in time"
    units = ("m",)

    @cached_property
    def reach(self) -> Floats:
        """Distance of interest of every pair, -inf for those that do not change, shape (p,) [m]."""
        widest = self.margin + ACTIVATION + self.pairs.error_at(self.duration, slice(None))
        return np.where(self.pairs.changes, widest, -np.inf)

    def linearise(self, motion: Motion) -> Rows:
        """Measure the near pairs at all samples and differentiate by the group's positions.

        Raises:
            ProblemError: If the motion's samples have no times.
        """
        if not isinstance(motion, MotionInTime):
            raise ProblemError(f"{self.name}: the motion has no times")
        pairs, times = self.pairs, motion.times
        found = self.query.close_pairs(self.timed.positions(motion.positions, times), self.reach)
        when = times[found.sample]
        there = (when >= pairs.appears[found.pair]) & (when <= pairs.expires[found.pair])
        pair, sample = found.pair[there], found.sample[there]
        spare = found.distance[there] - pairs.error_at(when[there], pair) - self.margin[pair]
        jacobian = found.jacobian[there][:, : motion.knots.shape[1]]
        return motion.rows(sample, spare, jacobian, pair)
