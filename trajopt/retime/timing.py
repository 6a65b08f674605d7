"""Timing a smooth path: the fastest profile whose trajectory holds all limits at all times."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from trajopt.arrays import Bools, Floats, readonly
from trajopt.model.limits import JointLimits
from trajopt.model.trajectory import LONGEST, Trajectory
from trajopt.retime.binding import binding
from trajopt.retime.course import Bounds, Course, course, fastest_profile, trajectory
from trajopt.retime.grid import even_grid, finer_grid, first_grid, turned
from trajopt.retime.jerk_timing import JerkTimer, JerkTiming, limited_jerk
from trajopt.retime.options import RetimeOptions
from trajopt.retime.peaks import Peaks, Slowdown, motion_peaks, slowdown, tightened, with_torque
from trajopt.retime.refusal import ROOM, exceeded, unholdable
from trajopt.retime.result import RetimeFailure
from trajopt.retime.smooth import SmoothPath
from trajopt.retime.straying import straying
from trajopt.retime.stretch import hold, slowed
from trajopt.retime.tool import ToolLimits
from trajopt.retime.torque import TorqueLimits
from trajopt.retime.torque_along import TorqueAlong, torque_along

STRICT = 1.0 - 1e-9
"""Part of each limit that a trajectory may use: rounding errors stay below what is left."""
FIRST_POINTS = 80
"""Intervals of the first grid, which only serves to lay the second."""
COARSE = 1.05
"""Pieces that would have to run slower by more than this factor are cut in two."""
STRAY = 5e-6
"""Pieces that leave the path farther than this are cut in two as well [rad | m]."""
TOOL_ROOM = 1e-3
"""Part of each tool's limit that is left free, so that the judge need not look at every millisecond to prove
that the limit holds."""
REFINEMENTS = 3
"""How often the grid is refined; a limit that is still exceeded then is no fault of the grid."""


@dataclass(frozen=True, eq=False)
class Timing:
    """A timed path.

    Attributes:
        trajectory: It holds all limits.
        s: Path parameter of each of its points, shape (k,).
        first_duration: What the profile would take that holds the limits at the points only [s].
        passes: How many times the profile was computed.
        binding: Kind of limit -> part of the duration for which it decides how fast the motion is.
    """

    trajectory: Trajectory
    s: Floats
    first_duration: float
    passes: int
    binding: Mapping[str, float]


@dataclass(frozen=True, eq=False)
class _Attempt:
    """A trajectory that holds some bounds at its points, and what it uses of the limits.

    Attributes:
        course: The path on the grid.
        bounds: The bounds that hold at the points.
        duration_at_points: Duration of the profile [s].
        trajectory: The profile's, perhaps a little slower.
        peaks: What was measured of the trajectory.
        slowdown: How much slower it must be run.
        coarse: Which pieces are too long.
        measured: Whether the torque was measured, if it has limits; it costs most, and is not where
            the motion alone asks for another pass.
    """

    course: Course
    bounds: Bounds
    duration_at_points: float
    trajectory: Trajectory
    peaks: Peaks
    slowdown: Slowdown
    coarse: Bools
    measured: bool

    @property
    def merit(self) -> tuple[bool, bool, float]:
        """Pieces too long, torque unknown, and the duration when slowed down to hold all limits."""
        duration = self.trajectory.duration * max(1.0, self.slowdown.factor)
        return bool(self.coarse.any()), not self.measured, duration


@dataclass(frozen=True, eq=False)
class _PathTimer:
    """Finds the fastest timing of a path from rest to rest.

    Attributes:
        path: The smooth path, of positive length.
        limits: Velocity and acceleration limits of its joints.
        torque: Torque limits, if there are any.
        along: The torque along the path, if there are torque limits.
        tools: Limited speeds of tools, if there are any.
        options: Number of points and of passes.
    """

    path: SmoothPath
    limits: JointLimits
    torque: TorqueLimits | None
    along: TorqueAlong | None
    tools: ToolLimits | None
    options: RetimeOptions

    def run(self) -> Timing | RetimeFailure:
        """Lay a grid, find the fastest trajectory on it, and slow that down by what is missing."""
        rough = self._course(first_grid(self.path.knots, FIRST_POINTS))
        failure = unholdable(rough, self.limits, self.torque)
        if failure is not None:
            return failure
        profile = fastest_profile(rough, rough.bounds)
        if not profile.duration <= ROOM * LONGEST:
            reason = f"within all limits together it would take {profile.duration:.2g} s; "
            return RetimeFailure(reason + f"{ROOM * LONGEST:.2g} s are the most", None, 0.0)
        bends = turned(rough.s, rough.dq, rough.ddq, self.limits.velocity)
        fine = self._course(even_grid(self.path.knots, profile, bends, self.options.points))
        failure = unholdable(fine, self.limits, self.torque)
        if failure is not None:
            return failure
        if limited_jerk(self.limits, np.abs(fine.dq).max(axis=0)):
            return self._with_jerk(fine)
        first = self._attempt(fine, fine.bounds, refinable=True)
        best, passes = self._improved(first)
        needed, peaks = best.slowdown, best.peaks
        if not best.measured:
            peaks = with_torque(peaks, best.trajectory, self.torque)
            needed = slowdown(best.course, peaks)
        held = hold(best.course, best.trajectory, needed, torque=self.torque, tools=self.tools)
        if isinstance(held, Slowdown):
            return exceeded(best.course, held, self.limits, self.torque)
        decides = binding(best.course, peaks, measured=best.trajectory, final=held)
        return Timing(held, best.course.s, first.duration_at_points, passes, decides)

    def _with_jerk(self, fine: Course) -> Timing | RetimeFailure:
        timer = JerkTimer(self.path, self.limits, self.torque, self.along, self.tools, self.options)
        found = timer.run(fastest_profile(fine, fine.bounds))
        if isinstance(found, JerkTiming):
            return Timing(found.trajectory, found.s, found.first_duration, found.passes, found.binding)
        return exceeded(*found, self.limits, self.torque)

    def _course(self, s: Floats) -> Course:
        return course(self.path, s, self.limits, torque=self.along, tools=self.tools)

    def _attempt(self, on: Course, bounds: Bounds, *, refinable: bool) -> _Attempt:
        profile = fastest_profile(on, bounds)
        moved = trajectory(on, profile, self.limits.joint_names)
        strayed = straying(self.path, profile, moved)
        if moved.duration < self.options.shortest:
            moved = slowed(moved, self.options.shortest / moved.duration)
        duration, used = moved.duration, motion_peaks(moved, self.tools)
        needed, most = slowdown(on, used), 1.0 + self.options.remainder
        if 1.0 < needed.factor <= most:
            # Only a stretch is left to do: then the torque need not be measured before it and after.
            moved = slowed(moved, needed.factor * (1.0 + 1e-12))
            used = motion_peaks(moved, self.tools)
            needed = slowdown(on, used)
        coarse = (needed.factors > COARSE) | (strayed > STRAY)
        again = needed.factor > most or (refinable and bool(coarse.any()))
        measured = self.torque is None or not again
        if self.torque is not None and measured:
            used = with_torque(used, moved, self.torque)
            needed = slowdown(on, used)
            coarse |= needed.factors > COARSE
        return _Attempt(on, bounds, duration, moved, used, needed, coarse, measured)

    def _improved(self, attempt: _Attempt) -> tuple[_Attempt, int]:
        """Remove what a trajectory exceeds between its points.

        Where that is much, or the path is left, the points are too far apart and the grid is
        refined; where it is little, the limits at the points are lowered.

        Returns:
            The attempt that is fastest when slowed down to hold all limits, and how many there were.
        """
        best, passes, refined = attempt, 1, 0
        while passes < self.options.passes:
            if attempt.coarse.any() and refined < REFINEMENTS:
                refined += 1
                finer = self._course(finer_grid(attempt.course.s, attempt.coarse))
                attempt = self._attempt(finer, finer.bounds, refinable=refined < REFINEMENTS)
            elif attempt.slowdown.factor > 1.0 + self.options.remainder:
                bounds = tightened(attempt.course, attempt.bounds, attempt.peaks)
                attempt = self._attempt(attempt.course, bounds, refinable=refined < REFINEMENTS)
            else:
                break
            best, passes = attempt if attempt.merit < best.merit else best, passes + 1
        return best, passes


def time_path(
    path: SmoothPath,
    limits: JointLimits,
    *,
    options: RetimeOptions,
    torque: TorqueLimits | None = None,
    tools: ToolLimits | None = None,
) -> Timing | RetimeFailure:
    """Find the fastest timing of a path from rest to rest.

    Args:
        path: The smooth path, of positive length.
        limits: Velocity, acceleration and jerk limits.
        options: Number of points and passes.
        torque: Torque limits, if there are any.
        tools: Limited speeds of tools, if there are any.
    """
    limits = replace(
        limits,
        velocity=readonly(limits.velocity * STRICT),
        acceleration=readonly(limits.acceleration * STRICT),
        jerk=readonly(limits.jerk * STRICT),
    )
    torque = None if torque is None else replace(torque, limit=torque.limit * STRICT)
    tools = None if tools is None else replace(tools, limit=tools.limit * (1.0 - TOOL_ROOM))
    along = None if torque is None else torque_along(path, torque)
    return _PathTimer(path, limits, torque, along, tools, options).run()
