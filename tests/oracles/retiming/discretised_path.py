"""A smooth path on a grid, the limits there, and the fastest profile within them.

The grid has all knots of the path, and points between them evenly in time.
"""

from dataclasses import dataclass

import numpy as np

from tests.oracles import reachability
from tests.oracles.retiming.constraints import RampedTorque, Rows, TorqueAlong, squared_speed_bound
from tests.oracles.retiming.profile import Profile, from_control, stations
from tests.oracles.retiming.smooth_path import RampedPath, SmoothPath
from trajopt.robot.joints import JointLimits
from trajopt.timing import ToolLimits
from trajopt.values.arrays import Bools, Floats
from trajopt.values.trajectory import Trajectory

TURN = 0.25
"""How far a path may turn in an interval [rad]: at sharp corners the speed changes fast."""
MOST_BENDS = 150.0
"""Most intervals that are added because a path turns."""


@dataclass(frozen=True, eq=False)
class Bounds:
    """Limits at every point of a grid, so that they can be tightened in some places only.

    Attributes:
        velocity: Of the n joints and l tools at the k + 1 stations, shape (k + 1, n + l) [rad/s | m/s].
        rows: Of acceleration and torque at the k grid points, shape (k, n + m).
        jerk: Of the n joints in the k - 1 intervals, shape (k - 1, n) [rad/s^3 | m/s^3]; None where it is
            not limited.
    """

    velocity: Floats
    rows: Floats
    jerk: Floats | None = None


@dataclass(frozen=True, eq=False)
class DiscretisedPath:
    """A smooth path on a grid of k points.

    Attributes:
        s: Grid, shape (k,).
        q: Positions at the grid points, shape (k, n) [rad | m].
        dq: dq/ds there, shape (k, n).
        ddq: d²q/ds² there, shape (k, n).
        slope: dq/ds at the stations, and what the tools move per s, shape (k + 1, n + l).
        rows: The n accelerations, then the m limited torques.
        bounds: The limits, the same at all points.
    """

    s: Floats
    q: Floats
    dq: Floats
    ddq: Floats
    slope: Floats
    rows: Rows
    bounds: Bounds


def discretised(
    path: SmoothPath | RampedPath,
    s: Floats,
    limits: JointLimits,
    *,
    torque: TorqueAlong | RampedTorque | None,
    tools: ToolLimits | None,
) -> DiscretisedPath:
    """Evaluate a path and its limits on a grid.

    Args:
        path: The smooth path.
        s: Grid, from 0 to the length of the path, shape (k,).
        limits: Velocity and acceleration limits of its joints.
        torque: Of that path, if there are torque limits.
        tools: Limited speeds of tools, if there are any.
    """
    q, dq, ddq = path(s), path(s, 1), path(s, 2)
    rows, limit = Rows(dq, ddq, np.zeros_like(dq)), limits.acceleration
    if torque is not None:
        more = torque(s)
        rows = Rows(*(np.hstack(pair) for pair in ((dq, more.a), (ddq, more.b), (rows.c, more.c))))
        limit = np.concatenate((limit, torque.limits.limit))
    slope, velocity = path(stations(s), 1), limits.velocity
    if tools is not None:
        slope = np.hstack((slope, tools.speeds(path(stations(s)), slope)))
        velocity = np.concatenate((velocity, tools.limit))
    bounds = Bounds(np.tile(velocity, (len(slope), 1)), np.tile(limit, (len(s), 1)))
    return DiscretisedPath(s, q, dq, ddq, slope, rows, bounds)


def fastest_profile(on: DiscretisedPath, bounds: Bounds) -> Profile:
    """Find the fastest profile from rest to rest within limits that hold at the grid points."""
    bound = squared_speed_bound(on.slope, bounds.velocity)
    return from_control(on.s, largest_control(on.s, on.rows, bounds.rows, bound))


def largest_control(s: Floats, rows: Rows, limit: Floats, bound: Floats) -> Floats:
    """Find the pointwise largest control values of a profile from rest to rest.

    Args:
        s: Grid, increasing, shape (k,).
        rows: The limited quantities at the grid points, m of them.
        limit: Their limits, shape (k, m).
        bound: Bound at the stations, positive, shape (k + 1,).

    Returns:
        Control values of x = (ds/dt)² at the stations, shape (k + 1,); 0 at both ends.
    """
    return reachability.fastest(reachability.stages(s, rows), reachability.constraint_rhs(rows, limit), bound)


