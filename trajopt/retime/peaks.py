"""How far a trajectory uses its limits, also between its points, and what follows from it."""

from dataclasses import dataclass, replace

import numpy as np

from trajopt.arrays import Floats
from trajopt.model.trajectory import Trajectory
from trajopt.retime.cores import motion_extremes
from trajopt.retime.course import Bounds, Course
from trajopt.retime.jerk_peaks import jerk_peaks
from trajopt.retime.tool import ToolLimits, tool_speed_peaks
from trajopt.retime.torque import TorqueLimits, torque_range

LEAST_ROOM = 0.1
"""Part of the room beside gravity that tightening always leaves."""


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
        column: The limit that asks for it: speeds (n + l), accelerations and torques (n + m), jerks (n).
        piece: The piece of the trajectory in which it does.
        factors: What each piece alone would ask for, shape (k - 1,).
    """

    factor: float
    column: int
    piece: int
    factors: Floats


def slowdown(course: Course, peaks: Peaks) -> Slowdown:
    """Find by how much time must be stretched uniformly.

    Args:
        course: The path on the grid of the trajectory.
        peaks: What was measured of the trajectory.
    """
    factor = factors(course, peaks)
    piece, column = divmod(int(factor.argmax()), factor.shape[1])
    return Slowdown(float(factor[piece, column]), column, piece, factor.max(axis=1))


def factors(course: Course, peaks: Peaks) -> Floats:
    """Find by how much each limit asks each piece to be stretched, shape (k - 1, columns).

    Stretching by k divides velocities by k, by k² accelerations and that part of the torque which is
    not gravity, and by k³ jerks. The columns are those of `Slowdown`.
    """
    velocity = course.bounds.velocity[0]
    speed = peaks.speed / np.where(velocity > 0.0, velocity, 1.0)
    measured = peaks.low.shape[1]
    limit, c = course.bounds.rows[0, :measured], course.rows.c[:, :measured]
    still = (c[:-1] + c[1:]) / 2.0
    least = 1e-9 * limit
    square = np.maximum(
        (peaks.high - still) / np.maximum(limit - still, least),
        (still - peaks.low) / np.maximum(limit + still, least),
    )
    parts = [speed, np.sqrt(np.maximum(square, 0.0))]
    if peaks.jerk is not None and course.bounds.jerk is not None:
        parts.append(np.cbrt(_share(peaks.jerk, course.bounds.jerk)))
    return np.hstack(parts)


def tightened(course: Course, bounds: Bounds, peaks: Peaks) -> Bounds:
    """Lower limits beside the pieces that exceed them, by as much as they do.

    Args:
        course: The path on the grid of the trajectory.
        bounds: Limits with which the trajectory was found.
        peaks: What was measured of it.
    """
    velocity, limit = course.bounds.velocity[0], course.bounds.rows[0]
    over = np.maximum(peaks.speed / np.where(velocity > 0.0, velocity, 1.0), 1.0)
    stations = np.ones_like(bounds.velocity)
    for shift in range(3):  # the stations before, within and after each piece
        part = stations[shift : shift + len(over)]
        np.maximum(part, over, out=part)
    measured = peaks.low.shape[1]
    excess = np.zeros((len(over), len(limit)))
    excess[:, :measured] = np.maximum(np.maximum(peaks.high, -peaks.low) - limit[:measured], 0.0)
    beside = np.vstack((excess[:1], np.maximum(excess[:-1], excess[1:]), excess[-1:]))
    still = np.abs(course.rows.c)
    floor = still + LEAST_ROOM * (limit - still)
    jerk = bounds.jerk
    if jerk is not None and peaks.jerk is not None and course.bounds.jerk is not None:
        share = np.maximum(_share(peaks.jerk, course.bounds.jerk), 1.0)
        jerk = jerk / np.maximum(np.maximum(share, _shifted(share, 1)), _shifted(share, -1))
    return Bounds(bounds.velocity / stations, np.maximum(bounds.rows - beside, floor), jerk)


def _share(jerk: Floats, limit: Floats) -> Floats:
    """Used part of the limits; joints with a limit of zero stand still."""
    return jerk / np.where(limit > 0.0, limit, 1.0)


def _shifted(rows: Floats, by: int) -> Floats:
    """Return each row's neighbour, before it or after; the rows at the ends are their own."""
    return rows[np.clip(np.arange(len(rows)) - by, 0, len(rows) - 1)]
