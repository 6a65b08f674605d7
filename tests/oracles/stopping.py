"""Twin of `stopping.hpp` and `path_stop.hpp`: the soonest stop of a motion along its own path."""

from dataclasses import dataclass
from math import ceil, inf

import numpy as np

from tests.oracles.retiming.peaks import motion_extremes
from trajopt.robot.joints import EXCESS, JointLimits
from trajopt.timing.time_scaling import KEPT, KEPT_STEPS, MOMENT, RAMP, SHARES, STEP, PathStop
from trajopt.values.arrays import Floats, Ints, Value
from trajopt.values.trajectory import Trajectory

STILL = 1e-9
NEAR = STEP / 10.0
NEWTON = 6


def brake(
    motion: Trajectory,
    limits: JointLimits,
    begin: float,
    *,
    ramp: float,
    share: float,
    kept: float,
    step: float,
) -> tuple[Floats, float]:
    """Return clock, rate and slope after each step, (3, c), and how long the last step is."""
    clock, rate, slope = begin, 1.0, 0.0
    rows = [(clock, rate, slope)]
    while clock < motion.duration:
        if slope < 0.0 and -2.0 * rate / slope <= 2.0 * step:
            return np.array(rows).T, -2.0 * rate / slope
        ahead = rate + step * slope
        end = min(clock + step * (rate + step * slope / 2.0), motion.duration)
        down, up = [], []
        for at, r, since in ((clock, rate, 0.0), (end, ahead, step)):
            first, second, third = (motion(at, order) for order in (1, 2, 3))
            side, speed = np.where(first < 0.0, -1.0, 1.0), np.maximum(np.abs(first), STILL)
            others = side * (r**3 * third + 3.0 * r * slope * second)
            turning = np.maximum(speed + 3.0 * since * r * side * second, STILL)
            most = limits.acceleration / ramp
            down.append((np.maximum(-kept * limits.jerk - others, -most) / turning).max())
            up.append((np.minimum(kept * limits.jerk - others, most) / turning).min())
        hardest = ((-share * limits.acceleration - ahead**2 * second * side) / speed).max()
        away = (share * np.minimum(limits.jerk, most) / speed).min()
        left, bend = rate + step * slope / 2.0, step * away
        soft = (bend - np.sqrt(bend**2 + 8.0 * away * max(left, 0.0))) / 2.0
        then = min(max(hardest, slope + step * max(down), soft), 0.0)
        slower = rate + step * (slope + then) / 2.0
        if slower <= 0.0 or then > slope + step * max(min(up), *down) + STILL:
            break
        clock += step * (rate + step * (2.0 * slope + then) / 6.0)
        rate, slope = slower, then
        rows.append((clock, rate, slope))
    return np.array(rows).T, np.inf


class PlainStops:
    """The earliest stops of a motion along its own path."""

    def __init__(self, trajectory: Trajectory, limits: JointLimits) -> None:
        self.trajectory, self.limits = trajectory, limits

    def earliest(self, time: float, *, after: float | None = None) -> PathStop:
        """Return the motion from a time on, brought to rest on its path."""
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
        tried = (self._tried(number * MOMENT, share) for share in SHARES)
        return next((braking for braking in tried if braking is not None), None)

    def _tried(self, begin: float, share: float) -> "_Braking | None":
        rows, last = brake(self.trajectory, self.limits, begin, ramp=RAMP, share=share, kept=KEPT, step=STEP)
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
        _, least, largest = motion_extremes(stop)
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
            since = np.clip(since + off / np.maximum(now, STILL), 0.0, width)
        shown = begin + since * (rate + since * (slope / 2.0 + since * bend / 6.0))
        now = rate + since * (slope + since * bend / 2.0)
        return np.column_stack((self.times[step] + since, shown, now, slope + since * bend))
