"""What retiming does at every grid point and piece: compiled where installed so, else in plain Python."""

import numpy as np

from trajopt.arrays import Floats
from trajopt.model.trajectory import Trajectory
from trajopt.native import installed
from trajopt.retime import barrier, extremes, reachability
from trajopt.retime.program import Program
from trajopt.retime.stages import Rows, rooms, stages, stations

NATIVE = installed("reachability")
"""Whether the native core is in use; an installation without a compiler leaves it out."""


def fastest(s: Floats, rows: Rows, limit: Floats, bound: Floats) -> Floats:
    """Find the pointwise largest control values of a profile from rest to rest.

    Args:
        s: Grid, increasing, shape (k,).
        rows: The limited quantities at the grid points, m of them.
        limit: Their limits, shape (k, m).
        bound: Bound at the stations, positive, shape (k + 1,).

    Returns:
        Control values of x = (ds/dt)² at the stations, shape (k + 1,); 0 at both ends.
    """
    if not NATIVE:
        return reachability.fastest(stages(s, rows), rooms(rows, limit), bound)
    from trajopt.native import reachability as core

    return core.fastest(np.diff(stations(s)), rows.a, rows.b, rows.c, limit, bound)


def minimise(program: Program, z: Floats, *, first_gap: float, gap: float) -> barrier.Minimum:
    """Find control values of nearly the least duration, as `trajopt.retime.barrier.minimise` does."""
    if not NATIVE:
        return barrier.minimise(program, z, first_gap=first_gap, gap=gap)
    from trajopt.native import reachability as core

    tables = (program.rows, program.above, program.below, program.jerk, program.speed)
    rows, above, below, jerk, speed = (np.ascontiguousarray(table) for table in tables)
    found = core.minimise(program.weight, program.bound, rows, above, below, jerk, speed, z, first_gap, gap)
    return barrier.Minimum(*found)


def motion_extremes(trajectory: Trajectory) -> tuple[Floats, Floats, Floats]:
    """Find the largest absolute velocity, least and largest acceleration in each piece.

    Args:
        trajectory: Quintic, of k points and n joints.

    Returns:
        Three arrays (k - 1, n).
    """
    if not NATIVE:
        return extremes.speed_peaks(trajectory), *extremes.acceleration_range(trajectory)
    from trajopt.native import reachability as core

    return core.motion_extremes(trajectory.coefficients, np.diff(trajectory.times))
