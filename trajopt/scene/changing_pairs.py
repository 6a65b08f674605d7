"""Changing pairs: which pairs of bodies change with time by themselves, when, and how well that is known."""

from dataclasses import dataclass
from math import inf

import numpy as np

from trajopt.scene.timed import TimedModel
from trajopt.values.arrays import Bools, Floats, Ints, Printed
from trajopt.values.cached import cached_per_value


@dataclass(frozen=True, eq=False)
class ChangingPairs(Printed):
    """What is known of the pairs of which one changes with time; windows of contact are left to the judge.

    Attributes:
        changes: Whether one of the pair does, shape (p,).
        required: Clearance that is required, shape (p,) [m].
        errors: Radius, velocity and acceleration of the error, shape (p, 3).
        appears: When both are there, shape (p,) [s].
        expires: When no longer, shape (p,) [s].
    """

    changes: Bools
    required: Floats
    errors: Floats
    appears: Floats
    expires: Floats

    @staticmethod
    def of(timed: TimedModel) -> "ChangingPairs":
        """Return the pairs of a timed model; found once for each."""
        return _of(timed)

    def error_at(self, time: Floats | float, pair: Ints | slice) -> Floats:
        """Return the error of pairs at times [m]."""
        radius, velocity, acceleration = self.errors[pair].T
        return radius + velocity * time + acceleration * np.square(time) / 2.0


@cached_per_value
def _of(timed: TimedModel) -> ChangingPairs:
    pairs, bodies = timed.reduced.pairs, timed.reduced.bodies
    count = len(pairs.first)
    changes, errors = np.zeros(count, dtype=np.bool_), np.zeros((count, 3))
    appears, expires = np.full(count, -inf), np.full(count, inf)
    for pair, both in enumerate(zip(pairs.first.tolist(), pairs.second.tolist(), strict=True)):
        for body in both:
            timing = timed.timings.get(bodies[int(body)].owner)
            if timing is not None:
                changes[pair] = True
                errors[pair] += (0.0, 0.0, 0.0) if timing.motion is None else timing.motion.error
                appears[pair] = max(appears[pair], timing.appears)
                expires[pair] = min(expires[pair], timing.expires)
    changes[[pair for pair, _ in pairs.allowances]] = False
    for shared in (changes, errors, appears, expires):
        shared.setflags(write=False)
    return ChangingPairs(changes, pairs.required, errors, appears, expires)
