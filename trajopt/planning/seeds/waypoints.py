"""Seeds that pass waypoints: a configuration for each, and the knots they are held at."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import pairwise

import numpy as np

from trajopt.geometry import Evaluator
from trajopt.optimise.kinematics.inverse import (
    HOLDABLE,
    MANY_STARTS,
    GoalCandidates,
    goal_candidates,
    holding_load,
)
from trajopt.optimise.kinematics.projection import Projection
from trajopt.optimise.kinematics.validity import missed_at
from trajopt.optimise.terms.joint_positions import fixed_positions, joint_box
from trajopt.problem.problem import Problem
from trajopt.problem.requirements import Requirement
from trajopt.robot.joints import EXCESS
from trajopt.scene.clearances import how_near
from trajopt.scene.reduced import ReducedModel
from trajopt.values.arrays import Floats, Value


@dataclass(frozen=True, eq=False)
class WaypointLine(Value):
    """Straight legs from stop to stop.

    Attributes:
        knots: Shape (N, n).
        places: The knot of each waypoint, increasing; neither the first nor the last.
    """

    knots: Floats
    places: tuple[int, ...]


@dataclass(frozen=True, eq=False)
class WaypointChoice:
    """Configurations of waypoints.

    Attributes:
        found: One for each waypoint, in order, up to the first without one.
        problem: Reason why that one has none; empty if all have one.
    """

    found: tuple[Floats, ...]
    problem: str


def choose_waypoints(
    query: Evaluator,
    waypoints: Mapping[str, Sequence[Requirement]],
    passing: Sequence[Sequence[Requirement]],
    *,
    rng: np.random.Generator,
    effort: Floats | None = None,
    check: Callable[[], None] | None = None,
) -> WaypointChoice:
    """Choose a configuration for each waypoint: the collision-free one nearest to the previous one.

    If joint positions are required, these are tried first, and then others within their tolerances.

    Args:
        waypoints: Requirements by name, in order.
        passing: Other requirements at each, which hold on the way to it or on from it.
        effort: Effort limits for holding still, shape (n,) [Nm | N]; not considered when None.
        check: Called repeatedly; may raise to stop.
    """
    reduced = query.reduced
    last = reduced.start_positions
    found: list[Floats] = []
    for (name, wanted), also in zip(waypoints.items(), passing, strict=True):
        middle = _middle(reduced, wanted, also, query)
        if middle is not None and holding_load(query, middle[None], effort)[0] < HOLDABLE:
            last = middle
        else:
            search = partial(goal_candidates, query, (*wanted, *also), rng=rng)
            seen = search(effort=effort, check=check)
            if not seen.free and not seen.colliding and not seen.overloaded:
                seen = search(effort=effort, check=check, starts=MANY_STARTS)
            if not seen.free:
                return WaypointChoice(tuple(found), _why_none(reduced, name, seen, (*wanted, *also)))
            last = min(seen.free, key=lambda q, before=last: _effort(reduced, before, q))
        found.append(last)
    return WaypointChoice(tuple(found), "")


def _middle(
    reduced: ReducedModel, wanted: Sequence[Requirement], also: Sequence[Requirement], query: Evaluator
) -> Floats | None:
    asked = fixed_positions(wanted, reduced)
    if asked is None:
        return None
    lower, upper = joint_box(wanted, reduced)
    if (lower - upper > 2.0 * EXCESS).any():
        return None
    middle = np.where(lower <= upper, np.clip(asked, lower, upper), asked)
    if len(query.close_pairs(middle[None], reduced.pairs.required).distance):
        return None
    return None if also and Projection(reduced, also, query).violation(middle[None])[0] > 0.0 else middle


def _why_none(reduced: ReducedModel, name: str, seen: GoalCandidates, required: Sequence[Requirement]) -> str:
    if seen.overloaded:
        return (
            f"all {len(seen.overloaded)} configurations found for waypoint {name} that touch nothing need "
            "more torque only to hold still than the joints have"
        )
    if seen.blocking is None:
        miss = f"misses it by {missed_at(reduced, required, seen.nearest)}"
        return f"the nearest configuration tried for waypoint {name} {miss}"
    nearest, how = how_near(*seen.blocking, seen.required), "collide"
    if seen.required > 0.0:
        how += " or come too near to something"
    return f"all {seen.colliding} configurations found for waypoint {name} {how}; in the nearest, {nearest}"


SHORT_LEG = 3
"""Least steps of a leg with requirements of its own: a tool lowers straight in them, after a long drive."""


def least_steps(problem: Problem) -> Sequence[int]:
    """Return the least number of steps of each leg."""
    least = [1] * (len(problem.waypoints) + 1)
    for first, last in map(problem.span, problem.partial):
        least[first:last] = [SHORT_LEG] * (last - first)
    return least if sum(least) < problem.knots else [1] * len(least)


def line_through(
    reduced: ReducedModel, stops: Sequence[Floats], knots: int, least: Sequence[int] = ()
) -> WaypointLine:
    """Lay straight legs through stops, shape (n,) each; knots are in proportion to the time at full speed.

    Args:
        knots: Number of knots, ends included; more than there are legs.
        least: Least number of steps of each leg, fewer than knots together; 1 each if empty.
    """
    legs = len(stops) - 1
    lengths = np.array([_effort(reduced, *pair) for pair in pairwise(stops)])
    along = np.concatenate(([0.0], np.cumsum(np.maximum(lengths, 1e-6))))
    places = [round(float(share) * (knots - 1)) for share in along / along[-1]]
    least = least or [1] * legs
    for leg in range(1, legs):
        places[leg] = max(places[leg], places[leg - 1] + least[leg - 1])
    for leg in range(legs - 1, 0, -1):
        places[leg] = min(places[leg], places[leg + 1] - least[leg])
    line = [stops[0][None]]
    for leg, (first, last) in enumerate(pairwise(places)):
        line.append(np.linspace(stops[leg], stops[leg + 1], last - first + 1)[1:])
    return WaypointLine(np.concatenate(line), tuple(places[1:-1]))


def _effort(reduced: ReducedModel, start: Floats, end: Floats) -> float:
    return float(np.max(np.abs(end - start) / reduced.limits.velocity))