def trajectory(on: DiscretisedPath, profile: Profile, joint_names: tuple[str, ...]) -> Trajectory:
    """Time a path: a point of the trajectory at each grid point."""
    x = profile.x[:, None]
    return Trajectory(
        joint_names,
        profile.times,
        on.q,
        on.dq * np.sqrt(x),
        on.dq * profile.u[:, None] + on.ddq * x,
    )


def first_grid(knots: Floats, count: int) -> Floats:
    """Cut a path when nothing is known of its speed but that it starts and ends at rest.

    The cuts are even in the phase of `_phase`, which from rest grows as time does.

    Args:
        knots: Knots of the smooth path, increasing from 0, shape (k,).
        count: Intervals to aim at.

    Returns:
        Grid with all the knots in it, increasing.
    """
    phase = _phase(knots, float(knots[-1]))
    cuts, places = _cut(phase, count)
    return _grid(knots, cuts, places)


def even_grid(knots: Floats, profile: Profile, turning: Floats, count: int) -> Floats:
    """Cut a path so that a profile takes about the same time in each interval, and less in bends.

    Args:
        knots: Knots of the smooth path, all of them in the grid of the profile, shape (k,).
        profile: A profile of the path.
        turning: How far the path has turned at each grid point of the profile [rad].
        count: Intervals to aim at on a straight path.

    Returns:
        Grid with all the knots in it, increasing.
    """
    bend = min(1.0 / TURN, MOST_BENDS / max(float(turning[-1]), 1e-9))
    clock = profile.times * (count / profile.duration) + turning * bend
    places = np.searchsorted(profile.s, knots)
    cuts, marks = _cut(clock[places], round(float(clock[-1])))
    phase = _phase(profile.s, float(knots[-1]))
    return _grid(knots, np.interp(cuts, clock, phase), marks)


def finer_grid(s: Floats, coarse: Bools) -> Floats:
    """Halve intervals that are too coarse, and those beside them.

    Args:
        s: Grid, shape (k,).
        coarse: Which intervals are, shape (k - 1,).
    """
    halved = coarse.copy()
    halved[1:] |= coarse[:-1]
    halved[:-1] |= coarse[1:]
    return np.sort(np.concatenate((s, ((s[:-1] + s[1:]) / 2.0)[halved])))


def turned(s: Floats, dq: Floats, ddq: Floats, velocity: Floats) -> Floats:
    """How far a path has turned: the angle of its tangent, summed up, in joints over their speeds.

    Args:
        s: Grid, shape (k,).
        dq: dq/ds there, shape (k, n).
        ddq: d²q/ds² there, shape (k, n).
        velocity: Velocity limits, shape (n,); where zero, the joint stands still.

    Returns:
        Shape (k,), from 0 [rad].
    """
    scale = np.where(velocity > 0.0, velocity, 1.0)
    tangent, change = dq / scale, ddq / scale
    size = np.maximum(np.linalg.norm(tangent, axis=1), 1e-9 * np.abs(tangent).max())[:, None]
    direction = tangent / size
    across = change - direction * (direction * change).sum(axis=1)[:, None]
    rate = np.linalg.norm(across / size, axis=1)
    # A reversal turns by half a turn at once, where the rate has a pole: no interval turns farther.
    steps = np.minimum((rate[:-1] + rate[1:]) / 2.0 * np.diff(s), np.pi)
    return np.concatenate(((0.0,), np.cumsum(steps)))


def _phase(s: Floats, length: float) -> Floats:
    """Part of a half turn whose cosine runs along the path: near both ends like sqrt(distance)."""
    return np.arccos(np.clip(1.0 - 2.0 * s / length, -1.0, 1.0)) / np.pi


def _cut(clock: Floats, count: int) -> tuple[Floats, list[int]]:
    """Cut each span between knots into equal parts of a clock; also the places of the knots."""
    steps = np.diff(clock)
    parts = np.maximum(1, np.rint(steps * (count / (clock[-1] - clock[0])))).astype(np.int64)
    places = [0, *np.cumsum(parts).tolist()]
    return np.interp(np.arange(places[-1] + 1), places, clock), places


def _grid(knots: Floats, phase: Floats, places: list[int]) -> Floats:
    grid = float(knots[-1]) * np.sin(np.pi / 2.0 * phase) ** 2
    grid[places] = knots
    return grid
