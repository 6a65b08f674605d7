"""Paths of a sampling planner as first guesses: RRT-Connect of OMPL, shortened.

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
from trajopt.planning.seeds.source import Blocked, Check, Guess, NoGuess, Route
from trajopt.query import Counts, Query

CHECKED = 20_000
"""Configurations that one leg is searched with before starting anew: most searches that end end soon."""
PATIENCE = 2
"""After so many searches they get twice as many, after twice as many three times, ..."""


@dataclass(frozen=True)
class SampledPaths:
    """The `Source` of paths of RRT-Connect, without end; every one is searched longer."""

    kind = SeedKind.SAMPLED

    def guesses(self, route: Route, blocked: Sequence[Blocked], rng: np.random.Generator) -> Iterator[Guess]:
        """Yield paths; see `Source.guesses`."""
        del blocked
        for index in count():
            yield _Sampled(route, rng.spawn(1)[0], CHECKED * (1 + index // PATIENCE))


@dataclass(frozen=True, eq=False)
class _Sampled(Value):
    route: Route
    rng: np.random.Generator
    checked: int

    def __call__(self, counts: Counts, check: Check) -> Floats:
        return sampled(self.route, rng=self.rng, counts=counts, check=check, checked=self.checked)


def sampled(
    route: Route, *, rng: np.random.Generator, counts: Counts, check: Check, checked: int = CHECKED
) -> Floats:
    """Return a path that is clear of everything between the knots' stops.

    Args:
        route: Where it leads.
        rng: Seeds OMPL, whose generator is one for the whole process.
        counts: Takes the work done.
        check: Called while it searches; may raise to stop.
        checked: Configurations that each leg is searched with at most.

    Returns:
        Knots, shape (N, n), evenly spaced on each leg; stops where the route's line has them.

    Raises:
        MissingExtra: If OMPL is not installed.
        NoGuess: If a leg was not found, or a path constraint could not be held.
    """
    if find_spec("ompl") is None:
        raise MissingExtra("ompl", "ompl")
    from trajopt.planning.seeds.rrt_connect import search

    query, knots = Query(route.reduced, counts), route.line.knots
    places = (0, *route.line.places, len(knots) - 1)
    legs = [knots[:1]]
    for first, last in pairwise(places):
        corners = search(
            query, knots[first], knots[last], scale=route.scale, rng=rng, check=check, checked=checked
        )
        legs.append(_even(corners, last - first, route.reduced.limits.velocity)[1:])
    return _held(np.concatenate(legs), route, query)


def _held(path: Floats, route: Route, query: Query) -> Floats:
    """Move the inner knots onto the path constraints."""
    if not route.requirements:
        return path
    projection = Projection(route.reduced, route.requirements, query)
    inner = [place for place in range(1, len(path) - 1) if place not in route.line.places]
    ended = projection(path[inner])
    lost = int((ended.violation > 0.0).sum())
    if lost:
        raise NoGuess(f"{lost} of {len(inner)} sampled configurations do not reach the path constraints")
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
