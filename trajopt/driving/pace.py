"""Pace: a planned motion driven on its path at another rate of its clock, without a jump.

The motion q(c) that was planned is run on a clock c(t). Its rate r = dc/dt goes from what it is to another by
a cubic that begins with the slope that it has and ends with none, and stays there:

    velocity q' r,    acceleration q'' r^2 + q' r.,

with primes for derivatives by the clock and a dot for that by time. So the acceleration is continuous. How
long the change takes is the least of some times with which the limits hold at the polynomials' extremes.
"""

from dataclasses import dataclass
from math import ceil

import numpy as np

from trajopt.robot.limits import JointLimits
from trajopt.timing.within_limits import holds_limits
from trajopt.values.arrays import Floats, Value
from trajopt.values.trajectory import Trajectory

PACES = (1.0, 0.8, 0.5, 0.25)
"""Of a motion as it was planned. Slower ones have shorter stops: at a quarter they take at most a quarter of
the time, and what comes near would have to be as slow for a fifth pace to matter."""
TAKEN = (0.05, 0.1, 0.2, 0.4, 0.8)
"""Times that a change of pace may take [s]: from that of a stop of a light arm to that of a heavy one."""
EVEN = 0.01
"""Time between points of a change besides those of the motion [s]: quintics between them are as near to the
path as the judge's rounding."""
APART = 2e-4
"""Points are no nearer to each other [s]: between nearer ones rounding would be a jerk."""
NEWTON = 8
"""Steps until rounding: each squares the error."""
FINE = 400
"""Places of a change between which the time at which the clock shows something is looked up."""


@dataclass(frozen=True)
class Clock(Value):
    """A clock whose rate changes once.

    Attributes:
        shown: What it shows at the start [s].
        rate: How fast it runs at the start.
        slope: How fast its rate grows at the start [1/s].
        pace: How fast it runs in the end.
        taken: How long the change takes [s].
    """

    shown: float
    rate: float
    slope: float
    pace: float
    taken: float

    @staticmethod
    def even() -> "Clock":
        """Return a clock that shows the time."""
        return Clock(0.0, 1.0, 0.0, 1.0, 0.0)

    def at(self, time: float) -> tuple[float, float, float]:
        """Return what it shows [s], its rate and the slope of that [1/s] at a time [s]."""
        shown, rate, slope = self.rows(np.array((time,)))[:, 0].tolist()
        return shown, rate, slope

    def rows(self, times: Floats) -> Floats:
        """Return the same at times (k,), shape (3, k)."""
        after = np.maximum(times - self.taken, 0.0)
        t = np.minimum(times, self.taken)
        z = t / self.taken if self.taken else np.ones_like(t)
        up, lent = z * z * (3.0 - 2.0 * z), self.slope * self.taken
        grown = z**3 - z**4 / 2.0
        way = self.rate * (z - grown) + self.pace * grown + lent * z * z * (0.5 - 2.0 * z / 3.0 + z * z / 4.0)
        rate = self.rate * (1.0 - up) + self.pace * up + lent * z * (1.0 - z) ** 2
        steep = 6.0 * z * (1.0 - z) * (self.pace - self.rate) / self.taken if self.taken else 0.0 * z
        slope = np.where(after > 0.0, 0.0, steep + self.slope * (1.0 - z) * (1.0 - 3.0 * z))
        return np.stack((self.shown + self.taken * way + after * self.pace, rate, slope))


def run_by(
    planned: Trajectory, begins: tuple[float, float, float], pace: float, limits: JointLimits
) -> tuple[Trajectory, Clock] | None:
    """Return a motion at another pace from a place on, and its clock; None where no change holds the limits.

    Args:
        planned: The motion as it was planned; it ends at rest.
        begins: What its clock shows [s], the rate of that and the slope of the rate [1/s].
        pace: In (0, 1].
        limits: Of its joints.
    """
    shown, rate, slope = begins
    if shown > planned.duration - EVEN:
        return None
    if rate == pace and slope == 0.0:
        clock = Clock(shown, rate, slope, pace, 0.0)
        return _driven(planned, clock), clock
    for taken in TAKEN:
        clock = Clock(shown, rate, slope, pace, taken)
        reached, rates, _ = clock.rows(np.linspace(0.0, taken, FINE + 1))
        if reached[-1] > planned.duration - EVEN:
            return None
        if (rates[1:] <= 0.0).any():
            continue
        motion = _driven(planned, clock)
        if holds_limits(motion, limits):
            return motion, clock
    return None


def _driven(planned: Trajectory, clock: Clock) -> Trajectory:
    """Return a motion as a clock runs, from its start to the motion's end."""
    own = planned.times[planned.times > clock.shown]
    own[-1] = planned.duration
    changes = np.linspace(0.0, clock.taken, FINE + 1)
    reached = clock.rows(changes)[0]
    after = clock.taken + (own - reached[-1]) / clock.pace
    at = np.where(own > reached[-1], after, np.interp(own, reached, changes)) if clock.taken else after
    even = np.linspace(0.0, clock.taken, 1 + ceil(clock.taken / EVEN))
    far = np.abs(at[:-1, None] - even).min(axis=1) > APART
    times = np.sort(np.concatenate((even, at[:-1][far], at[-1:])))
    shown, rate, slope = clock.rows(times)
    shown[-1] = planned.duration
    q, v, a = (planned(shown, order) for order in range(3))
    rate, slope = rate[:, None], slope[:, None]
    return Trajectory(planned.joint_names, times, q, v * rate, a * rate**2 + v * slope)


def where_on(motion: Trajectory, positions: Floats, after: float) -> float:
    """Return when a motion passes positions of its joints, which are on its path [s].

    Args:
        motion: The motion.
        positions: Shape (n,) [rad | m].
        after: Not before then [s].
    """
    times = np.linspace(after, motion.duration, FINE + 1)
    time = float(times[np.linalg.norm(motion(times) - positions, axis=1).argmin()])
    for _ in range(NEWTON):
        velocity = motion(time, 1)
        speed = float(velocity @ velocity)
        if speed > 0.0:
            time += float(velocity @ (positions - motion(time))) / speed
            time = min(max(time, after), motion.duration)
    return time
