"""Signed distance of all pairs of bodies, less the margin that each pair must keep.

Linearisation of Schulman et al., IJRR 2014, section IV: d(q + dq) = d + n . (J_second - J_first) dq
with the contact normal n from the first body to the second and the Jacobians of the witness points.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol
from weakref import WeakKeyDictionary

import numpy as np

from trajopt.problem.motion import Motion
from trajopt.problem.residual import WHOLE, Cost, Window
from trajopt.scene.reduced import ReducedModel
from trajopt.values.arrays import Floats, Ints, Rows, positive
from trajopt.values.errors import ObjectNotFound, ProblemError
from trajopt.values.errors.arguments import checked

ACTIVATION = 0.03
"""Pairs nearer than their margin and this get rows [m]; 3 to 4 cm is best."""


class MarginRule(Protocol):
    """The clearance that pairs must keep along a motion."""

    def __call__(self, pair: Ints, place: Floats) -> Floats: ...


@dataclass(frozen=True, eq=False)
class Clearance:
    """Distance less margin of every pair that is near [m]; positive is good. Components are pair indices.

    Attributes:
        margin: Clearance to keep, by pair and location; the pairs' own margins when None.
        activation: Pairs farther apart than their margin and this get no row [m].
    """

    reduced: ReducedModel
    margin: MarginRule | None = None
    activation: float = ACTIVATION
    name = "clearance"
    units = ("m",)

    def linearise(self, motion: Motion) -> Rows:
        pairs = self.reduced.pairs
        contacts = motion.query.close_pairs(motion.positions, pairs.margin + self.activation, pairs.margin)
        if self.margin is None:
            margin = pairs.margin[contacts.pair]
        else:
            margin = self.margin(contacts.pair, motion.place[contacts.sample])
        return motion.rows(contacts.sample, contacts.distance - margin, contacts.jacobian, contacts.pair)


WEIGHT = 100.0
"""Weight of a missing squared metre; two missing centimetres matter against the default costs."""


@dataclass(frozen=True)
class SoftDistance:
    """Distance below which two things cost.

    Attributes:
        weight: Of the squared shortfall [1/m^2].
    """

    distance: float
    weight: float = WEIGHT


@dataclass(frozen=True, eq=False)
class SoftClearance:
    """Shortfall of each pair below its preferred distance, times the root of its weight.

    Components are pair indices; pairs that are far enough apart have none, so the square is smooth.
    """

    every: SoftDistance
    single: Mapping[frozenset[str], SoftDistance]
    name = "soft clearance"

    def linearise(self, motion: Motion) -> Rows:
        distance, root = self.by_pair(motion.query.reduced)
        contacts = motion.query.close_pairs(motion.positions, distance)
        factor = root[contacts.pair]
        missing = factor * (distance[contacts.pair] - contacts.distance)
        return motion.rows(contacts.sample, missing, -factor[:, None] * contacts.jacobian, contacts.pair)

    def by_pair(self, reduced: ReducedModel) -> tuple[Floats, Floats]:
        """Return the preferred distance and the root of the weight of each pair, shape (p,) both.

        Raises:
            ObjectNotFound: If a single pair names neither a link nor an object.
        """
        cached = reduced.derived(_by_term)
        if self not in cached:
            cached[self] = self._found_by_pair(reduced)
        return cached[self]

    def _found_by_pair(self, reduced: ReducedModel) -> tuple[Floats, Floats]:
        owners = [frozenset(reduced.owners(pair)) for pair in range(len(reduced.pairs.first))]
        known, scene = sorted({name for pair in owners for name in pair}), reduced.scene
        for name in sorted({name for pair in self.single for name in pair}):
            named = name in scene.objects or name in scene.frame_names
            if not named or scene.owner(name) not in known:
                raise ObjectNotFound("link or object that can come near another", name, known)
        single = {frozenset(map(scene.owner, pair)): preferred for pair, preferred in self.single.items()}
        preferred = [single.get(pair, self.every) for pair in owners]
        return np.array([item.distance for item in preferred]), np.sqrt([item.weight for item in preferred])


def _by_term(reduced: ReducedModel) -> WeakKeyDictionary[SoftClearance, tuple[Floats, Floats]]:
    del reduced
    return WeakKeyDictionary()


@checked
def soft_clearance(
    distance: float,
    *,
    weight: float = WEIGHT,
    pairs: Mapping[tuple[str, str], SoftDistance] | None = None,
    window: Window = WHOLE,
) -> Cost:
    """Prefer more clearance than must be kept: a squared `Cost` on each pair's shortfall.

    Args:
        distance: Preferred distance of all pairs [m].
        weight: Of the squared shortfall [1/m^2].
        pairs: Distance and weight of single pairs of links, frames and objects, if they differ.
        window: Part of the motion in which it counts.

    Raises:
        ProblemError: If a distance is not positive, or a weight negative.
    """
    single = {frozenset(pair): preferred for pair, preferred in (pairs or {}).items()}
    every = SoftDistance(distance, weight)
    for item in (every, *single.values()):
        positive("distance of a soft clearance", item.distance)
        if not item.weight >= 0.0:
            raise ProblemError(f"weight of a soft clearance must not be negative, is {item.weight}")
    return Cost(SoftClearance(every, single), 1.0, window=window)
