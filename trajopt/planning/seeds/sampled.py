"""Paths of RRT-Connect to all goal configurations together.

Source: Kuffner and LaValle, ICRA 2000.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import count, pairwise
from math import atan2, hypot, pi

import numpy as np

from trajopt.geometry import Evaluator, SearchSpace, WorkCounts, search_path
from trajopt.optimise.kinematics.projection import Projection, turning_joints
from trajopt.planning.seeds.source import Blocked, Check, MakeSeed, NoSeed, SeedContext, SeedKind
from trajopt.robot.joints import JointLimits
from trajopt.scene.reduced import ReducedModel
from trajopt.values.arrays import Floats, Printed

CHECKED = 60_000
"""Configurations checked on one leg before a restart. The costs of one problem's searches differ by a factor
of three to ten, so a search given up early was often nearly done.
"""
PATIENCE = 12
"""Number of searches, those of a plan without a budget, after which their limit doubles; after twice this
number it triples, and so on.
"""
SHORTENED = 4_000
"""Configurations that each pass of shortening may check."""
STEP = 0.03
"""Between two configurations that are checked no body moves farther [m]."""
BRANCH = 10 * STEP
"""Travel of bodies by a joint alone along a branch of the trees: ten checks for every joint [m]."""
NUDGE = 0.1
"""Displacement of joints that measures the travel of bodies, in ordinary steps."""
KEPT = (0.5, -1.0)
"""Parts of each pair's margin beyond the requirement that successive searches keep: narrow ends are left more
easily if bodies may overlap by their margin, which the optimiser corrects.
"""
TURN = np.pi
"""Largest range of a turning joint beyond its start and goals, regardless of its limits [rad]."""
SLIDE = (3.0, 12.0, 48.0, 192.0)
"""The same of a sliding joint in successive searches, all others as the last: a near path is shorter,
but a base may have to go around a building [m].
"""
STILL = 1e-3
"""A base that moves less far keeps its heading [m]."""
SURE = 1e-8
"""Allowance below the distances at start and goals, for the error of repeated measurements [m]."""


class SpaceExhausted(NoSeed):
    """A search found no path, and longer ones would hardly find one."""


@dataclass(frozen=True)
class SampledPaths:
    """The `SeedSource` of paths of RRT-Connect.

    They are searched longer and longer, until a search that keeps least of the margins is exhausted.
    """

    kind = SeedKind.SAMPLED

    def seeds(
        self, context: SeedContext, blocked: Sequence[Blocked], rng: np.random.Generator
    ) -> Iterator[MakeSeed]:
        del blocked
        widest = list[_Sampled]()
        for index in count():
            if any(each.exhausted for each in widest):
                return
            looks, kept = CHECKED * (1 + index // PATIENCE), KEPT[index % len(KEPT)]
            slide = SLIDE[min(index, len(SLIDE) - 1)]
            made = _Sampled(context, rng.spawn(1)[0], looks, kept, slide)
            if kept == min(KEPT) and (slide == SLIDE[-1] or turning_joints(context.reduced).all()):
                widest.append(made)
            yield made


@dataclass(eq=False)
class _Sampled(Printed):
    context: SeedContext
    rng: np.random.Generator
    checked: int
    kept: float
    slide: float
    exhausted: bool = False

    def __call__(self, counts: WorkCounts, check: Check) -> Floats:
        try:
            return sampled(
                self.context,
                rng=self.rng,
                counts=counts,
                check=check,
                checked=self.checked,
                kept=self.kept,
                slide=self.slide,
            )
        except SpaceExhausted:
            self.exhausted = True
            raise


def sampled(
    context: SeedContext,
    *,
    rng: np.random.Generator,
    counts: WorkCounts,
    check: Check,
    checked: int = CHECKED,
    kept: float = KEPT[0],
    slide: float = SLIDE[-1],
) -> Floats:
    """Return a collision-free path between the knots' stops, evenly spaced on each leg, shape (N, n).

    A base on driven wheels turns on the spot and drives straight, which may collide where the path did not.

    Args:
        context: Goals; the path leads to the one reached first.
        check: Called while it searches; may raise to stop.
        kept: Part of each pair's margin kept, beyond the requirement.
        slide: Range of sliding joints beyond their start and goals [m].

    Raises:
        NoSeed: If there is none; `SpaceExhausted` if a longer search would hardly find one.
    """
    query, knots = context.query(counts), context.line.knots
    places = (0, *context.line.places, len(knots) - 1)
    legs = [knots[:1]]
    for first, last in pairwise(places):
        goals = context.ends if last == places[-1] else knots[last][None]
        space = _space(query, np.vstack((knots[first], goals)), context.scale, kept, slide)
        found = search_path(
            query,
            knots[first],
            goals,
            space,
            checked=checked,
            shortening=SHORTENED,
            seed=int(rng.random() * 2**53),
            check=check,
        )
        if found.corners is None:
            if found.exhausted:
                raise SpaceExhausted("the sampling planner found no path, and in the end nothing new")
            raise NoSeed(f"the sampling planner found no path among {checked} configurations")
        legs.append(knots_along(found.corners, last - first, context.reduced)[1:])
    return _held(np.concatenate(legs), context, query)


def _space(query: Evaluator, ends: Floats, scale: Floats, kept: float, slide: float) -> SearchSpace:
    reduced = query.reduced
    pairs, limits = reduced.pairs, reduced.limits
    reach = pairs.required + kept * (pairs.margin - pairs.required)
    contacts = query.close_pairs(ends, reach)
    np.minimum.at(reach, contacts.pair, contacts.distance - SURE)
    beyond = np.where(turning_joints(reduced), TURN, slide)
    lower = np.maximum(ends.min(axis=0) - beyond, limits.lower)
    upper = np.minimum(ends.max(axis=0) + beyond, limits.upper)
    unit = np.minimum(BRANCH / _rates(query, ends, scale), np.maximum(upper - lower, scale))
    return SearchSpace(lower, upper, unit, reach, STEP)


def _rates(query: Evaluator, ends: Floats, scale: Floats) -> Floats:
    """Return the travel of bodies by each joint, the largest at any of the ends, shape (n,) [m/rad | 1]."""
    nudge = np.diag(NUDGE * scale)
    first = np.repeat(ends, len(scale), axis=0)
    moved = query.displacement(first, first + np.tile(nudge, (len(ends), 1)))
    return np.maximum(moved.reshape(len(ends), -1).max(axis=0) / (NUDGE * scale), np.finfo(float).tiny)


def _held(path: Floats, context: SeedContext, query: Evaluator) -> Floats:
    if not context.problem.requirements:
        return path
    projection = Projection(context.reduced, context.problem.requirements, query)
    inner = [place for place in range(1, len(path) - 1) if place not in context.line.places]
    ended = projection(path[inner])
    lost = int((ended.violation > 0.0).sum())
    if lost:
        raise NoSeed(f"{lost} of {len(inner)} sampled configurations do not reach the path constraints")
    held = path.copy()
    held[inner] = ended.positions
    return held


def knots_along(corners: Floats, segments: int, reduced: ReducedModel) -> Floats:
    """Return knots along a path of straight lines, (segments + 1, n), on which driven wheels roll."""
    speed, places = reduced.limits.velocity, reduced.scene.robot.base.rolling(reduced.joint_names)
    if places is None:
        return _even(corners, segments, speed)
    driven = _driven(corners, places, reduced.limits)
    spaced = _with_corners if len(driven) <= segments else _even
    return spaced(driven, segments, speed)


def _driven(corners: Floats, places: tuple[int, int, int], limits: JointLimits) -> Floats:
    """Return the corners of a path on which a base turns on the spot, or drives straight ahead or back."""
    x, y, yaw = places
    path = [corners[0]]
    for corner in corners[1:]:
        begun, there = path[-1].copy(), corner.copy()
        along, across = float(there[x] - begun[x]), float(there[y] - begun[y])
        if hypot(along, across) > STILL:
            ahead = atan2(across, along)
            heading = ahead + pi * round((float(begun[yaw]) - ahead) / pi)
            heading += pi * ((heading < limits.lower[yaw]) - float(heading > limits.upper[yaw]))
            begun[yaw] = heading
        there[yaw] = begun[yaw]
        path += [begun, there]
    path.append(corners[-1])
    driven = np.stack(path)
    kept = np.ones(len(driven), dtype=np.bool_)
    kept[1:-1] = (driven[1:-1] != driven[:-2]).any(axis=1)
    return driven[kept]


def _with_corners(path: Floats, segments: int, speed: Floats) -> Floats:
    """Return a path with a knot at each corner and the others evenly in time, shape (segments + 1, n)."""
    lengths = (np.abs(np.diff(path, axis=0)) / speed).max(axis=1)
    parts = np.ones(len(lengths), dtype=np.int64)
    for _ in range(segments - len(lengths)):
        parts[np.argmax(lengths / parts)] += 1
    lines: list[Floats] = [
        np.linspace(path[line], path[line + 1], part + 1)[1:] for line, part in enumerate(parts.tolist())
    ]
    return np.concatenate((path[:1], *lines))


def _even(path: Floats, segments: int, speed: Floats) -> Floats:
    lengths = np.maximum((np.abs(np.diff(path, axis=0)) / speed).max(axis=1), 1e-9)
    along: Floats = np.concatenate((np.zeros(1), np.cumsum(lengths)))
    wanted = np.linspace(0.0, float(along[-1]), segments + 1)
    even = np.empty((segments + 1, path.shape[1]))
    for joint in range(path.shape[1]):
        even[:, joint] = np.interp(wanted, along, path[:, joint])
    even[-1] = path[-1]
    return even
