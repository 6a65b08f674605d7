"""Timing a smooth path with limits on the jerk: rest to rest, with no acceleration at the ends.

The fastest motion without such limits is averaged over the time that the acceleration takes to rise. On the
clock of that motion a squared clock speed near 1 is what is looked for, which a `Program` finds. What comes
out gives the next clock: then everything is even in time, also where the jerk makes a corner much slower.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from trajopt.arrays import Floats
from trajopt.model.limits import JointLimits
from trajopt.model.trajectory import Trajectory
from trajopt.retime.binding import binding
from trajopt.retime.cores import minimise
from trajopt.retime.course import Bounds, Course, course, trajectory
from trajopt.retime.jerk_program import JerkRows, jerk_rows
from trajopt.retime.options import RetimeOptions
from trajopt.retime.peaks import Peaks, Slowdown, motion_peaks, slowdown, tightened, with_torque
from trajopt.retime.profile import Profile, spline_profile
from trajopt.retime.ramp import RampedPath, RoughMotion, ramped
from trajopt.retime.smooth import SmoothPath
from trajopt.retime.straying import straying
from trajopt.retime.stretch import hold, slowed
from trajopt.retime.tool import ToolLimits
from trajopt.retime.torque import TorqueLimits
from trajopt.retime.torque_along import RampedTorque, TorqueAlong

FIRST_AVERAGE = 1.0
"""Least time that the first motion is averaged over, in intervals of the grid."""
SHOWN = 0.5
"""The acceleration does not rise to its limit in less time than this, in intervals of the grid: faster
changes would happen between the points, unseen."""
FIRST_GAP = 0.3
"""Part of the duration that the first barrier leaves open, when nothing is known of the solution."""
ROUGH_POINTS = 0.6
"""Part of the points on the first clock."""
ROUGH_GAP = 6e-2
"""Part of the duration that the first solution may be from the least."""
GAP = 4e-3
"""The same of the last."""
PASSES = 4
"""Most times that the limits are tightened where the trajectory exceeds them between its points."""
REMAINDER = 2e-3
"""Part of the duration that the final uniform stretch may add without another pass."""
TRIFLE = 1e-9
"""Jerk limits that are smaller count with this, where only a scale is wanted [rad/s^3 | m/s^3]."""
STRAY = 5e-6
"""Farthest that a piece may leave the path [rad | m]; else the grid is made finer."""
COARSE = 1.03
"""A motion that must run slower by more than this factor, after all passes, gets a finer grid as well."""
FINER = 1.6
"""By this factor."""
GRIDS = 3
"""Most grids that are tried."""


@dataclass(frozen=True, eq=False)
class JerkTiming:
    """A jerk-limited trajectory.

    Attributes:
        trajectory: It holds all limits.
        s: Path parameter of each of its points, shape (k,).
        first_duration: What the program asks for, whose rows hold at points [s].
        passes: How many programs were solved.
        binding: Kind of limit -> part of the duration for which it decides how fast the motion is.
    """

    trajectory: Trajectory
    s: Floats
    first_duration: float
    passes: int
    binding: Mapping[str, float]


@dataclass(frozen=True, eq=False)
class _Start:
    """Where to start from, and how far that is from the least duration, as a part of it."""

    control: Floats
    gap: float


@dataclass(frozen=True, eq=False)
class _Attempt:
    """A trajectory within some bounds at its points, and what it uses of the limits."""

    bounds: Bounds
    control: Floats
    profile: Profile
    trajectory: Trajectory
    peaks: Peaks
    slowdown: Slowdown
    torque_known: bool

    @property
    def merit(self) -> tuple[bool, float]:
        """Whether the torque is unknown, and the duration when slowed down to hold all limits [s]."""
        return not self.torque_known, self.trajectory.duration * max(1.0, self.slowdown.factor)


@dataclass(frozen=True, eq=False)
class JerkTimer:
    """Finds nearly the fastest timing within limits on the jerk too.

    Attributes:
        path: The smooth path, of positive length.
        limits: Limits of its joints; jerk limits that are infinite are none.
        torque: Torque limits, if there are any.
        along: The torque along the path, if there are torque limits.
        tools: Limited speeds of tools, if there are any.
        options: Number of points.
    """

    path: SmoothPath
    limits: JointLimits
    torque: TorqueLimits | None
    along: TorqueAlong | None
    tools: ToolLimits | None
    options: RetimeOptions

    def run(self, fastest: Profile) -> JerkTiming | tuple[Course, Slowdown]:
        """Find the timing.

        Args:
            fastest: The fastest profile without jerk limits.

        Returns:
            The timing, or the course and the limit on it that is exceeded however slow the motion is.
        """
        count = self.options.points
        rise = float((self.limits.acceleration / np.maximum(self.limits.jerk, TRIFLE)).max())
        average = max(min(rise, fastest.duration), FIRST_AVERAGE * fastest.duration / count)
        rough = RoughMotion(fastest.times, fastest.s, np.sqrt(fastest.x))
        ramp = ramped(self.path, rough, average=average, count=round(ROUGH_POINTS * count))
        on = self._course(ramp)
        control = self._control(jerk_rows(on, ramp), on.bounds, _even(on), gap=ROUGH_GAP)
        motion = _moved(ramp, spline_profile(on.s, control))
        passes, grids = 1, 0
        while True:
            ramp = ramped(self.path, motion, average=0.0, count=count)
            on = self._course(ramp)
            best, tried = self._improved(jerk_rows(on, ramp))
            passes, grids = passes + tried, grids + 1
            coarse = straying(ramp, best.profile, best.trajectory).max() > STRAY
            if grids == GRIDS or not (coarse or best.slowdown.factor > COARSE):
                break
            motion, count = _moved(ramp, best.profile), round(count * FINER)
        peaks = best.peaks
        if not best.torque_known:
            peaks = with_torque(peaks, best.trajectory, self.torque)
        needed = slowdown(on, peaks)
        held = hold(on, best.trajectory, needed, torque=self.torque, tools=self.tools)
        if isinstance(held, Slowdown):
            return on, held
        decides = binding(on, peaks, measured=best.trajectory, final=held)
        return JerkTiming(held, ramp.way(on.s), best.profile.duration, passes, decides)

    def _course(self, ramp: RampedPath) -> Course:
        torque = None if self.along is None else RampedTorque(self.along, ramp)
        on = course(ramp, ramp.clock, self.limits, torque=torque, tools=self.tools)
        jerk = np.tile(self.limits.jerk, (len(ramp.clock) - 1, 1))
        return replace(on, bounds=replace(on.bounds, jerk=jerk))

    def _control(self, rows: JerkRows, bounds: Bounds, start: _Start, *, gap: float) -> Floats:
        cell = float(rows.course.s[-1]) / self.options.points
        shown = self.limits.acceleration / (SHOWN * cell)
        assert bounds.jerk is not None
        asked = rows.within(replace(bounds, jerk=np.minimum(bounds.jerk, shown)))
        return minimise(asked, start.control, first_gap=start.gap, gap=gap)[0]

    def _attempt(self, rows: JerkRows, bounds: Bounds, start: _Start) -> _Attempt:
        control, on = self._control(rows, bounds, start, gap=GAP), rows.course
        profile = spline_profile(on.s, control)
        moved = trajectory(on, profile, self.limits.joint_names)
        moved = slowed(moved, max(1.0, self.options.shortest / moved.duration))
        peaks = motion_peaks(moved, self.tools, jerk=True)
        needed = slowdown(on, peaks)
        if 1.0 < needed.factor <= 1.0 + REMAINDER:
            # Only a stretch is left to do: then the torque need not be measured before it and after.
            moved = slowed(moved, needed.factor * (1.0 + 1e-12))
            peaks = motion_peaks(moved, self.tools, jerk=True)
            needed = slowdown(on, peaks)
        torque_known = self.torque is None or needed.factor <= 1.0 + REMAINDER
        if self.torque is not None and torque_known:
            peaks = with_torque(peaks, moved, self.torque)
            needed = slowdown(on, peaks)
        return _Attempt(bounds, control, profile, moved, peaks, needed, torque_known)

    def _improved(self, rows: JerkRows) -> tuple[_Attempt, int]:
        """Lower limits where they are exceeded between the points, while that makes the motion faster."""
        on = rows.course
        attempt = best = self._attempt(rows, on.bounds, _even(on))
        passes = 1
        while passes <= PASSES and attempt.slowdown.factor > 1.0 + REMAINDER:
            bounds = tightened(on, attempt.bounds, attempt.peaks)
            attempt = self._attempt(rows, bounds, _Start(attempt.control, GAP))
            best, passes = attempt if attempt.merit < best.merit else best, passes + 1
        return best, passes


def _even(on: Course) -> _Start:
    return _Start(np.ones(len(on.s) + 1), FIRST_GAP)


def _moved(ramp: RampedPath, profile: Profile) -> RoughMotion:
    speed = ramp.way(profile.s, 1) * np.sqrt(profile.x)
    return RoughMotion(profile.times, ramp.way(profile.s), speed)


def limited_jerk(limits: JointLimits, moving: Floats) -> bool:
    """Say whether a joint that moves has a jerk limit.

    Args:
        limits: Of the joints.
        moving: How far each moves, shape (n,) [rad | m].
    """
    return bool(np.isfinite(limits.jerk[moving > 0.0]).any())
