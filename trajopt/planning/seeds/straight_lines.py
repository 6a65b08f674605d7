"""Straight lines as a source: the seed that solves nearly everything."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from trajopt.planning.seeds.kind import SeedKind
from trajopt.planning.seeds.source import Blocked, GivenSeed, MakeSeed, SeedContext


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
