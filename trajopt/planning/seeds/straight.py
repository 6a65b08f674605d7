"""Straight lines in joint space, and lines bent to random sides."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import count

import numpy as np

from trajopt.geometry import WorkCounts
from trajopt.planning.seeds.source import Blocked, Check, GivenSeed, MakeSeed, SeedContext, SeedKind
from trajopt.values.arrays import Floats, Value
from trajopt.values.errors.arguments import checked


@checked
def straight_line(start: Floats, goal: Floats, knots: int) -> Floats:
    """Return knots evenly spaced between two configurations.

    Args:
        start: Shape (n,) [rad | m].
        goal: Shape (n,).
        knots: Number of knots, ends included.

    Returns:
        Shape (knots, n).
    """
    return np.linspace(start, goal, knots)


@dataclass(frozen=True)
class StraightLines:
    """The `SeedSource` of the one straight line of each context.

    Attributes:
        kind: Its kind: to the nearest goal configuration, another, or one that is free to change.
    """

    kind: SeedKind = SeedKind.STRAIGHT

    def seeds(
        self, context: SeedContext, blocked: Sequence[Blocked], rng: np.random.Generator
    ) -> Iterator[MakeSeed]:
        """Yield the line; see `Source.seeds`."""
        del blocked, rng
        yield GivenSeed(context.line.knots)


BEND = 0.6
"""Standard deviation of the first bends, in ordinary steps of each joint."""
GROWTH = 12
"""Number of lines after which the bends are twice as wide; after twice this number three times, and so on."""
SWAY = 0.5
"""Share of the whole wave, to one side and then the other, relative to the half wave."""


@dataclass(frozen=True)
class Bumps:
    """The `SeedSource` of lines bent to random sides, without end; they bend more and more.

    Attributes:
        bend: Standard deviation of the first bends, in ordinary steps of each joint.
    """

    bend: float = BEND
    kind = SeedKind.BUMP

    def seeds(
        self, context: SeedContext, blocked: Sequence[Blocked], rng: np.random.Generator
    ) -> Iterator[MakeSeed]:
        """Yield bent lines; see `Source.seeds`."""
        del blocked
        for index in count():
            spread = self.bend * (1.0 + index / GROWTH) * context.scale
            yield _Bump(context.line.knots, spread, rng.spawn(1)[0])


def bump(line: Floats, spread: Floats, rng: np.random.Generator) -> Floats:
    """Return a line plus a half and a whole sine wave of random heights in every joint.

    Args:
        line: Knots, shape (N, n); the ends stay.
        spread: Standard deviation of the half wave's height in each joint, shape (n,) [rad | m].
        rng: Draws the heights.
    """
    phase = np.linspace(0.0, np.pi, len(line))[:, None]
    half, whole = np.sin(phase), np.sin(2.0 * phase)
    half[-1] = whole[-1] = 0.0
    return line + half * rng.normal(scale=spread) + SWAY * whole * rng.normal(scale=spread)


@dataclass(frozen=True, eq=False)
class _Bump(Value):
    line: Floats
    spread: Floats
    rng: np.random.Generator

    def __call__(self, counts: WorkCounts, check: Check) -> Floats:
        del counts, check
        return bump(self.line, self.spread, self.rng)
