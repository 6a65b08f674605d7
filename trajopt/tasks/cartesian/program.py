"""The whole line as one program: all knots together."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from trajopt.optimise.solvers import SolveResult, Sqp
from trajopt.optimise.terms import Constraint, Cost, constraint
from trajopt.optimise.terms.frame_placement import POSITION_ROWS, CurveError, within
from trajopt.optimise.transcription import transcribe
from trajopt.planning.budget import BudgetTracker
from trajopt.problem.motion import Motion
from trajopt.problem.problem import Problem
from trajopt.problem.requirements import FollowsCurve
from trajopt.tasks.cartesian.curves import spline
from trajopt.tasks.cartesian.tracking import CurveTrack, OnCurve, track
from trajopt.values.arrays import Floats, Rows, readonly
from trajopt.values.curve import Curve
from trajopt.values.placement import Placement

SPACING = 0.02
"""Distance of knots along the curve [m]."""
FEWEST, MOST = 16, 96
"""Smallest and largest number of knots."""
HELD = 0.5
"""Share of the tolerances for knots, later moved onto the curve."""
ROOM = 0.9
"""Share of the tube for knots."""
END = 0.01
"""Share of the tube for the last knot, later moved onto the curve."""
NEARNESS = 1000.0
"""Weight of squared distances from the curve inside a tube [1/m^2]."""


@dataclass(frozen=True, eq=False)
class Offset:
    """Distance of knots from the curve, along three axes [m]: the cost inside a tube."""

    error: CurveError

    @property
    def name(self) -> str:
        return f"distance from the {self.error.name}"

    def linearise(self, motion: Motion) -> Rows:
        rows = self.error.linearise(motion)
        keep = rows.component < POSITION_ROWS - 1
        return Rows(
            rows.value[keep], rows.jacobian[keep], rows.knots[keep], rows.component[keep], rows.place[keep]
        )


def knot_stations(required: FollowsCurve) -> Floats:
    count = int(np.clip(np.ceil(required.until / SPACING), FEWEST, MOST))
    even = np.linspace(0.0, required.until, count + 1)
    for edge in required.curve.edges[1:-1]:
        if edge < required.until:
            even[1 + int(np.abs(even[1:-1] - edge).argmin())] = edge
    return np.unique(even)


def on_the_curve(
    problem: Problem, required: FollowsCurve, seed: CurveTrack, tracker: BudgetTracker
) -> SolveResult:
    error = CurveError(problem.reduced, required, seed.stations)
    bound = within(required, HELD)
    smallest = HELD * min(required.position_tolerance, required.rotation_tolerance)
    held = constraint(error, lower=-bound, upper=bound, tolerance=0.5 * smallest)
    return _solve(problem, (held,), problem.costs or (), seed, tracker)


def in_a_tube(
    problem: Problem, required: FollowsCurve, tube: float, seed: CurveTrack, tracker: BudgetTracker
) -> SolveResult:
    error = CurveError(problem.reduced, required, seed.stations)
    bound = within(required, HELD)
    bound[:POSITION_ROWS] = np.inf
    bound[POSITION_ROWS - 1] = ROOM * tube
    smallest = min(0.02 * tube, 0.25 * required.rotation_tolerance)
    held = constraint(error, lower=-bound, upper=bound, tolerance=smallest)
    costs = (*(problem.costs or ()), Cost(Offset(error), weight=NEARNESS))
    end = replace(required, position_tolerance=max(END * tube, required.position_tolerance))
    return _solve(replace(problem, goal=end), (held,), costs, seed, tracker)


def _solve(
    problem: Problem,
    held: tuple[Constraint, ...],
    costs: Sequence[Cost],
    seed: CurveTrack,
    tracker: BudgetTracker,
) -> SolveResult:
    whole = replace(
        problem, constraints=(*problem.constraints, *held), costs=tuple(costs), knots=len(seed.stations)
    )
    program = transcribe(whole, seed.positions)
    with tracker.optimising(program.counts) as step:
        solved = Sqp().solve(program, seed.positions, progress=step)
    tracker.count(programs=1, qp_solves=solved.qp_solves, qp_iterations=solved.qp_iterations)
    return solved


SIDES = 6
"""Number of sides to which curves are bent."""
BENT = 0.75
"""Displacement of bent curves, as a share of the tube's radius."""
POSES = 12
"""Poses of a bent curve."""


