"""The straight line in joint space, and the source of it: the seed that solves nearly everything."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from trajopt.planning.seeds.kind import SeedKind
from trajopt.planning.seeds.source import Blocked, GivenSeed, MakeSeed, SeedContext
from trajopt.values.arrays import Floats
from trajopt.values.errors.arguments import checked


@checked
def straight_line(start: Floats, goal: Floats, knots: int) -> Floats:
    """Return knots evenly spaced between two configurations.

    Args:
        start: Shape (n,) [rad | m].
        goal: Shape (n,).
        knots: How many, ends included.

    Returns:
        Shape (knots, n).
    """
    return np.linspace(start, goal, knots)


@dataclass(frozen=True)
class StraightLines:
    """The `Source` of the one straight line of each context.

    Attributes:
        kind: What to call it: the nearest goal configuration, another, or one that is free to change.
    """

    kind: SeedKind = SeedKind.STRAIGHT

    def seeds(
        self, context: SeedContext, blocked: Sequence[Blocked], rng: np.random.Generator
    ) -> Iterator[MakeSeed]:
        """Yield the line; see `Source.seeds`."""
        del blocked, rng
        yield GivenSeed(context.line.knots)
