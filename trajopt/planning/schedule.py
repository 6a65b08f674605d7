"""Schedule: which seeds planning tries, in which order, as a table.

Within a round no seed depends on what another came to, so a round may be tried on any number of cores: what
decides in the end is the order of the table, not who was first.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import chain, repeat

from trajopt.planning.seeds import SeedKind


@dataclass(frozen=True)
class Row:
    """A row of the table.

    Attributes:
        source: Where the seeds come from; None goes on with those that were looked at and came nearest.
        branches: The first of the goal configurations that they lead to, nearest first, and the one after the
            last; None for all there are.
        count: Seeds of this row; None for all there are.
        brief: Whether they are only looked at: a few steps show how promising a seed is.
        to_any: Whether each seed leads to whichever of the goal configurations it reaches first.
        bends_best: Whether the best motion so far is bent instead, once there is one.
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
"""What is tried first."""

CYCLE: tuple[Round, ...] = (
    (Row(SeedKind.SAMPLED, count=3, to_any=True),),
    (Row(SeedKind.BUMP, (0, NEAREST + 1), count=12, brief=True, bends_best=True),),
    (Row(None, count=3),),
)
"""What is tried then, over and over."""

CYCLES = 3
"""How often, where no budget says how much."""


GIVEN: Round = (Row(SeedKind.GIVEN, to_any=True),)
"""What is tried before everything else, where the caller gives paths."""


def rounds(*, bounded: bool, given: bool = False) -> Iterator[Round]:
    """Yield the rounds in order.

    Args:
        bounded: Whether a budget ends planning: then there is no last round.
        given: Whether the caller gives paths to begin with.
    """
    cycles = repeat(CYCLE) if bounded else repeat(CYCLE, CYCLES)
    return chain((GIVEN,) * given, OPENING, chain.from_iterable(cycles))
