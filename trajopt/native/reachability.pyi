"""Stub of the native core `reachability`; the same in plain Python is in tests/oracles."""

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

def minimise(
    weight: Floats,
    bound: Floats,
    rows: Floats,
    above: Floats,
    below: Floats,
    jerk: Floats,
    speed: Floats,
    z: Floats,
    first_gap: float,
    gap: float,
) -> tuple[Floats, int]:
    """Find control values of nearly the least duration; the program is that of `trajopt.retime.jerk_program`.

    Args:
        weight: Of 1 / sqrt(z) in the duration, shape (k + 2,).
        bound: What z must stay below, shape (k + 2,).
        rows: Factors of the limited values in k blocks, shape (k, m + r, 3).
        above: Upper limits of the first m, shape (k, m).
        below: Limits of their negatives, shape (k, m).
        jerk: Limits of the others times sqrt(y), shape (k, r); the first half at the starts.
        speed: Factors of y at the starts and the ends, shape (k, 2, 3).
        z: Where to start, positive; scaled to be within the limits, shape (k + 2,).
        first_gap: Part of the duration that the first barrier leaves open.
        gap: Part of it that the last barrier does.

    Returns:
        The control values, shape (k + 2,), and how many Newton steps were taken.

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
