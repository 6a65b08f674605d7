"""Paths of a sampling planner as seeds: RRT-Connect of OMPL, shortened.

It sees the clearance of all pairs and the joint limits. Path constraints it does not see: its path is
moved onto them knot by knot, and the optimiser does the rest.
Source: Kuffner and LaValle, ICRA 2000; Sucan, Moll and Kavraki, OMPL, IEEE RAM 2012.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from itertools import count, pairwise

import numpy as np

from trajopt.arrays import Floats, Value
from trajopt.errors import MissingExtra
from trajopt.kinematics.projection import Projection
from trajopt.planning.seeds.kind import SeedKind
from trajopt.planning.seeds.source import Blocked, Check, MakeSeed, NoSeed, SeedContext
from trajopt.query import Counts, Query

CHECKED = 20_000
"""Configurations that one leg is searched with before starting anew: most searches that end end soon."""
PATIENCE = 2
"""After so many searches they get twice as many, after twice as many three times, ..."""


@dataclass(frozen=True)
class SampledPaths:
    """The `Source` of paths of RRT-Connect, without end; every one is searched longer."""

    kind = SeedKind.SAMPLED

    def seeds(
        self, context: SeedContext, blocked: Sequence[Blocked], rng: np.random.Generator
    ) -> Iterator[MakeSeed]:
        """Yield paths; see `Source.seeds`."""
        del blocked
        for index in count():
            yield _Sampled(context, rng.spawn(1)[0], CHECKED * (1 + index // PATIENCE))


@dataclass(frozen=True, eq=False)
class _Sampled(Value):
    context: SeedContext
    rng: np.random.Generator
    checked: int

    def __call__(self, counts: Counts, check: Check) -> Floats:
        return sampled(self.context, rng=self.rng, counts=counts, check=check, checked=self.checked)


def sampled(
    context: SeedContext, *, rng: np.random.Generator, counts: Counts, check: Check, checked: int = CHECKED
) -> Floats:
    """Return a path that is clear of everything between the knots' stops.

    Args:
        context: Where it leads.
        rng: Seeds OMPL, whose generator is one for the whole process.
        counts: Takes the work done.
        check: Called while it searches; may raise to stop.
        checked: Configurations that each leg is searched with at most.

    Returns:
        Knots, shape (N, n), evenly spaced on each leg; stops where the context's line has them.

    Raises:
        MissingExtra: If OMPL is not installed.
        NoSeed: If a leg was not found, or a path constraint could not be held.
    """
    if find_spec("ompl") is None:
        raise MissingExtra("ompl", "ompl")
    from trajopt.planning.seeds.rrt_connect import search

    query, knots = Query(context.reduced, counts), context.line.knots
    places = (0, *context.line.places, len(knots) - 1)
    legs = [knots[:1]]
    for first, last in pairwise(places):
        corners = search(
            query, knots[first], knots[last], scale=context.scale, rng=rng, check=check, checked=checked
        )
        legs.append(_even(corners, last - first, context.reduced.limits.velocity)[1:])
    return _held(np.concatenate(legs), context, query)


def _held(path: Floats, context: SeedContext, query: Query) -> Floats:
    """Move the inner knots onto the path constraints."""
    if not context.requirements:
        return path
    projection = Projection(context.reduced, context.requirements, query)
    inner = [place for place in range(1, len(path) - 1) if place not in context.line.places]
    ended = projection(path[inner])
    lost = int((ended.violation > 0.0).sum())
    if lost:
        raise NoSeed(f"{lost} of {len(inner)} sampled configurations do not reach the path constraints")
    held = path.copy()
    held[inner] = ended.positions
    return held


def _even(path: Floats, segments: int, speed: Floats) -> Floats:
    """Return knots evenly spaced in time at full speed along a polyline, shape (segments + 1, n)."""
    lengths = np.maximum((np.abs(np.diff(path, axis=0)) / speed).max(axis=1), 1e-9)
    along: Floats = np.concatenate((np.zeros(1), np.cumsum(lengths)))
    wanted = np.linspace(0.0, float(along[-1]), segments + 1)
    even = np.empty((segments + 1, path.shape[1]))
    for joint in range(path.shape[1]):
        even[:, joint] = np.interp(wanted, along, path[:, joint])
    even[-1] = path[-1]
    return even
