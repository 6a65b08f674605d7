"""A problem becomes an `Nlp` over joint positions, and its solution a path."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from trajopt.geometry import Evaluator, WorkCounts, covered_query, evaluator
from trajopt.optimise.nlp import Linearisation
from trajopt.optimise.terms import Clearance, Constraint, Window, constrain, constraint
from trajopt.optimise.terms.gravity_torque import HoldingTorque
from trajopt.optimise.terms.joint_positions import fixed_positions, joint_box, rolling
from trajopt.optimise.transcription.compilable import CompilableMotionNlp
from trajopt.optimise.transcription.margins import (
    ShrunkMargins,
    TaperedMargins,
    shrinkable,
    tapered,
    tapered_margins,
)
from trajopt.problem.motion import Motion
from trajopt.problem.problem import PathConstraint, Problem
from trajopt.problem.requirements import During, Requirement, together
from trajopt.problem.requirements.joints import SHARE, GravityTorque
from trajopt.problem.residual import END, WHOLE
from trajopt.robot.joints import JointLimits, joint_unit
from trajopt.scene.bounds import largest_gravity_torques
from trajopt.values.arrays import Floats, Ints, readonly
from trajopt.values.cached import cached_per_value
from trajopt.values.errors import ProblemError
from trajopt.values.errors.arguments import checked
from trajopt.values.trajectory import Path

SWEEP = 0.02
"""Final limit of a body's travel between two samples [m]."""
COARSE_SAMPLES = 3
"""Samples per segment while the motion is not free yet."""
MOST_SAMPLES = 400
"""Samples per segment at most."""
TURN = 0.5
"""Up to this step a body's travel hardly exceeds the distance between its ends [rad | m]."""


def swept_samples(
    query: Evaluator, corners: Floats, least: int = COARSE_SAMPLES, *, sweep: float = SWEEP
) -> Ints:
    return samples_for(swept(query, corners), least, sweep)


def samples_for(way: Floats, least: int, sweep: float = SWEEP) -> Ints:
    return np.clip(np.ceil(way / sweep), least, MOST_SAMPLES).astype(np.int64)


def swept(query: Evaluator, corners: Floats) -> Floats:
    """Return the approximate travel of bodies in each segment of a polyline (N, n), shape (N - 1,) [m]."""
    segments, steps = len(corners) - 1, corners[1:] - corners[:-1]
    parts = int(np.clip(np.ceil(np.abs(steps).max(initial=0.0) / TURN), 1, MOST_SAMPLES))
    share = np.arange(parts * segments + 1) / parts
    first = np.minimum(share.astype(np.int64), segments - 1)
    fine = corners[first] + (share - first)[:, None] * steps[first]
    way: Floats = query.displacement(fine[:-1], fine[1:]).reshape(segments, parts).sum(axis=1)
    return way


CLEARANCE_TOLERANCE = 1e-3
"""A margin counts as held when undercut by at most this [m]."""
WIDE = 0.025
"""Goals that leave any joint more room than this are sets of configurations; in others a motion ends at the
middle [rad | m].
"""
PRISMATIC_STEP = 0.5
"""A prismatic joint's ordinary step, as a share of its range."""


@dataclass(eq=False)
class KnotsNlp(CompilableMotionNlp):
    """The program over knots, between which the motion is straight; built by `transcribe`."""

    margins: TaperedMargins
    share: float = 1.0
    waypoint_knots: tuple[int, ...] = ()

    def sampling(self, x: Floats, *, fine: bool) -> Ints:
        segments = len(x) - 1
        if not fine:
            return np.full(segments, COARSE_SAMPLES)
        # Between samples a body comes nearer by no more than the square of their distance, by its reach.
        return swept_samples(self.query, x, sweep=SWEEP * float(np.sqrt(self.share)))

    def keeping(self, share: float) -> "KnotsNlp":
        """Return the program with a share of its margins beyond the requirement only."""
        clearance = _clearance(self.problem, self.margins, share)
        return replace(self, constraints=(clearance, *self.constraints[1:]), share=share)

    def starting_at(self, positions: Floats) -> "KnotsNlp":
        """Return the program with another first knot: the stopping point of a start in motion."""
        lower, upper = self.lower.copy(), self.upper.copy()
        lower[0] = upper[0] = positions
        return replace(self, lower=lower, upper=upper)

    def lacks_margin_only(self, at: Linearisation) -> bool:
        """Whether all holds at a point except default margins, including the requirements."""
        pairs, asked = self.margins.pairs, ShrunkMargins(self.margins, self.share)
        required, gives = pairs.required, shrinkable(pairs)
        for block in at.constraints:
            rows, missed = block.rows, block.violation > block.tolerance
            if block.kind is Clearance:
                margin, pair = asked(rows.component, rows.place), rows.component
                missed &= (rows.value + margin < np.minimum(required[pair], margin)) | ~gives[pair]
            if missed.any():
                return False
        return True

    def motion(self, x: Floats, sampling: Ints) -> Motion:
        """Sample the polyline."""
        return Motion.through(x, sampling, self.query)

    def decode(self, x: Floats) -> Path:
        return Path(self.problem.reduced.joint_names, readonly(np.array(x)))


