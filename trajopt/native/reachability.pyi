"""Stub of the native core `reachability`; in plain Python: `trajopt.retime.reachability` and `extremes`."""

from trajopt.arrays import Floats

def fastest(onward: Floats, held: Floats, room: Floats, bound: Floats) -> Floats:
    """Find the pointwise largest control values of a profile from rest to rest.

    Args:
        onward: Factors of the control value after each of k grid points, shape (k, m).
        held: Factors of the control value before it, shape (k, m).
        room: Right-hand sides of the half-planes, positive, shape (k, m).
        bound: Bound at the stations, positive, shape (k + 1,).

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
