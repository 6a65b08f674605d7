"""Time scaling: a motion q(c) driven on another clock c(t): slower, stopped, or with waits.

With the rate r = dc/dt, primes for derivatives by c and dots for derivatives by t,

    velocity      q' r,
    acceleration  q'' r^2 + q' r.,
    jerk          q''' r^3 + 3 q'' r r. + q' r..,

and torques likewise: A r. + B r^2 + C, with the gravity torques C (Hollerbach, "Dynamic scaling of
manipulator trajectories", Journal of Dynamic Systems, Measurement, and Control 106, 1984; Bobrow, Dubowsky
and Gibson, 1985).
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from trajopt.native import timing
from trajopt.robot.joints import EXCESS, JointLimits
from trajopt.values.arrays import Floats, Ints, Value
from trajopt.values.cached import cached_per_value
from trajopt.values.trajectory import MEETING, Trajectory


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


MOMENT = 0.02
"""Interval between the times at which braking may begin [s]."""
STEP = 1e-3
"""Time step of the braking, the cycle of the fastest controllers [s]."""
RAMP = 0.01
"""Shortest time in which an acceleration rises from zero to its limit if jerk limits allow less; a few steps,
which resolve it [s].
"""
SHARES = (0.97, 0.8, 0.6, 0.4)
"""Shares of the limits that braking is tried with, with room for extremes between steps and time to release
the brake under tight jerk limits.
"""
KEPT_STEPS = (5, 3, 2, 1)
"""Steps per point of the stop motion, as few points are judged faster; decreased if the limits are exceeded
between points.
"""
KEPT = 0.9
"""Share of the jerk limits used, as a reserve for extremes between steps."""


@dataclass(frozen=True, eq=False)
class PathStop(Value):
    """A motion that comes to rest before its end.

    Attributes:
        trajectory: From the requested time, at which its own clock shows 0, to rest.
        leaves: Time up to which it equals the original motion, on the clock of the original [s].
    """

    trajectory: Trajectory
    leaves: float


@dataclass(frozen=True, eq=False)
class StopsAlong(Value):
    """Early stops of a motion along its own path, tabulated on first use.

    A braking motion follows the path while its clock rate r falls (`trajopt.timing.time_scaling`). Each step
    takes the smallest slope w = dr/dt that a share of the limits allows. With w = 0 the acceleration limits
    always hold; so no other braking within the same share is shorter (Bobrow, Dubowsky and Gibson,
    "Time-optimal control of robotic manipulators along specified paths", International Journal of Robotics
    Research 4, 1985). At the end w rises within the jerk limits: w >= -sqrt(2 r dw/dt), with the largest
    feasible slope of w.

    Attributes:
        trajectory: The motion; it ends at rest.
    """

    trajectory: Trajectory
    limits: JointLimits

    def earliest(self, time: float, *, after: float | None = None) -> PathStop:
        """Return the motion from a given time on, stopped along its path.

        Args:
            time: Time of the motion, before its end [s].
            after: Time until which it continues unchanged [s]; the earliest possible by default.
        """
        found, names = (
            self._core.earliest(time, time if after is None else after),
            self.trajectory.joint_names,
        )
        if found is None:
            duration = self.trajectory.duration
            return PathStop(self.trajectory.between(time, duration), duration)
        *points, leaves = found
        return PathStop(Trajectory(names, *points), leaves)

    @cached_property
    def _core(self) -> timing.Stops:
        own = self.trajectory.coefficients
        quintics = np.concatenate((np.zeros((6 - len(own), *own.shape[1:])), own))
        return timing.Stops(
            self.trajectory.times,
            quintics,
            self.limits.acceleration,
            self.limits.jerk,
            shares=SHARES,
            every=KEPT_STEPS,
            ramp=RAMP,
            kept=KEPT,
            step=STEP,
            moment=MOMENT,
            excess=EXCESS,
        )


TICK = 1e-3
"""Pieces of a stop last multiples of this, the cycle of the fastest controllers [s].

