"""The seeds that planning tries, and the sources of motions among dynamic obstacles, as tables."""

from collections.abc import Iterator
from dataclasses import dataclass
from enum import Enum
from itertools import chain, repeat

from trajopt.optimise.solvers import Effort
from trajopt.planning.seeds import Bumps, DetourLines, SampledPaths, SeedKind, SeedSource


@dataclass(frozen=True)
class Row:
    """A row of the table.

    Attributes:
        branches: First and last (exclusive) index of their goal configurations, nearest first;
            None for all.
        count: Number of seeds; None for all.
        to_any: Whether each seed leads to the goal configuration that it reaches first.
        bends_best: Whether the best motion is bent instead, once there is one.
    """

    source: SeedKind | None
    branches: tuple[int, int | None] = (0, None)
    count: int | None = None
    effort: Effort = Effort.FULL
    to_any: bool = False
    bends_best: bool = False


Round = tuple[Row, ...]
"""Rows whose seeds are tried in turn."""

NEAREST = 3
"""Goal configurations planned to before lines are bent; after them comes the nearest once more, with the
freedom to choose another.
"""

PROMISING: Round = (Row(None, count=3),)
"""The most promising of the seeds given up or tried briefly."""

OPENING: tuple[Round, ...] = (
    (Row(SeedKind.STRAIGHT, (0, 1), effort=Effort.TENTATIVE),),
    (Row(SeedKind.SAMPLED, count=3, to_any=True),),
    (Row(SeedKind.STRAIGHT, (1, NEAREST + 1), effort=Effort.TENTATIVE),),
    (
        Row(SeedKind.AROUND, (0, NEAREST), count=6, effort=Effort.BRIEF),
        Row(SeedKind.BUMP, (0, NEAREST + 1), count=6, effort=Effort.BRIEF, bends_best=True),
    ),
    PROMISING,
    (Row(SeedKind.STRAIGHT, (NEAREST + 1, None), effort=Effort.TENTATIVE),),
)

CYCLE: tuple[Round, ...] = (
    (Row(SeedKind.SAMPLED, count=3, to_any=True),),
    (Row(SeedKind.BUMP, (0, NEAREST + 1), count=12, effort=Effort.BRIEF, bends_best=True),),
    PROMISING,
)
"""Seeds after the opening, repeated."""

CYCLES = 3
"""Number of repetitions without a budget."""


SOURCES: dict[SeedKind, SeedSource] = {
    SeedKind.AROUND: DetourLines(),
    SeedKind.BUMP: Bumps(),
    SeedKind.SAMPLED: SampledPaths(),
}
"""Sources of the seeds of each kind, except straight lines and the caller's paths."""

GIVEN: Round = (Row(SeedKind.GIVEN, to_any=True, effort=Effort.NEAR),)
"""Seeds before all others, if the caller passes paths."""


def rounds(*, bounded: bool, given: bool = False) -> Iterator[Round]:
    """Yield the rounds in order.

    Args:
        bounded: Whether a budget ends planning: then there is no last round.
        given: Whether the caller passes paths to begin with.
    """
    cycles = repeat(CYCLE) if bounded else repeat(CYCLE, CYCLES)
    return chain((GIVEN,) * given, OPENING, chain.from_iterable(cycles))


class MotionSource(Enum):
    """Sources of motions among dynamic obstacles; each value is a description.

    The static motion is the one without dynamic obstacles.
    """

    DELAY = "the static motion unchanged, or begun later if it then ends hardly later"
    SWEPT_START = "a proof that no motion escapes an obstacle that sweeps the start"
    HARDLY_LONGER = "shape and time optimised from the static motion, for hardly more than its duration"
    LONGER = "shape and time optimised from the static motion, for a longer duration"
    TIMING = "the path of the static motion with a delay, pauses and slower parts"
    OCCUPIED_GOAL = "a proof that no motion reaches a free goal"
    OTHER_SEEDS = "shape and time optimised from the best motion, a later one, and sampled paths in time"
    UNCHANGED = "the static motion, although it does not seem clear"
    DETOUR_ALONG_TRACKS = "a motion around all places that obstacles pass"
    DETOUR_AROUND_ENDS = "a motion around the places at which obstacles end"
    ALL_SEEDS = "shape and time optimised from the seeds of the schedule"


@dataclass(frozen=True)
class DynamicRow:
    """A row of the table for dynamic obstacles.

    Attributes:
        improves: Whether it is tried if there is a motion already; it yields faster ones.
        ends: Whether its first motion ends the search: no other motion can be much faster.
        attempts: Seeds of the schedule that it attempts; 0 if it has none.
    """

    source: MotionSource
    improves: bool = False
    ends: bool = False
    attempts: int = 0


DYNAMIC: tuple[DynamicRow, ...] = (
    DynamicRow(MotionSource.DELAY, ends=True),
    DynamicRow(MotionSource.SWEPT_START),
    DynamicRow(MotionSource.HARDLY_LONGER, ends=True),
    DynamicRow(MotionSource.LONGER),
    DynamicRow(MotionSource.TIMING, improves=True),
    DynamicRow(MotionSource.OCCUPIED_GOAL),
    DynamicRow(MotionSource.OTHER_SEEDS, improves=True),
    DynamicRow(MotionSource.UNCHANGED),
    DynamicRow(MotionSource.DETOUR_ALONG_TRACKS, attempts=4),
    DynamicRow(MotionSource.DETOUR_AROUND_ENDS, attempts=4),
    DynamicRow(MotionSource.ALL_SEEDS, attempts=12),
)
"""The order of the sources among dynamic obstacles: fast ones first, and a proof before the sources that
it makes unnecessary. A detour has a straight line and three sampled paths.
"""
