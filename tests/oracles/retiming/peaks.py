"""How far a trajectory uses its limits and leaves its path, also between its points, and the remedies."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from tests.oracles import extremes
from tests.oracles.retiming.constraints import TorqueLimits, tool_speed_peaks, torque_range, within
from tests.oracles.retiming.discretised_path import Bounds, DiscretisedPath
from tests.oracles.retiming.profile import Profile
from tests.oracles.retiming.smooth_path import RampedPath, SmoothPath
from trajopt.timing import ToolLimits
from trajopt.values.arrays import Floats
from trajopt.values.trajectory import Trajectory

LEAST_ROOM = 0.1
"""Part of the room beside gravity that tightening always leaves."""
AHEAD = 0.01
"""How far a piece may run ahead of its profile or behind, as a part of its length on the path."""
BINDS = 0.97
"""Part of a piece's speed to which a limit must hold it to count as the one that decides."""
ROUNDS = 16
"""Most stretches; one is enough but for rounding errors and friction."""
ROUNDING = 1e-10
"""Accepted relative overshoot; smaller than the safety factor on the limits."""


@dataclass(frozen=True, eq=False)
class Peaks:
    """Extremes in each of the k - 1 pieces of a trajectory.

    Attributes:
        speed: Largest absolute velocities, then speeds of tools, shape (k - 1, n + l) [rad/s | m/s].
        low: Least accelerations, then least torques if they were measured, shape (k - 1, n + m).
        high: Largest accelerations, then largest torques if they were measured, shape (k - 1, n + m).
        jerk: Largest absolute jerks, shape (k - 1, n) [rad/s^3 | m/s^3]; None if they were not measured.
    """

    speed: Floats
    low: Floats
    high: Floats
    jerk: Floats | None = None


def motion_extremes(trajectory: Trajectory) -> tuple[Floats, Floats, Floats]:
    """Find the largest absolute velocity, least and largest acceleration in each piece.

    Args:
        trajectory: Quintic, of k points and n joints.

    Returns:
        Three arrays (k - 1, n).
    """
    return (extremes.speed_peaks(trajectory), *extremes.acceleration_range(trajectory))


def jerk_peaks(trajectory: Trajectory) -> Floats:
    """Find the largest absolute jerk in each piece: at its ends, or where the parabola turns.

    Args:
        trajectory: Quintic, of k points and n joints.

    Returns:
        Shape (k - 1, n) [rad/s^3 | m/s^3].
    """
    c, h = trajectory.coefficients, np.diff(trajectory.times)[:, None]
    square, rate, first = 60.0 * c[0], 24.0 * c[1], 6.0 * c[2]
    bent = square != 0.0
    turn = np.clip(np.where(bent, -rate / (2.0 * np.where(bent, square, 1.0)), 0.0), 0.0, h)
    values = ((square * t + rate) * t + first for t in (turn, h))
    return np.maximum.reduce([np.abs(first), *(np.abs(value) for value in values)])


def motion_peaks(trajectory: Trajectory, tools: ToolLimits | None, *, jerk: bool = False) -> Peaks:
    """Measure velocity and acceleration, exactly; speeds of tools at samples with a supplement.

    Args:
        trajectory: What to measure.
        tools: Limited speeds of tools, if there are any.
        jerk: Whether to measure the jerk, exactly too.
    """
    speed, low, high = motion_extremes(trajectory)
    if tools is not None:
        speed = np.hstack((speed, tool_speed_peaks(tools, trajectory)))
    return Peaks(speed, low, high, jerk_peaks(trajectory) if jerk else None)


def with_torque(motion: Peaks, trajectory: Trajectory, torque: TorqueLimits | None) -> Peaks:
    """Measure the torque too, at samples with a supplement."""
    if torque is None:
        return motion
    least, largest = torque_range(torque, trajectory)
    return replace(motion, low=np.hstack((motion.low, least)), high=np.hstack((motion.high, largest)))


