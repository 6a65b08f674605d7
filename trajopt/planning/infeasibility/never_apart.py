"""A proof that two things come nearer than is asked of them in every configuration of the group.

Only the joints between the two move them against each other: boxes of their positions are covered, as `cover`
says. With one or two joints between, as with a forearm and a hand, some hundred boxes are enough; with more
the question is left undecided, unless some configuration shows at once that there is room.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from trajopt.geometry import Counts
from trajopt.planning.infeasibility.cover import Cover, endless, whole_range
from trajopt.scene.reduced import ReducedModel
from trajopt.values.arrays import Bools, Floats

MOST_BOXES = 60000
"""Boxes that are examined, of all pairs together, before the rest is left undecided: some tenths of a second,
spent only where the start is too near already."""
CLOSER = 0.1
"""The farthest found is rounded up by this share of what is missing: proving less takes more boxes."""


@dataclass(frozen=True, kw_only=True)
class NeverApart:
    """Two links or objects that are nearer than is asked of them in every configuration.

    Attributes:
        first: One.
        second: The other.
        distance: The distance that is asked of them [m].
        most: They are nowhere farther apart than this [m].
        farthest: The largest distance that was measured, smaller than that [m].
    """

    first: str
    second: str
    distance: float
    most: float
    farthest: float

    def words(self, lead: str) -> str:
        """Say how far they are apart at most, and what is asked of them.

        Args:
            lead: Leads from the distance to the two: "are required of".
        """
        apart = "touch"
        if self.most >= self.distance:
            measured = f"{abs(1000 * self.farthest):.1f} mm"
            apart = f"are nearer ({measured} in the farthest measured)"
            if self.farthest < 0.0:
                apart = f"overlap (by {measured} in the farthest measured)"
        elif self.most > 0.0:
            apart = f"are at most {1000 * self.most:.1f} mm apart"
        pair = f"{self.first} and {self.second}"
        return f"{1000 * self.distance:g} mm {lead} {pair}, which {apart} in every configuration"


def never_apart(
    reduced: ReducedModel, distances: Mapping[tuple[str, str], float], counts: Counts
) -> tuple[NeverApart, ...]:
    """Return the pairs that are nearer than is asked in every configuration, as far as that is proven.

    Args:
        reduced: The robot and its surroundings; joints outside the group stand still.
        distances: What is asked, by pair of links or objects [m].
        counts: Takes the work done.
    """
    owners = [frozenset(reduced.owners(pair)) for pair in range(len(reduced.pairs.first))]
    left, found = MOST_BOXES, list[NeverApart]()
    for (first, second), distance in distances.items():
        mine = np.array([pair == frozenset((first, second)) for pair in owners], dtype=np.bool_)
        box = _between(reduced, mine)
        if box is None:
            continue
        cover = Cover(reduced, left, np.where(mine, distance, -np.inf), counts)
        closed = cover.close(*box)
        left = cover.left
        if closed is None:
            continue
        less = closed.farthest + CLOSER * (distance - closed.farthest)
        tighter = Cover(reduced, left, np.where(mine, less, -np.inf), counts)
        most = distance if tighter.close(*box) is None else less
        left = tighter.left
        farthest = closed.farthest
        found.append(NeverApart(first=first, second=second, distance=distance, most=most, farthest=farthest))
    return tuple(found)


def _between(reduced: ReducedModel, pairs: Bools) -> tuple[Floats, Floats] | None:
    """Return the box of all configurations of the joints between the bodies of pairs, middle and half, (n,).

    None where one of these joints slides without end, or nothing moves.
    """
    middle, half = whole_range(reduced)
    between = np.zeros(len(half), dtype=np.bool_)
    for pair in np.flatnonzero(pairs).tolist():
        bodies = (reduced.bodies[int(each[pair])] for each in (reduced.pairs.first, reduced.pairs.second))
        one, other = (set(map(int, reduced.model.supports[body.joint])) for body in bodies)
        rows = [joint - 1 for joint in one ^ other if joint > 0]
        between |= (reduced.mimic_matrix[rows] != 0.0).any(axis=0)
    if not between.any() or (endless(reduced) & between).any():
        return None
    return middle, np.where(between, half, 0.0)
