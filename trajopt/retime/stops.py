"""Stops along the path: how soon a motion can come to rest without leaving the path that was proven."""

from dataclasses import dataclass, field
from functools import cached_property
from math import ceil, inf

import numpy as np

from trajopt.arrays import Floats, Ints, Value, readonly
from trajopt.model.limits import EXCESS, JointLimits
from trajopt.model.trajectory import Trajectory
from trajopt.native import timing

MOMENT = 0.02
"""Time between the moments at which braking may begin [s]: that much later it begins at most."""
STEP = 1e-3
"""Time step of the braking [s], the cycle of the fastest controllers."""
RAMP = 0.01
"""An acceleration takes at least so long to rise from nothing to its limit, where jerks could be larger [s]:
some steps, which show it."""
SHARES = (0.97, 0.8, 0.6, 0.4)
"""Shares of the limits that braking is tried with. The first leaves room for what lies between steps; the
others, where jerks are limited tightly, for letting go of the brake in time."""
KEPT_STEPS = (5, 3, 2, 1)
"""Each so many steps are a point of the motion: few are judged sooner; where what lies between them is not
within the limits, more are taken."""
KEPT = 0.9
"""Share of the jerk limits that is used: what lies between two steps is near to what is at them."""
NO_RATE = 1e-9
"""A clock this slow stands."""
NEAR = STEP / 10.0
"""Points nearer than this are one [s]: the jerk between them would be rounding."""
NEWTON = 6
"""Steps until rounding; the rate changes little within one step of braking."""


@dataclass(frozen=True, eq=False)
class PathStop(Value):
    """A motion that comes to rest before its end.

    Attributes:
        trajectory: From the time that was asked for, at which its own clock shows 0, to rest.
        leaves: Until then it is the motion as it was, on the clock of that [s].
    """

    trajectory: Trajectory
    leaves: float


