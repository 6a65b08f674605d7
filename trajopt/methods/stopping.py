"""Stopping: how a start in motion comes to rest, each joint by itself, as soon as its limits allow."""

from dataclasses import replace
from math import ceil, sqrt

import numpy as np

from trajopt.arrays import readonly
from trajopt.model.limits import JointLimits
from trajopt.model.trajectory import Trajectory
from trajopt.problem import Problem
from trajopt.transcription.free_duration import SHORTEST

TICK = 1e-3
"""Pieces of a stop take multiples of this [s], the cycle of the fastest controllers: in much shorter ones the
jerk of a polynomial is lost to rounding."""
State = tuple[float, float, float]
"""Position, velocity and acceleration of a joint."""
Pieces = tuple[tuple[int, float], ...]
"""Ticks and jerk of each piece."""


def stopping_motion(problem: Problem) -> Trajectory:
    """Return the motion that brings a start in motion to rest soonest.

    Each joint brakes in three pieces of constant jerk: on to a deceleration, with it, and off it again.

    Args:
        problem: The problem; its start is in motion.
    """
    limits, start = with_jerk(problem.limits), problem.reduced.start_positions
    positions, velocities, accelerations, hardest, jerks = (
        [float(value) for value in column]
        for column in (
            start,
            problem.start_velocities,
            problem.start_accelerations,
            limits.acceleration,
            limits.jerk,
        )
    )
    states: list[State] = list(zip(positions, velocities, accelerations, strict=True))
    stops = [_stop(*each) for each in zip(velocities, accelerations, hardest, jerks, strict=True)]
    breaks = {0, *(sum(ticks for ticks, _ in stop[:end]) for stop in stops for end in (1, 2, 3))}
    ticks = np.array(sorted(breaks))
    rows = np.array(
        [
            [_at(tick, state, stop) for state, stop in zip(states, stops, strict=True)]
            for tick in ticks.tolist()
        ]
    )
    rows[-1, :, 1:] = 0.0  # exactly
    return Trajectory(limits.joint_names, TICK * ticks, *np.moveaxis(rows, 2, 0))


def with_jerk(limits: JointLimits) -> JointLimits:
    """Return limits with the jerk limited for every joint: what stops and goes on has no jump between.

    Where none is stated, an acceleration takes as long to rise as the shortest motion there is.
    """
    return replace(limits, jerk=readonly(np.minimum(limits.jerk, limits.acceleration / SHORTEST)))


def _stop(velocity: float, acceleration: float, limit: float, jerk: float) -> Pieces:
    """Bring the velocity and acceleration of a joint to zero, within limits of acceleration and jerk."""
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
            return ((on, -side * rise), (hold, 0.0), (off, side * fall))
        on, hold, off = on + 1, hold + 1, off + 1


def _at(tick: int, state: State, pieces: Pieces) -> State:
    """Return the state of a joint after some ticks."""
    q, v, a = state
    for ticks, jerk in pieces:
        t = TICK * min(tick, ticks)
        q, v, a = q + t * (v + t * (a / 2.0 + t * jerk / 6.0)), v + t * (a + t * jerk / 2.0), a + t * jerk
        tick -= min(tick, ticks)
    return q, v, a
