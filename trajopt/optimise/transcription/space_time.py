"""Transcription in space and time: a cubic B-spline over a motion of known duration, among moving objects.

All pieces last equally long, so the limits of velocity, acceleration and jerk are constant linear rows that
hold at all times. The first three control points carry the start's state; the last three coincide, for rest.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property
from math import ceil, inf

import numpy as np

from trajopt.geometry import DynamicObstacles, WorkCounts
from trajopt.geometry.dynamics import DynamicsQuery
from trajopt.optimise.terms import Constraint, constraint
from trajopt.optimise.transcription.bspline import COARSE_SAMPLES, BsplineNlp, KnotPlaces, SplineBasis
from trajopt.optimise.transcription.knots import (
    CLEARANCE_TOLERANCE,
    SWEEP,
    KnotsNlp,
    samples_for,
    shortest_duration,
    swept,
)
from trajopt.optimise.transcription.margins import shrinkable
from trajopt.optimise.transcription.spline_terms import ClearanceInTime, SplineRate, SplineTorque
from trajopt.problem.motion import MotionInTime
from trajopt.problem.problem import Problem
from trajopt.values.arrays import Floats, Ints, Printed, readonly
from trajopt.values.trajectory import Path, Trajectory

MARGIN = SWEEP**2 / (8.0 * 0.025) + CLEARANCE_TOLERANCE
"""Clearance from dynamic obstacles above the required one [m], for the approach between two samples of a body
that turns about a point 2.5 cm away, and for the program's tolerance.
"""
INTERVAL = 0.02
"""Time between checks while the robot stays at a configuration [s]: at 1 m/s obstacles move by 2 cm."""
TOGETHER = 64
"""Times checked together, to bound the memory for distances."""


@dataclass(frozen=True, eq=False)
class ObstacleMargins(Printed):
    """The margins that one program keeps from dynamic obstacles, and the spare clearance of states.

    Attributes:
        rows: The obstacles, for the rows of programs: remembers their samples; one per thread.
        checks: The same for all else.
    """

    rows: DynamicObstacles
    checks: DynamicObstacles
    _stays: dict[tuple[bytes, float, float], Floats] = field(
        init=False, repr=False, default_factory=dict[tuple[bytes, float, float], Floats]
    )

    @staticmethod
    def of(problem: Problem, counts: WorkCounts) -> "ObstacleMargins | None":
        """Return the margins of a problem; None if nothing in its scene changes with time."""
        rows, checks = (DynamicObstacles.of(problem.reduced, counts, problem.evaluator) for _ in range(2))
        return None if rows is None or checks is None else ObstacleMargins(rows, checks)

    @cached_property
    def margin(self) -> Floats:
        """Clearance to keep above the required one: a little, or a stated margin, (p,) [m]."""
        pairs = self.checks.timed.reduced.pairs
        return np.where(shrinkable(pairs), MARGIN, pairs.margin - pairs.required)

    def spare(self, positions: Floats, times: Floats) -> Floats:
        """Return the least clearance of each pair above the required one, no more than its margin, (p,) [m].

        Args:
            positions: Shape (s, n) [rad | m].
            times: Shape (s,) [s].
        """
        spare = self.margin.copy()
        found = self.checks.contacts(positions, times, self.checks.required(), within=self.margin)
        near = found.present
        np.minimum.at(spare, found.pair[near], found.least_spare[near])
        return spare

    def samples(self, corners: Floats, times: Floats, way: Floats) -> Ints:
        """Return the number of samples that obstacles demand between corners of a motion, shape (s - 1,).

        One if no obstacle can be too near anywhere between two corners.

        Args:
            corners: Shape (s, n) [rad | m].
            times: Shape (s,) [s].
            way: Travel of the robot between them, shape (s - 1,) [m].
        """
        # They may go opposite ways.
        resting = self.checks.timed.positions(np.repeat(corners[:1], len(times), axis=0), times)
        both = way + swept(self.checks.query, resting)
        least = self.checks.required(self.margin)
        found = self.checks.contacts(corners, times, least, within=float(both.max(initial=0.0)))
        spare = np.full(len(times), inf)
        np.minimum.at(spare, found.sample, found.least_spare)
        # A distance that is d1 here and d2 there is nowhere between less than half of d1 + d2 - way.
        near = spare[:-1] + spare[1:] < both
        return np.where(near, samples_for(both, 1, SWEEP / 2.0), 1)

    def spare_staying(self, positions: Floats, begin: float, dwell: float) -> Floats:
        """Return each pair's clearance above the required one during a stay from `begin` [s], (p,) [m].

        Args:
            positions: Shape (n,) [rad | m].
            dwell: Length of the stay [s].
        """
        asked = (positions.tobytes(), begin, dwell)
        if asked not in self._stays:
            times = begin + np.linspace(0.0, dwell, 1 + ceil(dwell / INTERVAL))
            self._stays[asked] = self.spare(np.tile(positions, (len(times), 1)), times)
        return self._stays[asked]

    def first_clear(self, positions: Floats, begin: float, until: float, dwell: float) -> float:
        """Return the first time at which the robot can begin to stay somewhere [s]; inf if there is none.

        Args:
            positions: Shape (n,) [rad | m].
            dwell: Length of the stay [s].
        """
        if (self.spare_staying(positions, begin, dwell) >= 0.0).all():
            return begin
        # An obstacle that expires is still present at that very time.
        last = min(self.checks.settled + INTERVAL, until)
        for first in range(1, 1 + ceil(max(last - begin, 0.0) / INTERVAL), TOGETHER):
            times = np.minimum(begin + INTERVAL * np.arange(first, first + TOGETHER), last)
            staying = np.tile(positions, (len(times), 1))
            for time in times[self.checks.clear(staying, times, self.checks.required())].tolist():
                if (self.spare_staying(positions, time, dwell) >= 0.0).all():
                    return time
        return inf


DEGREE = 3
"""Cubic: the acceleration is linear in each piece, and the limits lose nothing."""
RESTING = 3
"""Control points at either end that determine its position, velocity and acceleration."""
TOLERANCE = 1e-3
"""Share of a limit by which a row may miss its bound."""
USED = 1.0 - 2.0 * TOLERANCE
"""Share of each limit that the program uses: no later timing makes up for a tolerance."""
LISTED = 0.5
"""Distance below its limit from which a torque gets a row, as a share of it: a step changes it by less."""
NAMES = ("velocity limit", "acceleration limit", "jerk limit")


@dataclass(frozen=True, eq=False)
class SpaceTimeFamily(Printed):
    """Programs of any duration, and their shared data.

    Attributes:
        end: Where the motion comes to rest, shape (n,) [rad | m].
    """

    base: KnotsNlp
    obstacles: ObstacleMargins | None
    basis: SplineBasis
    places: KnotPlaces
    end: Floats
    dynamics: DynamicsQuery | None

    @property
    def least_duration(self) -> float:
        """A bound below every duration [s]: that of each joint alone; of a start in motion at full speed."""
        limits, start = self.base.problem.limits, self.base.lower[0]
        if self.base.problem.starts_moving:
            return float((np.abs(self.end - start) / limits.velocity).max())
        return shortest_duration(limits, start, self.end)

    def ends_clear(self, duration: float) -> bool:
        return self.obstacles is None or bool((self._spare_after(self.obstacles, duration) >= 0.0).all())

    def _spare_after(self, obstacles: ObstacleMargins, duration: float) -> Floats:
        return obstacles.spare_staying(self.end, duration, self.base.problem.dwell)

    def lasting(self, duration: float) -> "SpaceTimeNlp":
        """Return the program of motions of a duration [s]."""
        base, size = self.base, self.basis.count
        lower, upper = np.tile(base.lower[1], (size, 1)), np.tile(base.upper[1], (size, 1))
        lower[:RESTING] = upper[:RESTING] = self.started(duration)
        lower[-RESTING:] = upper[-RESTING:] = self.end
        items = [*base.constraints, *self._rates(duration)]
        moments = self.places.exact
        if self.dynamics is not None:
            items.append(self._torque(duration))
        if self.obstacles is not None:
            residual = ClearanceInTime(self.obstacles.rows, self._margin(self.obstacles, duration), duration)
            items.append(constraint(residual, lower=0.0, upper=np.inf, tolerance=CLEARANCE_TOLERANCE))
            appearing = self.obstacles.checks.moments
            moments = np.union1d(moments, appearing[appearing < duration] / duration)
        places = KnotPlaces(self.places.parameters, self.places.knots, moments)
        fields = base.problem, base.counts, lower, upper, base.scale, base.query, tuple(items)
        return SpaceTimeNlp(*fields, self.basis, places, duration, self.obstacles)

    def started(self, duration: float) -> Floats:
        """Return the first control points of a motion of a duration, (3, n): its start has its rates."""
        problem, (first, second) = (
            self.base.problem,
            (self.basis.derivatives[order].weight[0] for order in (0, 1)),
        )
        begin = np.tile(self.base.lower[0], (RESTING, 1))
        if problem.starts_moving:
            begin[1] = (problem.start_velocities * duration - first[0] * begin[0]) / first[1]
            bend = problem.start_accelerations * duration**2
            begin[2] = (bend - second[0] * begin[0] - second[1] * begin[1]) / second[2]
        return begin

    def _rates(self, duration: float) -> Iterator[Constraint]:
        problem = self.base.problem
        limits = problem.limits
        begins = problem.start_velocities, problem.start_accelerations, np.zeros(len(self.end))
        sides = zip(NAMES, (limits.velocity, limits.acceleration, limits.jerk), begins, strict=True)
        for order, (name, limit, begin) in enumerate(sides, 1):
            kept = limit
            if order == DEGREE:
                # Between two breaks the acceleration changes by no more than from one limit to the other.
                implied = 2.0 * limits.acceleration / (np.diff(self.basis.breaks).min() * duration)
                kept = np.where(limit < implied, limit, np.inf)
            if not np.isfinite(kept).any():
                continue
            at = self.basis.derivatives[order - 1]
            middle = self.places(self.basis.averages[at.support].mean(axis=1))
            residual = SplineRate(name, at.support, at.weight, kept * duration**order, middle)
            share = np.maximum(USED, np.abs(begin) / limit)
            yield constraint(residual, lower=-share, upper=share, tolerance=TOLERANCE)

    def _torque(self, duration: float) -> Constraint:
        assert self.dynamics is not None
        moments, stencils = self.basis.breaks, self.basis.at_breaks
        weights = np.stack([at.weight / duration**order for order, at in enumerate(stencils)])
        effort = self.base.problem.limits.effort
        residual = SplineTorque(
            self.dynamics, stencils[0].support, weights, effort, USED - LISTED, self.places(moments)
        )
        return constraint(residual, lower=-USED, upper=USED, tolerance=TOLERANCE, reach=LISTED)

    def _margin(self, obstacles: ObstacleMargins, duration: float) -> Floats:
        """Return the clearance that pairs keep, shape (p,) [m].

        Beyond the requirement it is at most half of their excess at the start and at the end.
        """
        start = obstacles.spare_staying(self.base.lower[0], 0.0, 0.0)
        spare = np.minimum(start, self._spare_after(obstacles, duration))
        least = np.minimum(obstacles.margin, np.maximum(spare, 0.0) / 2.0)
        return obstacles.checks.pairs.required + np.where(spare < obstacles.margin, least, obstacles.margin)


@dataclass(eq=False)
class SpaceTimeNlp(BsplineNlp):
    """The program over control points of motions of one duration.

    Attributes:
        duration: Of the motion [s].
    """

    duration: float
    obstacles: ObstacleMargins | None

    def restart(self) -> None:
        """Keep what was measured: the programs of a family are solved in turn, each from the last motion."""

    def sampling(self, x: Floats, *, fine: bool) -> Ints:
        if self.obstacles is None or not fine:
            return super().sampling(x, fine=fine)
        breaks = self.basis.breaks
        corners = self.basis.at_breaks[0](x)
        way = swept(self.query, corners)
        samples = samples_for(way, COARSE_SAMPLES)
        return np.maximum(samples, self.obstacles.samples(corners, breaks * self.duration, way))

    def motion(self, x: Floats, sampling: Ints) -> MotionInTime:
        at = super().motion(x, sampling)
        parameters, _ = self.basis.sampled(sampling, self.places.exact)
        fields = (at.knots, at.support, at.weight, at.place, at.positions, at.query)
        return MotionInTime(*fields, parameters * self.duration)

    def decode(self, x: Floats) -> Path:
        points = self.motion(x, self.sampling(x, fine=False)).positions
        return Path(self.problem.reduced.joint_names, readonly(points))

    def trajectory(self, x: Floats) -> Trajectory:
        duration = self.duration
        position, speed, bend = (stencils(x) for stencils in self.basis.at_breaks)
        return Trajectory(
            self.problem.reduced.joint_names,
            readonly(self.basis.breaks * duration),
            readonly(position),
            readonly(speed / duration),
            readonly(bend / duration**2),
        )
