"""Straight lines as a source: the first guess that solves nearly everything."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from trajopt.planning.seeds.kind import SeedKind
from trajopt.planning.seeds.source import Blocked, Guess, Ready, Route


@dataclass(frozen=True)
class StraightLines:
    """The `Source` of the one straight line of each route.

    Attributes:
        kind: What to call it: the nearest goal configuration, another, or one that is free to change.
    """

    kind: SeedKind = SeedKind.STRAIGHT

    def guesses(self, route: Route, blocked: Sequence[Blocked], rng: np.random.Generator) -> Iterator[Guess]:
        """Yield the line; see `Source.guesses`."""
        del blocked, rng
        yield Ready(route.line.knots)
