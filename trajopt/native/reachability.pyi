"""Stub of the native core `reachability`; in plain Python: `trajopt.retime.reachability` and `extremes`."""

from trajopt.arrays import Floats

def fastest(distance: Floats, a: Floats, b: Floats, c: Floats, limit: Floats, bound: Floats) -> Floats:
    """Find the pointwise largest control values of a profile from rest to rest.

    Args:
        distance: Between the stations beside each of k grid points, shape (k,).
        a: Factors of the path acceleration in the limited quantities, shape (k, m).
        b: Factors of the squared path speed, shape (k, m).
        c: What remains of them at rest, shape (k, m).
        limit: Their limits, shape (k, m).
        bound: Bound at the stations, shape (k + 1,).

    Returns:
        Control values of x = (ds/dt)² at the stations, shape (k + 1,); 0 at both ends.

    Raises:
        ValueError: If the shapes do not match.
    """

def motion_extremes(coefficients: Floats, widths: Floats) -> tuple[Floats, Floats, Floats]:
    """Find the extremes of the velocity and acceleration of quintic pieces.

    Args:
        coefficients: Of the time in each piece, highest power first, shape (6, k, n).
        widths: How long each piece takes, shape (k,) [s].

    Returns:
        Largest absolute velocities, least and largest accelerations, shape (k, n) each.

    Raises:
        ValueError: If the shapes do not match.
    """
