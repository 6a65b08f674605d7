"""Around what blocks a curve: inside a tube, as near to the curve as may be.

First guesses follow the curve itself and curves that are bent to one side of it; each leads the program
around the obstacle in its own way, and the way that stays nearest is taken.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from trajopt.arrays import Floats, readonly
from trajopt.cartesian.curves import spline
from trajopt.cartesian.on_curve import OnCurve
from trajopt.cartesian.program import in_a_tube, knot_stations
from trajopt.cartesian.tracking import Track, track
from trajopt.model.curve import Curve
from trajopt.model.placement import Placement
from trajopt.model.requirements import FollowsCurve
from trajopt.problem import Problem

SIDES = 6
"""Sides to which curves are bent."""
BENT = 0.75
"""Part of the tube's radius by which they are."""
POSES = 12
"""Poses of a bent curve."""


@dataclass(frozen=True, eq=False)
class Detour:
    """A way inside the tube.

    Attributes:
        required: The curve through its knots, turned as the blocked one is.
        way: Configurations on it.
        deviation: Largest distance of a knot from the blocked curve [m].
    """

    required: FollowsCurve
    way: Track
    deviation: float


def detours(problem: Problem, on_curve: OnCurve, starts: Floats, tube: float) -> Sequence[Detour]:
    """Search ways around what blocks a curve, nearest to the curve first.

    Args:
        problem: Start, scene and limits.
        on_curve: The curve and the arm.
        starts: Configurations to begin in, shape (b, n).
        tube: Radius of the tube [m].
    """
    reduced = problem.reduced
    found: list[Detour] = []
    for guess in _guesses(on_curve, starts, tube):
        first = readonly(reduced.all_positions(guess.positions[0]))
        solved = in_a_tube(replace(problem, start=first), on_curve.required, tube, guess)
        if solved.feasible:
            found.append(_detour(on_curve, Track(guess.stations, solved.x)))
    return sorted(found, key=lambda detour: detour.deviation)


def _detour(on_curve: OnCurve, knots: Track) -> Detour:
    """Lay a curve through knots: their points, the ends of the blocked curve, and its rotations."""
    required = on_curve.required
    places = required.curve(knots.stations)
    points = on_curve.points(knots.positions)
    points[0], points[-1] = places.translation[0], places.translation[-1]
    poses = [
        Placement(readonly(rotation.copy()), readonly(point.copy()))
        for rotation, point in zip(places.rotation, points, strict=True)
    ]
    curve = spline(poses)
    far = float(np.linalg.norm(points - places.translation, axis=1).max())
    along = replace(required, curve=curve, until=curve.length)
    return Detour(along, Track(curve.poses, knots.positions), far)


def _guesses(on_curve: OnCurve, starts: Floats, tube: float) -> Iterator[Track]:
    """Track the curve and bent ones, whatever is in the way."""
    required = on_curve.required
    stations = knot_stations(required)
    bent = [
        replace(required, curve=curve, until=curve.length)
        for curve in _bent_curves(required.curve, required.until, BENT * tube)
    ]
    for along in (required, *bent):
        guided = OnCurve(on_curve.reduced, along, on_curve.query)
        places = stations * (along.until / required.until)
        tracks = track(guided, places, starts, np.full_like(starts, np.nan))
        longest = max(tracks, key=lambda each: each.reached)
        missing = len(stations) - len(longest.stations)
        if missing <= 0:
            yield Track(stations, longest.positions[: len(stations)])
        elif len(longest.stations) > len(stations) // 2:
            held = np.tile(longest.positions[-1], (missing, 1))
            yield Track(stations, np.concatenate((longest.positions, held)))


def _bent_curves(curve: Curve, until: float, far: float) -> Iterator[Curve]:
    """Bend a curve to several sides across its chord, most about its middle, not at all at its ends."""
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
        yield spline(
            [
                Placement(readonly(rotation.copy()), readonly(point.copy()))
                for rotation, point in zip(places.rotation, moved, strict=True)
            ]
        )
