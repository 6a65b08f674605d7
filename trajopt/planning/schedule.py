"""Schedule: the seeds that planning tries, in their order, as a table.

Within a round seeds do not depend on each other's results, so a round may be tried on any number of cores:
the order of the table decides, not the order of completion.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import chain, repeat

from trajopt.planning.seeds import SeedKind


@dataclass(frozen=True)
class Row:
    """A row of the table.

    Attributes:
        source: Source of the seeds; None continues the most promising of the briefly solved ones.
        branches: First and last (exclusive) index of their goal configurations, nearest first;
            None for all.
        count: Number of seeds; None for all.
        brief: Whether they are only solved briefly: a few steps show whether a seed is promising.
        to_any: Whether each seed leads to the goal configuration that it reaches first.
        bends_best: Whether the best motion is bent instead, once there is one.
    """

    source: SeedKind | None
    branches: tuple[int, int | None] = (0, None)
    count: int | None = None
    brief: bool = False
    to_any: bool = False
    bends_best: bool = False


Round = tuple[Row, ...]
"""Rows whose seeds are tried in turn."""

NEAREST = 3
"""Goal configurations that are planned to before lines are bent; after them, in the order of branches, comes
the nearest once more, with the freedom to choose another."""

OPENING: tuple[Round, ...] = (
    (Row(SeedKind.STRAIGHT, (0, 1)),),
    (Row(SeedKind.SAMPLED, count=3, to_any=True),),
    (Row(SeedKind.STRAIGHT, (1, NEAREST + 1)),),
    (
        Row(SeedKind.AROUND, (0, NEAREST), count=6, brief=True),
        Row(SeedKind.BUMP, (0, NEAREST + 1), count=6, brief=True, bends_best=True),
    ),
    (Row(None, count=3),),
    (Row(SeedKind.STRAIGHT, (NEAREST + 1, None)),),
)
"""First seeds."""

CYCLE: tuple[Round, ...] = (
    (Row(SeedKind.SAMPLED, count=3, to_any=True),),
    (Row(SeedKind.BUMP, (0, NEAREST + 1), count=12, brief=True, bends_best=True),),
    (Row(None, count=3),),
)
"""Seeds after the opening, repeated."""

CYCLES = 3
"""Number of repetitions without a budget."""


GIVEN: Round = (Row(SeedKind.GIVEN, to_any=True),)
"""Seeds before all others, if the caller passes paths."""


def rounds(*, bounded: bool, given: bool = False) -> Iterator[Round]:
    """Yield the rounds in order.

    Args:
        bounded: Whether a budget ends planning: then there is no last round.
        given: Whether the caller passes paths to begin with.
    """
    cycles = repeat(CYCLE) if bounded else repeat(CYCLE, CYCLES)
    return chain((GIVEN,) * given, OPENING, chain.from_iterable(cycles))
