"""Timing a smooth path with limits on the jerk: rest to rest, with no acceleration at the ends.

The fastest motion without such limits is averaged over the time that the acceleration takes to rise. On the
clock of that motion the squared clock speed is near 1, and a `Program` finds it. The result
gives the next clock: then everything is even in time, also where the jerk makes a corner much slower.
"""

from dataclasses import dataclass, replace

import numpy as np

from tests.oracles import barrier
from tests.oracles.retiming.attempt import Attempt, Timer
from tests.oracles.retiming.constraints import RampedTorque
from tests.oracles.retiming.discretised_path import Bounds, DiscretisedPath, discretised
from tests.oracles.retiming.jerk_program import JerkRows, jerk_rows
from tests.oracles.retiming.peaks import path_deviation, tightened
from tests.oracles.retiming.profile import Profile, spline_profile
from tests.oracles.retiming.smooth_path import RampedPath, RoughMotion, ramped
from trajopt.robot.joints import JointLimits
from trajopt.timing.retiming import Retimed, RetimeFailure
from trajopt.values.arrays import Floats

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
"""How many times at most the limits are tightened where the trajectory exceeds them between its points."""
REMAINDER = 2e-3
"""Part of the duration that the final uniform stretch may add without another pass."""
TRIFLE = 1e-9
"""Jerk limits that are smaller count with this, where only a scale is needed [rad/s^3 | m/s^3]."""
DEVIATION = 5e-6
"""Farthest that a piece may leave the path, jerk limited or not [rad | m]; else the grid is made finer."""
COARSE = 1.03
"""A motion that must run slower by more than this factor, after all passes, gets a finer grid as well."""
FINER = 1.6
"""By this factor."""
GRIDS = 3
"""Most grids that are tried."""


@dataclass(frozen=True, eq=False)
class _Start:
    """Where to start from, and how far that is from the least duration, as a part of it."""

    control: Floats
    gap: float


@dataclass(frozen=True, eq=False)
class JerkTimer(Timer):
    """Finds nearly the fastest timing within limits on the jerk too."""

    def run(self, fastest: Profile) -> tuple[Retimed | RetimeFailure, Floats]:
        """Find the timing.

        Args:
            fastest: The fastest profile without jerk limits.

        Returns:
            The result, and the path parameter of each of its points.
        """
        path, count = self.smoothing.path, self.options.points
        rise = float((self.limits.acceleration / np.maximum(self.limits.jerk, TRIFLE)).max())
        average = max(min(rise, fastest.duration), FIRST_AVERAGE * fastest.duration / count)
        rough = RoughMotion(fastest.times, fastest.s, np.sqrt(fastest.x))
        ramp = ramped(path, rough, average=average, count=round(ROUGH_POINTS * count))
        on = self._discretised(ramp)
        control = self._control(jerk_rows(on, ramp), on.bounds, _even(on), gap=ROUGH_GAP)
        motion = _moved(ramp, spline_profile(on.s, control))
        passes, grids = 1, 0
        while True:
            ramp = ramped(path, motion, average=0.0, count=count)
            on = self._discretised(ramp)
            best, attempts = self._improved(jerk_rows(on, ramp))
            passes, grids = passes + attempts, grids + 1
            coarse = path_deviation(ramp, best.profile, best.trajectory).max() > DEVIATION
            if grids == GRIDS or not (coarse or best.slowdown.factor > COARSE):
                break
            motion, count = _moved(ramp, best.profile), round(count * FINER)
        return self.finish(best, best.profile.duration, passes), ramp.way(on.s)

    def _discretised(self, ramp: RampedPath) -> DiscretisedPath:
        torque = None if self.along is None else RampedTorque(self.along, ramp)
        on = discretised(ramp, ramp.clock, self.limits, torque=torque, tools=self.tools)
        jerk = np.tile(self.limits.jerk, (len(ramp.clock) - 1, 1))
        return replace(on, bounds=replace(on.bounds, jerk=jerk))

    def _control(self, rows: JerkRows, bounds: Bounds, start: _Start, *, gap: float) -> Floats:
        cell = float(rows.on.s[-1]) / self.options.points
        shown = self.limits.acceleration / (SHOWN * cell)
        assert bounds.jerk is not None
        asked = rows.within(replace(bounds, jerk=np.minimum(bounds.jerk, shown)))
        return barrier.minimise(asked, start.control, first_gap=start.gap, gap=gap).z

    def _attempt(self, rows: JerkRows, bounds: Bounds, start: _Start) -> tuple[Attempt, Floats]:
        """Return an attempt and its control values."""
        control = self._control(rows, bounds, start, gap=GAP)
        attempt = self.measure(rows.on, bounds, spline_profile(rows.on.s, control), REMAINDER)
        if attempt.slowdown.factor <= 1.0 + REMAINDER:
            attempt = self.measure_torque(attempt)
        return attempt, control

    def _improved(self, rows: JerkRows) -> tuple[Attempt, int]:
        """Lower limits where they are exceeded between the points, while that makes the motion faster."""
        on = rows.on
        attempt, control = self._attempt(rows, on.bounds, _even(on))
        best, passes = attempt, 1
        while passes <= PASSES and attempt.slowdown.factor > 1.0 + REMAINDER:
            bounds = tightened(on, attempt.bounds, attempt.peaks)
            attempt, control = self._attempt(rows, bounds, _Start(control, GAP))
            best, passes = attempt if attempt.merit < best.merit else best, passes + 1
        return best, passes


def _even(on: DiscretisedPath) -> _Start:
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
