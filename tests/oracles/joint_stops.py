"""Twin of `joint_stop.hpp`: joints that come to rest, each as hard as its limits allow."""

from itertools import pairwise
from math import ceil, sqrt

import numpy as np

from trajopt.robot.joints import EXCESS, JointLimits
from trajopt.timing.time_scaling import TICK
from trajopt.values.arrays import Floats, Ints
from trajopt.values.trajectory import Trajectory

SAMPLES = 2000
Ticks = tuple[int, int, int]


def stop_from(begin: Floats, limits: JointLimits) -> Trajectory:
    """Return the motion that brings joints to rest.

    Args:
        begin: Positions, velocities and accelerations, shape (3, n).
        limits: Of the joints, with the jerk of each limited (`with_jerk`).
    """
    _, velocities, accelerations = begin.tolist()
    moved = zip(velocities, accelerations, limits.acceleration.tolist(), limits.jerk.tolist(), strict=True)
    alone = [_ticks(*each) for each in moved]
    longest = tuple(max(column) for column in zip(*alone, strict=True))
    together = _braked(begin, np.tile(longest, (len(alone), 1)), limits)
    return together if _within(together, limits) else _braked(begin, np.array(alone), limits)


def _ticks(velocity: float, acceleration: float, limit: float, jerk: float) -> Ticks:
    """Return how soon a joint's velocity and acceleration can be zero, within limits of it and its jerk."""
    # The velocity that is left where the acceleration is brought to zero at once says which way to brake.
    left = velocity + acceleration * abs(acceleration) / (2.0 * jerk)
    side = 1.0 if left >= 0.0 else -1.0
    speed, gain = side * velocity, side * acceleration
    peak = min(sqrt(max(jerk * speed + gain**2 / 2.0, 0.0)), limit)
    held = (speed + gain**2 / (2.0 * jerk)) / limit - limit / jerk if peak == limit else 0.0
    on, hold, off = (ceil(each / TICK - 1e-9) for each in ((gain + peak) / jerk, max(held, 0.0), peak / jerk))
    on, off = max(on, 1), max(off, 1)
    while True:
        peak = (speed / TICK + gain * on / 2.0) / (on / 2.0 + hold + off / 2.0)
        rise, fall = (gain + peak) / (on * TICK), peak / (off * TICK)
        if max(abs(peak) / limit, abs(rise) / jerk, abs(fall) / jerk) <= 1.0:
            return on, hold, off
        on, hold, off = on + 1, hold + 1, off + 1


def _braked(begin: Floats, ticks: Ints, limits: JointLimits) -> Trajectory:
    """Return the motion of joints that brake in given times.

    Args:
        begin: Positions, velocities and accelerations, shape (3, n).
        ticks: Of each joint's three pieces, shape (n, 3).
        limits: Of the joints.
    """
    _, velocities, accelerations = begin
    on, hold, off = ticks.T * TICK
    peak = (velocities + accelerations * on / 2.0) / (on / 2.0 + hold + off / 2.0)
    jerks = np.stack((-(accelerations + peak) / on, 0.0 * peak, peak / off), axis=1)
    ends = np.cumsum(ticks, axis=1)
    times = np.unique(np.concatenate((np.zeros(1, dtype=np.int64), ends.ravel())))
    rows = np.empty((3, len(times), len(on)), dtype=np.float64)
    rows[:, 0] = begin
    for row, (now, then) in enumerate(pairwise(times.tolist())):
        t = TICK * (then - now)
        # Joints whose last piece is over are at rest.
        piece = np.minimum((ends <= now).sum(axis=1), 2)
        jerk = np.where(ends[:, 2] > now, jerks[np.arange(len(piece)), piece], 0.0)
        q, v, a = rows[:, row]
        rows[:, row + 1] = (
            q + t * (v + t * (a / 2.0 + t * jerk / 6.0)),
            v + t * (a + t * jerk / 2.0),
            a + t * jerk,
        )
        rows[1:, row + 1, ends[:, 2] == then] = 0.0  # exactly
    return Trajectory(limits.joint_names, (TICK * times).astype(np.float64), *rows)


def _within(stop: Trajectory, limits: JointLimits) -> bool:
    """Whether a stop holds all limits, at samples: the judge looks at it more closely."""
    times = np.linspace(0.0, stop.duration, SAMPLES)
    position, velocity, acceleration, jerk = (stop(times, order) for order in range(4))
    return bool(
        (position >= limits.lower).all()
        and (position <= limits.upper).all()
        and (np.abs(velocity) <= limits.velocity * (1.0 + EXCESS)).all()
        and (np.abs(acceleration) <= limits.acceleration * (1.0 + EXCESS)).all()
        and (np.abs(jerk) <= limits.jerk * (1.0 + EXCESS)).all()
    )
