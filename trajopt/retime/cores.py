"""What retiming does at every grid point and piece: calls of the native core."""

import numpy as np

from trajopt.arrays import Floats
from trajopt.model.trajectory import Trajectory
from trajopt.native import reachability
from trajopt.retime.program import Program
from trajopt.retime.stages import Rows, stations


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
    return reachability.fastest(np.diff(stations(s)), rows.a, rows.b, rows.c, limit, bound)


def minimise(program: Program, z: Floats, *, first_gap: float, gap: float) -> tuple[Floats, int]:
    """Find control values of nearly the least duration by an interior point method.

    Args:
        program: The program.
        z: Positive control values to start from, the first two equal and the last two, shape (k + 1,).
        first_gap: Part of the duration that the first barrier leaves open.
        gap: Part of the duration that may be missing to the least.

    Returns:
        Control values within all limits, shape (k + 1,), and the number of Newton steps.
    """
    tables = (program.rows, program.above, program.below, program.jerk, program.speed)
    rows, above, below, jerk, speed = (np.ascontiguousarray(table) for table in tables)
    return reachability.minimise(
        program.weight, program.bound, rows, above, below, jerk, speed, z, first_gap, gap
    )


def motion_extremes(trajectory: Trajectory) -> tuple[Floats, Floats, Floats]:
    """Find the largest absolute velocity, least and largest acceleration in each piece.

    Args:
        trajectory: Quintic, of k points and n joints.

    Returns:
        Three arrays (k - 1, n).
    """
    return reachability.motion_extremes(trajectory.coefficients, np.diff(trajectory.times))
