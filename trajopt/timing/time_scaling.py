"""Time scaling: a motion q(c) driven along its path on another clock c(t).

With the rate r = dc/dt, primes for derivatives by c and dots for derivatives by t,

    velocity      q' r,
    acceleration  q'' r^2 + q' r.,
    jerk          q''' r^3 + 3 q'' r r. + q' r..,

and torques likewise: A r. + B r^2 + C, with the gravity torques C (Hollerbach, "Dynamic scaling of
manipulator trajectories", Journal of Dynamic Systems, Measurement, and Control 106, 1984; Bobrow, Dubowsky
and Gibson, 1985). Stops along the path, slower execution and waits are such scalings.
"""

from dataclasses import dataclass

import numpy as np

from trajopt.native import timing
from trajopt.robot.joints import EXCESS, JointLimits
from trajopt.values.arrays import Floats, Value
from trajopt.values.trajectory import Trajectory


@dataclass(frozen=True)
class RateChange(Value):
    """A smooth change of the clock rate over the time T = `duration`.

        r(z) = a + (b - a) (3 z^2 - 2 z^3) + s T z (1 - z)^2 + 30 g z^2 (1 - z)^2,    z = t / T

    The slope of the rate is s at the start and 0 at the end, so the acceleration of the motion is continuous.
    With s = g = 0 the clock advances by T (a + b) / 2; g adds T g.

    Attributes:
        before: Rate a at the start.
        after: Rate b at the end.
        duration: T, not negative; with 0 the rate is `after` from the start [s].
        slope: s [1/s].
        bulge: g.
    """

    before: float
    after: float
    duration: float
    slope: float = 0.0
    bulge: float = 0.0

    def at(self, z: Floats) -> tuple[Floats, Floats, Floats, Floats]:
        """Return the clock's advance [s], and r, r. [1/s] and r.. [1/s^2].

        Args:
            z: Share of the duration, 0 to 1, any shape.
        """
        a, b, time = self.before, self.after, self.duration
        if not time:
            none = np.zeros_like(z)
            return none, none + b, none, none
        y, g, lent = 1.0 - z, 30.0 * self.bulge, self.slope * time
        mean = a * z + (b - a) * (z**3 - z**4 / 2.0) + self.bulge * z**3 * (10.0 - 15.0 * z + 6.0 * z**2)
        clock = time * (mean + lent * z**2 * (0.5 - 2.0 * z / 3.0 + z**2 / 4.0))
        rate = a + (b - a) * z**2 * (3.0 - 2.0 * z) + g * (z * y) ** 2 + lent * z * y**2
        first = ((b - a) * 6.0 * z * y + 2.0 * g * z * y * (y - z) + lent * y * (y - 2.0 * z)) / time
        second = ((b - a) * 6.0 * (y - z) + 2.0 * g * (1.0 - 6.0 * z * y) + lent * (6.0 * z - 4.0)) / time**2
        return clock, rate, first, second


@dataclass(frozen=True, eq=False)
class TimeScaling(Value):
    """The clock of a motion at k times.

    Attributes:
        times: Increasing from 0, shape (k,) [s].
        clock: Times of the motion, shape (k,) [s].
        rate: r, shape (k,).
        slope: r., shape (k,) [1/s].
    """

    times: Floats
    clock: Floats
    rate: Floats
    slope: Floats

    def applied_to(self, motion: Trajectory) -> Trajectory:
        """Return the motion on this clock: quintics between the k times."""
        q, v, a = (motion(self.clock, order) for order in range(3))
        rate, slope = self.rate[:, None], self.slope[:, None]
        return Trajectory(motion.joint_names, self.times, q, v * rate, a * rate**2 + v * slope)


def holds_limits(motion: Trajectory, limits: JointLimits) -> bool:
    """Whether a motion of quintics holds acceleration and jerk limits, by its extremes.

    Args:
        motion: Motion of the limits' joints, in their order.
    """
    widths = np.diff(motion.times)
    _, least, largest = timing.motion_extremes(motion.coefficients, widths)
    accelerations = np.maximum(-least, largest)
    # The jerk of a quintic is a parabola: largest at an end, or where it turns.
    square, slope, begin = (
        60.0 * motion.coefficients[0],
        24.0 * motion.coefficients[1],
        6.0 * motion.coefficients[2],
    )
    with np.errstate(divide="ignore", invalid="ignore"):
        turn = np.clip(np.nan_to_num(-slope / (2.0 * square)), 0.0, widths[:, None])
    at = np.stack((np.zeros_like(turn), turn, np.broadcast_to(widths[:, None], turn.shape)))
    jerks = np.abs(begin + at * (slope + at * square))
    return bool(
        (accelerations <= limits.acceleration * (1.0 + EXCESS)).all()
        and (jerks <= limits.jerk * (1.0 + EXCESS)).all()
    )
