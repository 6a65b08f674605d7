"""Straight lines in joint space, and lines bent to random sides."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import count

import numpy as np

from trajopt.geometry import Evaluator, WorkCounts, point_jacobian
from trajopt.planning.seeds.source import Blocked, Check, GivenSeed, MakeSeed, NoSeed, SeedContext, SeedKind
from trajopt.values.arrays import Floats, Value
from trajopt.values.errors.arguments import checked


@checked
def straight_line(start: Floats, goal: Floats, knots: int) -> Floats:
    """Return knots evenly spaced between two configurations, shape (knots, n) [rad | m], ends included."""
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
        del blocked
        for index in count():
            spread = self.bend * (1.0 + index / GROWTH) * context.scale
            yield _Bump(context.line.knots, spread, rng.spawn(1)[0])


def bump(line: Floats, spread: Floats, rng: np.random.Generator) -> Floats:
    """Return a line (N, n) plus a half and a whole sine wave of random heights in every joint.

    Args:
        spread: Standard deviation of the half wave's height in each joint, shape (n,) [rad | m].
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


SIZES = (0.15, 0.35)
"""Displacements of the touching point [m]; every side once, then every side again."""
SIDES = 4
"""Over, under, left and right."""
STEPS = 6
"""Steps that the point is moved in."""
LONGEST_STEP = 0.4
"""Largest motion of a joint in a step, in ordinary steps."""
DAMPING = 0.05
"""Of the inverse of the point's Jacobian [m/rad]."""
QUERY_DISTANCE = 0.2
"""Distance within which the contact is looked up again: the pair touched there a moment ago [m]."""
NEARBY = 0.5
"""Number of knots before and after between which the point's way is measured."""
STILL = 1e-6
"""Ways shorter than this have no direction [m]."""


@dataclass(frozen=True)
class DetourLines:
    """The `Source` of lines bent around obstacles.

    The sides are across the touching point's way, in the world; first comes the side that the contact pushes
    to. The point is moved in small steps with the damped inverse of its Jacobian (Nakamura and Hanafusa
    1986); the bend dies away towards the ends of its leg.
    """

    kind = SeedKind.AROUND

    def seeds(
        self, context: SeedContext, blocked: Sequence[Blocked], rng: np.random.Generator
    ) -> Iterator[MakeSeed]:
        del rng
        for size in SIZES:
            for side in range(SIDES):
                for item in blocked:
                    yield _Bent(context, item, side, size)


@dataclass(frozen=True, eq=False)
class _Bent(Value):
    context: SeedContext
    blocked: Blocked
    side: int
    size: float

    def __call__(self, counts: WorkCounts, check: Check) -> Floats:
        del check
        return bent(self.context, self.blocked, self.side, self.size, counts=counts)


def bent(context: SeedContext, blocked: Blocked, side: int, size: float, *, counts: WorkCounts) -> Floats:
    """Return the context's line, bent so that the touching point passes to one side; within the limits.

    Args:
        side: 0 for the side that the contact pushes to most, 3 for the one it pushes to least.
        size: Displacement of the point [m].
    """
    query = context.query(counts)
    point = _TouchingPoint.of(query, blocked)
    direction = point.sides(_way(blocked))[side]
    moved = point.moved(size * direction, context.scale)
    knots = context.line.knots
    last = len(knots) - 1
    stops = np.array((0, *context.line.places, last))
    leg = int(np.clip(np.searchsorted(stops, blocked.place, side="right") - 1, 0, len(stops) - 2))
    first, final = stops[leg], stops[leg + 1]
    peak = float(np.clip(blocked.place, first + NEARBY, final - NEARBY))
    number = np.arange(last + 1)
    rising, falling = (number - first) / (peak - first), (final - number) / (final - peak)
    share = np.sin(0.5 * np.pi * np.clip(np.minimum(rising, falling), 0.0, 1.0))
    limits = context.reduced.limits
    result = knots + share[:, None] * (moved - _at(knots, peak))
    return np.clip(result, np.minimum(limits.lower, knots), np.maximum(limits.upper, knots))


@dataclass(frozen=True, eq=False)
class _TouchingPoint:
    """A point of a body that touches.

    Attributes:
        local: In the joint's frame, shape (3,) [m].
        push: Unit vector in which the contact pushes it, in the world, shape (3,).
    """

    query: Evaluator
    positions: Floats
    joint: int
    local: Floats
    push: Floats

    @staticmethod
    def of(query: Evaluator, blocked: Blocked) -> "_TouchingPoint":
        reduced, positions = query.reduced, _at(blocked.knots, blocked.place)
        pairs = reduced.pairs
        reach = np.full(len(pairs.margin), -np.inf)
        reach[blocked.pair] = pairs.margin[blocked.pair] + QUERY_DISTANCE
        found = query.close_pairs(positions[None, :], reach)
        if not len(found.pair):
            raise NoSeed("the blocking pair is not close")
        first, second = (
            reduced.bodies[int(side[blocked.pair])].joint for side in (pairs.first, pairs.second)
        )
        joint, point, push = second, found.point_second[0], found.normal[0]
        if first > second:
            joint, point, push = first, found.point_first[0], -found.normal[0]
        at = query.kinematics(positions[None, :])
        local = at.rotation[0, joint].T @ (point - at.translation[0, joint])
        return _TouchingPoint(query, positions, joint, local, push)

    def moved(self, shift: Floats, scale: Floats) -> Floats:
        limits, positions = self.query.reduced.limits, self.positions
        target = self._place(positions)[0] + shift
        for _ in range(STEPS):
            place, jacobian = self._place(positions)
            square = jacobian @ jacobian.T + DAMPING**2 * np.eye(3)
            step = jacobian.T @ np.linalg.solve(square, target - place)
            longest = float((np.abs(step) / scale).max())
            share = min(1.0, LONGEST_STEP / max(longest, LONGEST_STEP))
            positions = np.clip(positions + share * step, limits.lower, limits.upper)
        return positions

    def sides(self, way: Floats) -> Floats:
        """Return the unit vectors across the point's way, (4, 3); first that to which the contact pushes."""
        along = self._place(self.positions)[1] @ way
        length = float(np.linalg.norm(along))
        if length < STILL:
            raise NoSeed("the point that touched stands still")
        along /= length
        up = np.array((0.0, 0.0, 1.0))
        across = np.cross(up, along)
        if np.linalg.norm(across) < 0.1:
            # The point moves straight up or down: over and under are before and behind.
            across = np.cross((1.0, 0.0, 0.0), along)
        across /= np.linalg.norm(across)
        over = np.cross(along, across)
        found = np.stack((over, -over, across, -across)).astype(np.float64)
        return found[np.argsort(-(found @ self.push), kind="stable")]

    def _place(self, positions: Floats) -> tuple[Floats, Floats]:
        """Position (3,) and Jacobian (3, n) of the point."""
        at = self.query.kinematics(positions[None, :])
        place = at.rotation[0, self.joint] @ self.local + at.translation[0, self.joint]
        joints = np.array([self.joint])
        return place, point_jacobian(self.query.reduced, at.jacobian, joints, place[None, :])[0]


def _at(knots: Floats, place: float) -> Floats:
    before = min(int(place), len(knots) - 2)
    share = place - before
    return (1.0 - share) * knots[before] + share * knots[before + 1]


def _way(blocked: Blocked) -> Floats:
    last = len(blocked.knots) - 1.0
    return _at(blocked.knots, min(blocked.place + NEARBY, last)) - _at(
        blocked.knots, max(blocked.place - NEARBY, 0.0)
    )
