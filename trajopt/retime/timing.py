"""Timing a smooth path: the fastest profile whose trajectory holds all limits at all times."""

from dataclasses import dataclass, replace

from trajopt.arrays import Bools, readonly
from trajopt.model.limits import JointLimits
from trajopt.retime.course import Bounds, Course, course, fastest_profile, trajectory
from trajopt.retime.grid import even_grid, finer_grid, first_grid, turned
from trajopt.retime.options import RetimeOptions
from trajopt.retime.peaks import Peaks, Slowdown, peaks, slowdown, tightened
from trajopt.retime.refusal import exceeded, unholdable
from trajopt.retime.result import RetimeFailure
from trajopt.retime.smooth import SmoothPath
from trajopt.retime.straying import straying
from trajopt.retime.stretch import hold
from trajopt.retime.torque import TorqueLimits
from trajopt.trajectory import Trajectory

STRICT = 1.0 - 1e-9
"""Part of each limit that a trajectory may use: rounding errors stay below what is left."""
FIRST_POINTS = 80
"""Intervals of the first grid, which only serves to lay the second."""
COARSE = 1.02
"""Pieces that would have to run slower by more than this factor are cut in two."""
STRAY = 5e-6
"""Pieces that leave the path farther than this are cut in two as well [rad | m]."""
MOST_REFINED = 2
"""How many times more points a refined grid may get; a limit still exceeded then is no fault of it."""


@dataclass(frozen=True, eq=False)
class Timing:
    """A timed path.

    Attributes:
        trajectory: It holds all limits.
        first_duration: What the profile would take that holds the limits at the points only [s].
        passes: How many times the profile was computed.
    """

    trajectory: Trajectory
    first_duration: float
    passes: int


def time_path(
    path: SmoothPath, limits: JointLimits, torque: TorqueLimits | None, options: RetimeOptions
) -> Timing | RetimeFailure:
    """Find the fastest timing from rest to rest.

    Args:
        path: The smooth path, of positive length.
        limits: Velocity and acceleration limits.
        torque: Torque limits, if there are any.
        options: Number of points and passes.
    """
    velocity, acceleration = limits.velocity * STRICT, limits.acceleration * STRICT
    limits = replace(limits, velocity=readonly(velocity), acceleration=readonly(acceleration))
    torque = None if torque is None else replace(torque, limit=torque.limit * STRICT)
    first = course(path, first_grid(path.knots, FIRST_POINTS), limits, torque)
    failure = unholdable(first, limits, torque)
    if failure is not None:
        return failure
    rough = fastest_profile(first, first.bounds)
    bends = turned(first.s, first.dq, first.ddq, limits.velocity)
    fine = course(path, even_grid(path.knots, rough, bends, options.points), limits, torque)
    failure = unholdable(fine, limits, torque)
    if failure is not None:
        return failure
    attempt = _attempt(path, fine, fine.bounds, limits, torque)
    best, passes = _improved(path, attempt, limits, torque, options)
    held = hold(best.course, best.trajectory, best.slowdown, torque, options.shortest)
    if isinstance(held, Slowdown):
        return exceeded(best.course, held, limits, torque)
    return Timing(held, max(attempt.trajectory.duration, options.shortest), passes)


@dataclass(frozen=True, eq=False)
class _Attempt:
    """A trajectory that holds some bounds at its points, and what it uses of the limits."""

    course: Course
    bounds: Bounds
    trajectory: Trajectory
    peaks: Peaks
    slowdown: Slowdown
    coarse: Bools

    @property
    def merit(self) -> tuple[bool, float]:
        """Whether pieces are too long, and the duration when slowed down to hold all limits."""
        return bool(self.coarse.any()), self.trajectory.duration * max(1.0, self.slowdown.factor)


def _attempt(
    path: SmoothPath, course: Course, bounds: Bounds, limits: JointLimits, torque: TorqueLimits | None
) -> _Attempt:
    profile = fastest_profile(course, bounds)
    moved = trajectory(course, profile, limits.joint_names)
    measured = peaks(moved, torque)
    needed = slowdown(course, measured)
    coarse = (needed.factors > COARSE) | (straying(path, profile, moved) > STRAY)
    return _Attempt(course, bounds, moved, measured, needed, coarse)


def _improved(
    path: SmoothPath,
    attempt: _Attempt,
    limits: JointLimits,
    torque: TorqueLimits | None,
    options: RetimeOptions,
) -> tuple[_Attempt, int]:
    """Remove what a trajectory exceeds between its points.

    Where that is much, or the path is left, the points are too far apart and the grid is refined;
    where it is little, the limits at the points are lowered.

    Returns:
        The attempt that is fastest when slowed down by what it still exceeds, and how many there were.
    """
    best, passes, most = attempt, 1, MOST_REFINED * len(attempt.course.s)
    while passes < options.passes:
        if attempt.coarse.any() and len(attempt.course.s) < most:
            finer = course(path, finer_grid(attempt.course.s, attempt.coarse), limits, torque)
            attempt = _attempt(path, finer, finer.bounds, limits, torque)
        elif attempt.slowdown.factor > 1.0 + options.remainder:
            bounds = tightened(attempt.course, attempt.bounds, attempt.peaks)
            attempt = _attempt(path, attempt.course, bounds, limits, torque)
        else:
            break
        best, passes = attempt if attempt.merit < best.merit else best, passes + 1
    return best, passes
