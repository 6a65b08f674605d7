"""Berth: a wish for more clearance than must be kept, with a distance and a weight for each pair."""

from collections.abc import Mapping
from dataclasses import dataclass
from weakref import WeakKeyDictionary

import numpy as np

from trajopt.arrays import Floats
from trajopt.errors import ObjectNotFound, ProblemError
from trajopt.model.reduced import ReducedModel
from trajopt.model.requirements.requirement import positive
from trajopt.nlp import Rows
from trajopt.terms.motion import Motion
from trajopt.terms.residual import WHOLE, Cost, Window

WEIGHT = 100.0
"""Weight of a missing squared metre; beside the default costs, two missing centimetres are felt."""


@dataclass(frozen=True)
class Wished:
    """How far apart two things are wished to be.

    Attributes:
        distance: The distance [m].
        weight: Of what is missing of it, squared [1/m^2].
    """

    distance: float
    weight: float = WEIGHT


@dataclass(frozen=True, eq=False)
class Berth:
    """What is missing of the wished distance of every pair that is nearer, times the root of its weight.

    The component of a row is the index of its pair; a pair that is far enough apart has none, so the
    square of this is smooth.

    Attributes:
        every: What is wished of all pairs.
        single: What is wished of single pairs of links and objects instead.
    """

    every: Wished
    single: Mapping[frozenset[str], Wished]
    name = "berth"

    def linearise(self, motion: Motion) -> Rows:
        """Measure the pairs that are too near and differentiate; see `Clearance` for the derivative.

        Raises:
            ObjectNotFound: If a single pair names what is neither link nor object.
        """
        reduced = motion.query.reduced
        wished = reduced.derived(_by_berth)
        if self not in wished:
            wished[self] = self._by_pair(reduced)
        distance, root = wished[self]
        contacts = motion.query.close_pairs(motion.positions, distance)
        factor = root[contacts.pair]
        missing = factor * (distance[contacts.pair] - contacts.distance)
        return motion.rows(contacts.sample, missing, -factor[:, None] * contacts.jacobian, contacts.pair)

    def _by_pair(self, reduced: ReducedModel) -> tuple[Floats, Floats]:
        """Return the wished distance and the root of the weight of each pair, shape (p,) both."""
        owners = [frozenset(reduced.owners(pair)) for pair in range(len(reduced.pairs.first))]
        known = sorted({name for pair in owners for name in pair})
        for name in sorted({name for pair in self.single for name in pair}):
            if name not in known:
                raise ObjectNotFound("link or object that can come near another", name, known)
        wished = [self.single.get(pair, self.every) for pair in owners]
        return np.array([item.distance for item in wished]), np.sqrt([item.weight for item in wished])


def _by_berth(reduced: ReducedModel) -> WeakKeyDictionary[Berth, tuple[Floats, Floats]]:
    del reduced
    return WeakKeyDictionary()


def berth(
    distance: float,
    *,
    weight: float = WEIGHT,
    pairs: Mapping[tuple[str, str], Wished] | None = None,
    window: Window = WHOLE,
) -> Cost:
    """Wish for more clearance than must be kept: a squared `Cost` on what is missing of it.

    What must be kept is the scene's margin (`Scene.with_margin`, for everything or for pairs).

    Args:
        distance: How far apart all pairs are wished to be [m].
        weight: Of what is missing, squared [1/m^2].
        pairs: Distance and weight of single pairs of links and objects, where they differ.
        window: Where it counts.

    Raises:
        ProblemError: If a distance is not positive, or a weight negative.
    """
    single = {frozenset(pair): wished for pair, wished in (pairs or {}).items()}
    every = Wished(distance, weight)
    for item in (every, *single.values()):
        positive("distance of a berth", item.distance)
        if not item.weight >= 0.0:
            raise ProblemError(f"weight of a berth must not be negative, is {item.weight}")
    return Cost(Berth(every, single), 1.0, window=window)