@dataclass(frozen=True, eq=False)
class Slowdown:
    """How much slower a trajectory must be run so that its limits hold.

    Attributes:
        factor: Of all times; not above 1 when the limits hold.
        column: The limit that requires it: speeds (n + l), accelerations and torques (n + m), jerks (n).
        piece: The piece of the trajectory in which it does.
        factors: What each piece alone would require, shape (k - 1,).
    """

    factor: float
    column: int
    piece: int
    factors: Floats


def slowdown(on: DiscretisedPath, peaks: Peaks) -> Slowdown:
    """Find by how much time must be stretched uniformly.

    Args:
        on: The path on the grid of the trajectory.
        peaks: What was measured of the trajectory.
    """
    factor = factors(on, peaks)
    piece, column = divmod(int(factor.argmax()), factor.shape[1])
    return Slowdown(float(factor[piece, column]), column, piece, factor.max(axis=1))


def factors(on: DiscretisedPath, peaks: Peaks) -> Floats:
    """Find by how much each limit asks each piece to be stretched, shape (k - 1, columns).

    Stretching by k divides velocities by k, by k² accelerations and that part of the torque which is
    not gravity, and by k³ jerks. The columns are those of `Slowdown`.
    """
    velocity = on.bounds.velocity[0]
    speed = peaks.speed / np.where(velocity > 0.0, velocity, 1.0)
    measured = peaks.low.shape[1]
    limit, c = on.bounds.rows[0, :measured], on.rows.c[:, :measured]
    still = (c[:-1] + c[1:]) / 2.0
    least = 1e-9 * limit
    square = np.maximum(
        (peaks.high - still) / np.maximum(limit - still, least),
        (still - peaks.low) / np.maximum(limit + still, least),
    )
    parts = [speed, np.sqrt(np.maximum(square, 0.0))]
    if peaks.jerk is not None and on.bounds.jerk is not None:
        parts.append(np.cbrt(_share(peaks.jerk, on.bounds.jerk)))
    return np.hstack(parts)


def tightened(on: DiscretisedPath, bounds: Bounds, peaks: Peaks) -> Bounds:
    """Lower limits beside the pieces that exceed them, by as much as they do.

    Args:
        on: The path on the grid of the trajectory.
        bounds: Limits with which the trajectory was found.
        peaks: What was measured of it.
    """
    velocity, limit = on.bounds.velocity[0], on.bounds.rows[0]
    over = np.maximum(peaks.speed / np.where(velocity > 0.0, velocity, 1.0), 1.0)
    stations = np.ones_like(bounds.velocity)
    for shift in range(3):  # the stations before, within and after each piece
        part = stations[shift : shift + len(over)]
        np.maximum(part, over, out=part)
    measured = peaks.low.shape[1]
    excess = np.zeros((len(over), len(limit)))
    excess[:, :measured] = np.maximum(np.maximum(peaks.high, -peaks.low) - limit[:measured], 0.0)
    beside = np.vstack((excess[:1], np.maximum(excess[:-1], excess[1:]), excess[-1:]))
    still = np.abs(on.rows.c)
    floor = still + LEAST_ROOM * (limit - still)
    jerk = bounds.jerk
    if jerk is not None and peaks.jerk is not None and on.bounds.jerk is not None:
        share = np.maximum(_share(peaks.jerk, on.bounds.jerk), 1.0)
        jerk = jerk / np.maximum(np.maximum(share, _shifted(share, 1)), _shifted(share, -1))
    return Bounds(bounds.velocity / stations, np.maximum(bounds.rows - beside, floor), jerk)


def _share(jerk: Floats, limit: Floats) -> Floats:
    """Used part of the limits; joints with a limit of zero stand still."""
    return jerk / np.where(limit > 0.0, limit, 1.0)


def _shifted(rows: Floats, by: int) -> Floats:
    """Return each row's neighbour, before it or after; the rows at the ends are their own."""
    return rows[np.clip(np.arange(len(rows)) - by, 0, len(rows) - 1)]


