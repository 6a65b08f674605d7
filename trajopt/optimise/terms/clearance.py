"""Signed distance of all pairs of bodies, less the margin that each pair must keep.

Linearisation of Schulman et al., IJRR 2014, section IV: d(q + dq) = d + n . (J_second - J_first) dq
with the contact normal n from the first body to the second and the Jacobians of the witness points.
"""

from dataclasses import dataclass
from typing import Protocol

from trajopt.problem.motion import Motion
from trajopt.scene.reduced import ReducedModel
from trajopt.values.arrays import Floats, Ints, Rows

ACTIVATION = 0.03
"""Pairs get rows when nearer than their margin and this [m]; 3 to 4 cm is best."""


class MarginRule(Protocol):
    """The clearance that pairs must keep along a motion."""

    def __call__(self, pair: Ints, place: Floats) -> Floats:
        """Return the margin of each pair at each location, in knots, shape (m,) [m]."""
        ...


@dataclass(frozen=True, eq=False)
class Clearance:
    """Distance less margin of every pair that is near [m]; positive is good.

    The component of a row is the index of its pair.

    Attributes:
        reduced: The robot and its surroundings.
        margin: Clearance to keep, by pair and location; the pairs' own margins when None.
        activation: Pairs farther apart than their margin and this get no row [m].
    """

    reduced: ReducedModel
    margin: MarginRule | None = None
    activation: float = ACTIVATION
    name = "clearance"
    units = ("m",)

    def linearise(self, motion: Motion) -> Rows:
        """Measure the near pairs at all samples and differentiate."""
        pairs = self.reduced.pairs
        contacts = motion.query.close_pairs(motion.positions, pairs.margin + self.activation)
        if self.margin is None:
            margin = pairs.margin[contacts.pair]
        else:
            margin = self.margin(contacts.pair, motion.place[contacts.sample])
        return motion.rows(contacts.sample, contacts.distance - margin, contacts.jacobian, contacts.pair)
