"""A smooth path on a grid, with everything that the passes over it need."""

from dataclasses import dataclass

import numpy as np

from trajopt.arrays import Floats
from trajopt.model.limits import JointLimits
from trajopt.model.trajectory import Trajectory
from trajopt.retime.cores import fastest
from trajopt.retime.profile import Profile, from_control
from trajopt.retime.ramp import RampedPath
from trajopt.retime.smooth import SmoothPath
from trajopt.retime.stages import Rows, squared_speed_bound, stations
from trajopt.retime.tool import ToolLimits
from trajopt.retime.torque_along import RampedTorque, TorqueAlong


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
class Course:
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


def course(
    path: SmoothPath | RampedPath,
    s: Floats,
    limits: JointLimits,
    *,
    torque: TorqueAlong | RampedTorque | None,
    tools: ToolLimits | None,
) -> Course:
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
    return Course(s, q, dq, ddq, slope, rows, bounds)


def fastest_profile(course: Course, bounds: Bounds) -> Profile:
    """Find the fastest profile from rest to rest within limits that hold at the grid points."""
    bound = squared_speed_bound(course.slope, bounds.velocity)
    return from_control(course.s, fastest(course.s, course.rows, bounds.rows, bound))


def trajectory(course: Course, profile: Profile, joint_names: tuple[str, ...]) -> Trajectory:
    """Time a path: a point of the trajectory at each grid point."""
    x = profile.x[:, None]
    return Trajectory(
        joint_names,
        profile.times,
        course.q,
        course.dq * np.sqrt(x),
        course.dq * profile.u[:, None] + course.ddq * x,
    )