@dataclass(frozen=True, eq=False)
class Detour:
    """A joint path inside the tube.

    Attributes:
        required: The curve through its knots, with the rotations of the blocked one.
        deviation: Largest distance of a knot from the blocked curve [m].
    """

    required: FollowsCurve
    way: CurveTrack
    deviation: float


def detours(problem: Problem, on_curve: OnCurve, starts: Floats, tube: float) -> Sequence[Detour]:
    """Search detours inside a tube [m] around an obstacle on a curve, nearest to the curve first."""
    reduced = problem.reduced
    found: list[Detour] = []
    with on_curve.stage("deviate"):
        seeds = list(_seeds(on_curve, starts, tube))
    for seed in seeds:
        first = readonly(reduced.all_positions(seed.positions[0]))
        solved = in_a_tube(replace(problem, start=first), on_curve.required, tube, seed, on_curve.tracker)
        if solved.feasible:
            with on_curve.stage("deviate"):
                found.append(_detour(on_curve, CurveTrack(seed.stations, solved.x)))
    return sorted(found, key=lambda detour: detour.deviation)


def _detour(on_curve: OnCurve, knots: CurveTrack) -> Detour:
    required = on_curve.required
    places = required.curve(knots.stations)
    points = on_curve.points(knots.positions)
    points[0], points[-1] = places.translation[0], places.translation[-1]
    curve = _through(points, places.rotation)
    far = float(np.linalg.norm(points - places.translation, axis=1).max())
    along = replace(required, curve=curve, until=curve.length)
    return Detour(along, CurveTrack(curve.poses, knots.positions), far)


def _seeds(on_curve: OnCurve, starts: Floats, tube: float) -> Iterator[CurveTrack]:
    required = on_curve.required
    stations = knot_stations(required)
    bent = [
        replace(required, curve=curve, until=curve.length)
        for curve in _bent_curves(required.curve, required.until, BENT * tube)
    ]
    for along in (required, *bent):
        guided = on_curve.along(along)
        places = stations * (along.until / required.until)
        tracks = track(guided, places, starts, np.full_like(starts, np.nan))
        longest = max(tracks, key=lambda each: each.reached)
        missing = len(stations) - len(longest.stations)
        if missing <= 0:
            yield CurveTrack(stations, longest.positions[: len(stations)])
        elif len(longest.stations) > len(stations) // 2:
            held = np.tile(longest.positions[-1], (missing, 1))
            yield CurveTrack(stations, np.concatenate((longest.positions, held)))


def _bent_curves(curve: Curve, until: float, far: float) -> Iterator[Curve]:
    share = np.linspace(0.0, 1.0, POSES)
    places = curve(share * until)
    rates = np.gradient(places.translation, axis=0)
    chord = rates[POSES // 2]
    length = float(np.linalg.norm(chord))
    along = chord / length if length > 0.0 else np.array((1.0, 0.0, 0.0))
    first = np.cross(along, np.eye(3)[int(np.abs(along).argmin())])
    first /= np.linalg.norm(first)
    second = np.cross(along, first)
    size = np.minimum(1.0, 2.0 * np.sin(np.pi * share))
    for angle in np.arange(SIDES) * (2.0 * np.pi / SIDES):
        aside = far * size[:, None] * (np.cos(angle) * first + np.sin(angle) * second)
        moved = places.translation + aside
        yield _through(moved, places.rotation)


def _through(points: Floats, rotations: Floats) -> Curve:
    each = zip(rotations, points, strict=True)
    return spline([Placement(readonly(rotation.copy()), readonly(point.copy())) for rotation, point in each])