@checked
@cached_per_value
def fixed_goal(problem: Problem) -> Floats | None:
    """Return the group's positions at the goal, shape (n,), if the goals fix all of them up to `WIDE`."""
    centre = goal_centre(problem)
    if centre is None:
        return None
    lower, upper = joint_box(problem.goals, problem.reduced)
    return None if (upper - lower > WIDE).any() else centre


@checked
@cached_per_value
def goal_centre(problem: Problem) -> Floats | None:
    """Return the middle of goals of all joints, shape (n,), moved into the limits as far as they tolerate."""
    asked = fixed_positions(problem.goals, problem.reduced)
    if asked is None:
        return None
    lower, upper = joint_box(problem.goals, problem.reduced)
    return readonly(np.where(lower <= upper, np.clip(asked, lower, upper), asked))


def shortest_duration(limits: JointLimits, start: Floats, goal: Floats) -> float:
    distance = np.abs(goal - start)
    ramp = limits.velocity**2 / limits.acceleration
    times = np.where(
        distance > ramp,
        distance / limits.velocity + limits.velocity / limits.acceleration,
        2.0 * np.sqrt(distance / limits.acceleration),
    )
    return float(times.max(initial=0.0))


@checked
def transcribe(
    problem: Problem, seed: Floats, waypoint_knots: Sequence[int] = (), counts: WorkCounts | None = None
) -> KnotsNlp:
    """Transcribe a problem into a program over knots.

    Args:
        seed: Knots to start from, shape (N, n): the motion's duration is estimated from it, for windows of
            allowed contact.
        waypoint_knots: The knot of each waypoint, increasing, neither first nor last.

    Raises:
        ProblemError: If a requirement has no term, or requires a joint outside the group to move, or there is
            not one knot for each waypoint.
    """
    _check_waypoints(problem, waypoint_knots)
    return _transcribed(
        problem, seed, waypoint_knots, problem.evaluator(problem.reduced, counts or WorkCounts())
    )


@checked
def transcribe_covered(
    problem: Problem, seed: Floats, waypoint_knots: Sequence[int], counts: WorkCounts
) -> KnotsNlp | None:
    """Transcribe a problem with boxes in place of clouds, which are faster to measure; see `transcribe`.

    A path clear of the boxes is clear of the clouds, but a free path may not be clear of the boxes. None if
    there is no cloud that boxes can replace, or the evaluator is not the native one.
    """
    _check_waypoints(problem, waypoint_knots)
    if problem.evaluator is not evaluator:
        return None
    stops = seed[list(waypoint_knots)]
    query = covered_query(
        problem.reduced, counts, np.vstack((problem.reduced.start_positions, stops, seed[-1]))
    )
    return None if query is None else _transcribed(problem, seed, waypoint_knots, query)