def hold(
    on: DiscretisedPath,
    trajectory: Trajectory,
    needed: Slowdown,
    *,
    torque: TorqueLimits | None,
    tools: ToolLimits | None,
) -> Trajectory | Slowdown:
    """Slow a trajectory down until it holds its limits, and measure that it does.

    Args:
        on: The path on the grid of the trajectory.
        trajectory: What to slow down.
        needed: By how much, as measured.
        torque: Torque limits, if there are any.
        tools: Limited speeds of tools, if there are any.

    Returns:
        The trajectory, or what it still exceeds: torque that does not decrease with the speed.
    """
    for attempt in range(ROUNDS):
        if needed.factor <= 1.0 + ROUNDING:
            return trajectory
        # Each next stretch goes a little beyond, more and more: it must not end in rounding errors.
        trajectory = slowed(trajectory, needed.factor * (1.0 + 1e-12 * 8.0**attempt))
        moved = motion_peaks(trajectory, tools, jerk=on.bounds.jerk is not None)
        needed = slowdown(on, with_torque(moved, trajectory, torque))
    return trajectory if needed.factor <= 1.0 + ROUNDING else needed


def slowed(trajectory: Trajectory, factor: float) -> Trajectory:
    """Run the same path slower: times multiplied by a factor."""
    assert trajectory.velocities is not None and trajectory.accelerations is not None
    return Trajectory(
        trajectory.joint_names,
        trajectory.times * factor,
        trajectory.positions,
        trajectory.velocities / factor,
        trajectory.accelerations / factor**2,
    )


def binding(
    on: DiscretisedPath, peaks: Peaks, *, measured: Trajectory, final: Trajectory
) -> Mapping[str, float]:
    """Say for which part of its duration each kind of limit decides how fast a motion is.

    Args:
        on: The path on the grid of the trajectory.
        peaks: What was measured.
        measured: The trajectory of which it was.
        final: The same, stretched uniformly.

    Returns:
        Kind of limit -> part of the duration, the largest first; those that never decide are left out.
    """
    used = factors(on, peaks) * (measured.duration / final.duration)
    joints, speeds, rows = on.dq.shape[1], on.slope.shape[1], peaks.low.shape[1]
    kinds = np.array(
        ["velocity"] * joints
        + ["tool speed"] * (speeds - joints)
        + ["acceleration"] * joints
        + ["torque"] * (rows - joints)
        + ["jerk"] * (used.shape[1] - speeds - rows)
    )
    decides, share = kinds[used.argmax(axis=1)], np.diff(final.times) / final.duration
    bound = used.max(axis=1) >= BINDS
    parts = {str(kind): float(share[bound & (decides == kind)].sum()) for kind in dict.fromkeys(kinds)}
    return {kind: part for kind, part in sorted(parts.items(), key=lambda item: -item[1]) if part > 0.0}


def path_deviation(path: SmoothPath | RampedPath, profile: Profile, trajectory: Trajectory) -> Floats:
    """Distance of the middle of each quintic piece from the path.

    The trajectory has the position, velocity and acceleration of the path at its points; between
    them it deviates most near the middle, with the sixth power of the length of the piece.

    Args:
        path: The smooth path, over the parameter of the profile.
        profile: The profile with which the trajectory was made.
        trajectory: Of k points.

    Returns:
        Largest joint difference, shape (k - 1,) [rad | m].
    """
    times, speed = profile.times, np.sqrt(profile.x)
    h = np.diff(times)
    # The path parameter half-way, by the quintic with the same ends.
    s = (profile.s[:-1] + profile.s[1:]) / 2.0
    s = s + 5.0 / 32.0 * h * (speed[:-1] - speed[1:]) + h**2 / 64.0 * (profile.u[:-1] + profile.u[1:])
    reached = within(trajectory, 0.5).q
    away, tangent = reached - path(s), path(s, 1)
    square = (tangent**2).sum(axis=1)
    moving = square > 0.0
    along = np.where(moving, (away * tangent).sum(axis=1) / np.where(moving, square, 1.0), 0.0)
    # Running a little ahead or behind is no deviation; at a reversal there is nothing ahead.
    most = AHEAD * np.diff(profile.s)
    return np.abs(reached - path(s + np.clip(along, -most, most))).max(axis=1)