@dataclass(frozen=True, eq=False)
class StopsAlong(Value):
    """The earliest stops of a motion along its own path, each tabulated when it is first asked for.

    A braking motion goes on along the path while its clock runs slower and slower. At the rate r of the clock
    a joint of the velocity q', the acceleration q'' and the jerk q''' has the acceleration r^2 q'' + w q' and
    the jerk r^3 q''' + 3 r w q'' + w' q', where w = r' is how fast the rate falls. In each step w is the
    least that the limits allow. To go on with w = 0 is always within those of acceleration, as the motion
    itself is and r is at most 1; so within them no other way to brake is ahead anywhere (Bobrow, Dubowsky and
    Gibson, 1985). Towards the end w rises so that the jerk stays limited: w >= -sqrt(2 r w'), with the
    largest w' there.

    Attributes:
        trajectory: The motion; it ends at rest.
        limits: Of its joints.
    """

    trajectory: Trajectory
    limits: JointLimits
    _table: "dict[int, _Braking | None]" = field(default_factory=dict[int, "_Braking | None"], repr=False)

    def earliest(self, time: float, *, after: float | None = None) -> PathStop:
        """Return the motion from a time on, brought to rest on its path.

        Args:
            time: On the motion, before its end [s].
            after: Until then it goes on as it was [s]; no longer than it must when None.
        """
        duration = self.trajectory.duration
        best, soonest = None, duration - MOMENT
        for number in range(ceil((time if after is None else after) / MOMENT), ceil(duration / MOMENT)):
            if number * MOMENT >= soonest:
                break
            braking = self._braking(number)
            if braking is not None and braking.end < soonest:
                best, soonest = braking, braking.end
        if best is None:
            return PathStop(self.trajectory.between(time, duration), duration)
        return PathStop(self._braked(time, best), best.begin)

    def _braking(self, number: int) -> "_Braking | None":
        """Return the braking that begins at a moment of the table, if there is one within the limits."""
        if number not in self._table:
            tried = (self._tried(number * MOMENT, share) for share in SHARES)
            self._table[number] = next((braking for braking in tried if braking is not None), None)
        return self._table[number]

    def _tried(self, begin: float, share: float) -> "_Braking | None":
        motion = self.trajectory
        limits = (self.limits.acceleration, self.limits.jerk, RAMP)
        rows, last = timing.brake(
            motion.times, self._coefficients, *limits, begin=begin, share=share, kept=KEPT, step=STEP
        )
        if last == inf:
            return None
        clock, rate, slope = rows
        count = len(clock) - 1
        end = clock[-1] + last * (rate[-1] + last * slope[-1] / 3.0)
        times = np.append(STEP * np.arange(count + 1), STEP * count + last)
        shown = np.column_stack((rows, (end, 0.0, 0.0)))
        ways = (_Braking(begin, times, shown, every) for every in KEPT_STEPS)
        return next((way for way in ways if self._holds(self._braked(begin, way))), None)

    def _holds(self, stop: Trajectory) -> bool:
        """Whether a stop keeps the limits at all times: by the extremes of its polynomials."""
        widths, limits = np.diff(stop.times), self.limits
        _, least, largest = timing.motion_extremes(stop.coefficients, widths)
        accelerations = np.maximum(-least, largest)
        # The jerk of a quintic is a parabola: largest at an end, or where it turns.
        square, slope, begin = (
            60.0 * stop.coefficients[0],
            24.0 * stop.coefficients[1],
            6.0 * stop.coefficients[2],
        )
        with np.errstate(divide="ignore", invalid="ignore"):
            turn = np.clip(np.nan_to_num(-slope / (2.0 * square)), 0.0, widths[:, None])
        at = np.stack((np.zeros_like(turn), turn, np.broadcast_to(widths[:, None], turn.shape)))
        jerks = np.abs(begin + at * (slope + at * square))
        return bool(
            (accelerations <= limits.acceleration * (1.0 + EXCESS)).all()
            and (jerks <= limits.jerk * (1.0 + EXCESS)).all()
        )

    @cached_property
    def _coefficients(self) -> Floats:
        """Of quintics, whatever degree the motion has."""
        own = self.trajectory.coefficients
        return readonly(np.concatenate((np.zeros((6 - len(own), *own.shape[1:])), own)))

    def _braked(self, time: float, braking: "_Braking") -> Trajectory:
        """Return the motion from a time on, which brakes from a later time on."""
        own, begin = self.trajectory.times, braking.begin
        # The motion's own points are points of the stop: between two of them its polynomials are smooth.
        inner = braking.at(own[(own > begin) & (own < braking.rows[0, -1])])
        inner = inner[(inner[:, 0] > NEAR) & (inner[:, 0] < braking.times[-1] - NEAR)]
        steps = np.column_stack((braking.times, *braking.rows))[braking.points]
        apart = np.abs(steps[1:-1, None, 0] - inner[None, :, 0]).min(axis=1, initial=inf)
        before = np.concatenate(((time,), own[(own > time + NEAR) & (own < begin)]))
        going = np.column_stack((before - begin, before, np.ones(len(before)), np.zeros(len(before))))
        parts = (going[going[:, 0] < -NEAR], steps[:1], steps[1:-1][apart > NEAR], inner, steps[-1:])
        rows = np.concatenate(parts)
        rows = rows[np.argsort(rows[:, 0], kind="stable")]
        source, rate, slope = rows[:, 1], rows[:, 2, None], rows[:, 3, None]
        inside = (source < self.trajectory.duration)[:, None]
        first, second = inside * self.trajectory(source, 1), inside * self.trajectory(source, 2)
        return Trajectory(
            self.trajectory.joint_names,
            rows[:, 0] - rows[0, 0],
            self.trajectory(source),
            first * rate,
            second * rate**2 + first * slope,
        )


@dataclass(frozen=True, eq=False)
class _Braking(Value):
    """The clock of a motion that brakes, piece by piece a cubic of the time.

    Attributes:
        begin: When braking begins, on the clock of the motion [s].
        times: Since then, shape (k,) [s].
        rows: The clock [s], its rate and the slope of that [1/s], shape (3, k).
        every: Each so many steps are a point of the motion, and both ends.
    """

    begin: float
    times: Floats
    rows: Floats
    every: int

    @property
    def points(self) -> Ints:
        """Which steps are points of the motion."""
        last = len(self.times) - 1
        return np.append(np.arange(0, last, self.every), last)

    @property
    def end(self) -> float:
        """When the motion is at rest [s]."""
        return self.begin + float(self.times[-1])

    def at(self, clock: Floats) -> Floats:
        """Return when the clock shows these times [s], and clock, rate and slope then, shape (k, 4)."""
        step = np.clip(np.searchsorted(self.rows[0], clock, side="right") - 1, 0, len(self.times) - 2)
        width = np.diff(self.times)[step]
        begin, rate, slope = self.rows[:, step]
        bend = np.diff(self.rows[2])[step] / width
        since = np.zeros(len(clock))
        for _ in range(NEWTON):
            off = clock - begin - since * (rate + since * (slope / 2.0 + since * bend / 6.0))
            now = rate + since * (slope + since * bend / 2.0)
            since = np.clip(since + off / np.maximum(now, NO_RATE), 0.0, width)
        shown = begin + since * (rate + since * (slope / 2.0 + since * bend / 6.0))
        now = rate + since * (slope + since * bend / 2.0)
        return np.column_stack((self.times[step] + since, shown, now, slope + since * bend))