def _transcribed(problem: Problem, seed: Floats, waypoint_knots: Sequence[int], query: Evaluator) -> KnotsNlp:
    reduced, counts = problem.reduced, query.counts
    limits, count = reduced.limits, problem.knots
    goal = fixed_goal(problem)
    lower, upper = (np.tile(side, (count, 1)) for side in (limits.lower, limits.upper))
    lower[0] = upper[0] = reduced.start_positions
    if goal is not None:
        lower[-1] = upper[-1] = goal
    stops = seed[[0, *waypoint_knots, len(seed) - 1]]
    shortest = sum(shortest_duration(limits, *leg) for leg in pairwise(stops))
    duration = 1.5 * max(shortest, 1e-3) / min(problem.velocity_scaling, problem.acceleration_scaling)
    margins = tapered_margins(query, count, goal, duration, end=seed[-1])
    fixed = [reduced.start_positions, *seed[list(waypoint_knots)], *(() if goal is None else (goal,))]
    items: list[Constraint] = [_clearance(problem, margins, 1.0), *rolling(reduced, count)]
    items.extend(holding_rows(problem, query, np.stack(fixed)))
    ends = np.stack(
        (reduced.start_positions, *seed[list(waypoint_knots)], seed[-1] if goal is None else goal)
    )
    for given in problem.constraints:
        items.extend(_written(given, problem, query, waypoint_knots, ends))
    if goal is None:
        for required in together(problem.goals):
            items.extend(constrain(required, reduced, END))
    for place, wanted in zip(waypoint_knots, problem.waypoint_requirements, strict=True):
        window = Window(place / (count - 1), place / (count - 1))
        for required in together(wanted):
            items.extend(constrain(required, reduced, window))
    span = limits.upper - limits.lower
    prismatic = np.array([joint_unit(reduced.model, name) == "m" for name in reduced.joint_names])
    scale = np.where(prismatic & np.isfinite(span), PRISMATIC_STEP * span, 1.0)
    return KnotsNlp(
        problem,
        counts,
        lower,
        upper,
        scale,
        query,
        tuple(items),
        margins,
        waypoint_knots=tuple(waypoint_knots),
    )


def _clearance(problem: Problem, margins: TaperedMargins, share: float) -> Constraint:
    distance = Clearance(problem.reduced, margins if share == 1.0 else ShrunkMargins(margins, share))
    tolerance = share * CLEARANCE_TOLERANCE
    return constraint(distance, lower=0.0, upper=np.inf, tolerance=tolerance, reach=distance.activation)


def _written(
    given: PathConstraint | During[PathConstraint],
    problem: Problem,
    query: Evaluator,
    waypoint_knots: Sequence[int],
    ends: Floats,
) -> Sequence[Constraint]:
    if isinstance(given, Constraint):
        return (given,)
    last = problem.knots - 1
    stops = (0, *waypoint_knots, last)
    if isinstance(given, Requirement):
        return tapered(given, query, WHOLE, stops, ends, last)
    window = Window(*(stops[stop] / last for stop in problem.span(given)))
    if isinstance(given.required, Requirement):
        return tapered(given.required, query, window, stops, ends, last)
    return (replace(given.required, window=window),)


def _check_waypoints(problem: Problem, places: Sequence[int]) -> None:
    wanted = len(problem.waypoint_requirements)
    inner = (0, *places, problem.knots - 1)
    if len(places) != wanted or any(a >= b for a, b in pairwise(inner)):
        raise ProblemError(
            f"{wanted} waypoints need as many knots, increasing, between 1 and {problem.knots - 2}; "
            f"given are {list(places)}"
        )


USABLE = 0.9
"""Part of the rest above the share that a path may use if necessary. The remainder is for the distance
between samples and for rounded corners.
"""
LISTED = 0.3
"""Distance below its share from which a joint gets a row: a step may change its load by about that."""


def holding_rows(problem: Problem, query: Evaluator, stops: Floats) -> tuple[Constraint, ...]:
    """Return the rows that keep the joints able to hold the load still; none if they always are.

    Joints that gravity cannot overload have no rows. A joint may use its share, or its load at a fixed stop
    if that is larger. If the problem itself limits the share of gravity, that is enough.

    Args:
        stops: Configurations that the motion passes in any case, shape (k, n) [rad | m].
    """
    effort = problem.limits.effort
    heavy = largest_gravity_torques(problem.reduced) > SHARE * effort
    if not heavy.any() or any(isinstance(item, GravityTorque) for item in problem.requirements):
        return ()
    given = np.abs(query.dynamics.gravity(stops).torque / effort).max(axis=0)
    share = np.minimum(np.maximum(given, SHARE), 1.0)
    bound = np.where(heavy, share, np.inf)
    return (
        constraint(
            HoldingTorque(effort, bound - LISTED),
            lower=-bound,
            upper=bound,
            tolerance=max(USABLE * (1.0 - float(share[heavy].max())), 1e-9),
            reach=LISTED,
        ),
    )
