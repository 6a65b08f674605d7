"""Goal configurations of goals that fix none: searched from many starts, the nearest first."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from trajopt.arrays import Bools, Floats
from trajopt.model.reduced import ReducedModel
from trajopt.model.requirements import Requirement
from trajopt.query import Counts, Query, query_of
from trajopt.seeds.projection import Projection
from trajopt.seeds.straight import nearest_turn

STARTS = 64
"""Configurations that the search starts from; twice as many cost a third more time."""
SAME = 1e-2
"""Solutions nearer to each other than this in every joint are one [rad | m]."""


@dataclass(frozen=True, eq=False)
class GoalCandidates:
    """What the search found.

    Attributes:
        free: Configurations that hold the goal and touch nothing, nearest to the start first; those
            that keep the scene's margins come before those that do not.
        colliding: How many hold the goal but collide.
        blocking: The pair of owners that blocks the nearest colliding one, and its depth [m].
        nearest_miss: Smallest violation of the goal where none holds it [m and rad].
    """

    free: tuple[Floats, ...]
    colliding: int
    blocking: tuple[str, str, float] | None
    nearest_miss: float


def goal_candidates(
    reduced: ReducedModel,
    goals: Sequence[Requirement],
    *,
    rng: np.random.Generator,
    counts: Counts,
    starts: int = STARTS,
) -> GoalCandidates:
    """Search configurations that hold all goals.

    Args:
        reduced: The robot and its surroundings.
        goals: What must hold.
        rng: Draws the starts after the first, which is the start configuration.
        counts: Takes the work done.
        starts: How many starts to search from.
    """
    query = query_of(reduced, counts)
    projection = Projection(reduced, goals, query)
    ended = projection(_starts(reduced, rng, starts))
    found = _nearest_turns(reduced, projection, ended.positions[ended.violation == 0.0])
    found = _distinct(_by_travel(reduced, found))
    depth, pair, clear = _contact(query, found)
    free = depth <= 0.0
    order = [*np.flatnonzero(free & clear), *np.flatnonzero(free & ~clear)]
    blocking: tuple[str, str, float] | None = None
    if not free.all():
        nearest = int(np.argmin(free))
        blocking = (*reduced.owners(int(pair[nearest])), float(depth[nearest]))
    return GoalCandidates(
        tuple(found[place] for place in order),
        int((~free).sum()),
        blocking,
        float(ended.violation.min()),
    )


def _starts(reduced: ReducedModel, rng: np.random.Generator, count: int) -> Floats:
    limits = reduced.limits
    lower = np.where(np.isfinite(limits.lower), limits.lower, -np.pi)
    upper = np.where(np.isfinite(limits.upper), limits.upper, np.pi)
    begin = rng.uniform(lower, upper, (count, len(lower)))
    begin[0] = reduced.start_positions
    return begin


def _nearest_turns(reduced: ReducedModel, projection: Projection, found: Floats) -> Floats:
    """Turn joints by whole turns towards the start, where the goals do not fix the turn."""
    model = reduced.model
    turning = np.array(
        ["JointModelR" in model.joints[model.getJointId(name)].shortname() for name in reduced.joint_names],
        dtype=np.float64,
    )
    turned = nearest_turn(reduced.start_positions, found, reduced.limits, turning)
    if len(found) == 0:
        return found
    holds = projection.violation(turned) == 0.0
    return np.where(holds[:, None], turned, found)


def _by_travel(reduced: ReducedModel, found: Floats) -> Floats:
    """Sort configurations by the time to them at full velocity."""
    travel = np.abs(found - reduced.start_positions) / reduced.limits.velocity
    return found[np.argsort(travel.max(axis=1, initial=0.0), kind="stable")]


def _distinct(found: Floats) -> Floats:
    """Keep the first of those that are the same."""
    same = (np.abs(found[:, None] - found) < SAME).all(axis=2)
    kept: list[int] = []
    for place in range(len(found)):
        if not same[place, kept].any():
            kept.append(place)
    return found[kept]


def _contact(query: Query, found: Floats) -> tuple[Floats, Floats, Bools]:
    """Measure the deepest contact that is not meant at the end of the motion.

    Returns:
        Depth [m], negative if there is none, its pair, and whether all margins are kept; each (k,).
    """
    pairs = query.reduced.pairs
    accepted = np.zeros(len(pairs.margin))
    for pair, allowance in pairs.allowances:
        if allowance.last > 0.0:
            accepted[pair] = max(accepted[pair], allowance.depth)
    if len(found)==0:
        return np.empty(0), np.empty(0), np.empty(0, dtype=np.bool_)
    contacts = query.near(found, np.maximum(pairs.margin, 0.0))
    depth, worst = np.full(len(found), -np.inf), np.zeros(len(found))
    clear = np.ones(len(found), dtype=np.bool_)
    for sample, pair, distance in zip(contacts.sample.tolist(), contacts.pair.tolist(), contacts.distance.tolist(), strict=True):
        if distance + accepted[pair] > 0.0:
            clear[sample] &= accepted[pair] > 0.0
        elif -distance > depth[sample]:
            depth[sample], worst[sample] = -distance, pair
            clear[sample] = False
    return depth, worst, clear