In much shorter pieces the jerk of a polynomial is lost to rounding.
"""


def stop_from(begin: Floats, limits: JointLimits) -> Trajectory:
    """Return a motion that stops the joints as fast as their limits allow.

    Three pieces of constant jerk: ramp up, hold and ramp down the deceleration. All joints brake together,
    which nearly preserves the direction of motion; if this violates a limit, each brakes alone.

    Args:
        begin: Positions, velocities and accelerations, shape (3, n).
        limits: With finite acceleration and jerk limits.
    """
    times, rows = timing.stop_from(begin, limit_rows(limits), TICK, EXCESS)
    return Trajectory(limits.joint_names, times, *rows)


def stop_after(begin: Floats, end: Floats, duration: float, limits: JointLimits) -> Trajectory:
    """Return a motion of one piece between two states, of a duration [s], followed by `stop_from`."""
    return stop_at_the_end(np.array((0.0, duration)), np.stack((begin, end), axis=1), limits)


def stop_at_the_end(times: Floats, states: Floats, limits: JointLimits) -> Trajectory:
    """Return a motion through states, followed by the stop of `stop_from`.

    Args:
        times: Of the states, shape (k,) [s].
        states: Positions, velocities and accelerations, shape (3, k, n).
    """
    later, rows = timing.stop_from(np.ascontiguousarray(states[:, -1]), limit_rows(limits), TICK, EXCESS)
    whole = np.concatenate((states[:, :-1], rows), axis=1)
    return Trajectory(limits.joint_names, np.concatenate((times[:-1], times[-1] + later)), *whole)


def tracking(
    begin: Floats,
    times: Floats,
    due: Ints,
    targets: Floats,
    weights: Floats,
    limits: JointLimits,
    *,
    counted: int,
) -> tuple[Floats, Floats, int]:
    """Return a motion of jerks that are constant between times, and which stays near targets a_k.

    It minimises the sum over the targets of (q_k - a_k)^2, and over the times of (w j_k)^2, where j_k are the
    jerks: a linear-quadratic regulator, by a recursion in square-root form (Bierman, "Factorization methods
    for discrete sequential estimation", 1977). w is the first weight for which the limits hold up to all
    targets that count, or else up to most of them.

    Args:
        times: Of the begin and later, shape (k + 1,) [s].
        due: Indices in `times` of the targets, above 0, shape (m,).
        targets: Shape (m, n) [rad | m].
        weights: Of the jerks, shape (w,) [s^3].
        counted: Number of targets that count, the first.

    Returns:
        States at the times, shape (3, k + 1, n), the jerks between them, shape (k, n), and the number of
        targets up to the first time at which a limit is exceeded, at most `counted`.
    """
    return timing.track(begin, times, due, targets, counted, weights, limit_rows(limits))


@cached_per_value
def limit_rows(limits: JointLimits) -> Floats:
    """Return the limits for the native cores: lower, upper, velocity, acceleration, jerk; shape (5, n)."""
    return np.stack((limits.lower, limits.upper, limits.velocity, limits.acceleration, limits.jerk))


JOLT = 1e-3
"""Time in which an acceleration at the start or end of a motion builds up or decays at rest [s]."""


def begun_later(trajectory: Trajectory, wait: float) -> Trajectory:
    """Return a motion, at rest at its start, that waits there for a time [s].

    A start acceleration is reached at the end of the wait by a quintic from rest, as its largest
    acceleration.
    """
    positions, velocities, accelerations = (
        trajectory.positions, trajectory.velocities, trajectory.accelerations
    )  # fmt: skip
    before = [0.0]
    if accelerations is not None and accelerations[0].any():
        before.append(wait - min(JOLT, wait / 2.0))
    still = np.zeros((len(before), positions.shape[1]))
    return Trajectory(
        trajectory.joint_names,
        np.concatenate((before, trajectory.times + wait)),
        np.concatenate((still + positions[0], positions)),
        None if velocities is None else np.concatenate((still, velocities)),
        None if accelerations is None else np.concatenate((still, accelerations)),
    )


def standing(trajectory: Trajectory, wait: float) -> Trajectory:
    """Return a motion, at rest at its end, that waits there for a time [s].

    An acceleration at its end decays in `JOLT`, or in a shorter wait.
    """
    after = [JOLT, wait] if wait > JOLT else [wait]
    still = np.zeros((len(after), trajectory.positions.shape[1]))
    rates = (trajectory.velocities, trajectory.accelerations)
    return Trajectory(
        trajectory.joint_names,
        np.concatenate((trajectory.times, trajectory.duration + np.array(after))),
        np.concatenate((trajectory.positions, still + trajectory.positions[-1])),
        *(None if rows is None else np.concatenate((rows, still)) for rows in rates),
    )


def after_standing(first: Trajectory, gap: float, second: Trajectory) -> Trajectory:
    """Concatenate two motions, at rest where they meet, with a wait between them [s]."""
    ends = min(JOLT, gap / 2.0)
    return standing(first, ends).followed_by(begun_later(second, gap - ends))


def in_turn(first: Trajectory, second: Trajectory) -> Trajectory:
    """Concatenate two motions from rest to rest; insert a wait only if the acceleration jumps.

    Without jerk limits the first motion may end braking and the second begin accelerating: these are two
    instants, `2 * JOLT` apart.
    """
    ends, begins = first.accelerations, second.accelerations
    if ends is None or begins is None or np.abs(begins[0] - ends[-1]).max() <= MEETING:
        return first.followed_by(second)
    return after_standing(first, 2.0 * JOLT, second)


def travel_time(start: Floats, end: Floats, limits: JointLimits, *, rests: bool) -> Floats:
    """Return the least time from configurations to others within the limits of each joint alone.

    From rest to rest within speed v, acceleration a and jerk j a joint needs (Biagiotti and Melchiorri 2008,
    section 3.4), with a time t to reach v of v/a + a/j, or 2 sqrt(v/j) if v is reached before a:
    d/v + t for a distance d of at least v t; else a/j + sqrt((a/j)^2 + 4 d/a) for one of at least 2 a^3/j^2,
    else (32 d/j)^(1/3). In passing it needs d/v.

    Args:
        start: Shape (..., n) [rad | m].
        end: Shape (..., n) [rad | m].

    Returns:
        Shape (...,) [s].
    """
    way = np.abs(end - start)
    speed, rate, jerk = limits.velocity, limits.acceleration, limits.jerk
    if not rests:
        return (way / speed).max(axis=-1)
    with np.errstate(invalid="ignore"):
        rise = rate / jerk
        ramp = np.where(speed >= rate * rise, speed / rate + rise, 2.0 * np.sqrt(speed / jerk))
        long = way >= 2.0 * rate * rise**2
        short = np.where(long, rise + np.sqrt(rise**2 + 4.0 * way / rate), np.cbrt(32.0 * way / jerk))
    return np.where(way >= speed * ramp, way / speed + ramp, short).max(axis=-1)
