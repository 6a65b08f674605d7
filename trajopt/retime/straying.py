"""How far a trajectory leaves its path between its points."""

import numpy as np

from trajopt.arrays import Floats
from trajopt.retime.profile import Profile
from trajopt.retime.smooth import SmoothPath
from trajopt.trajectory import Trajectory


def straying(path: SmoothPath, profile: Profile, trajectory: Trajectory) -> Floats:
    """Distance of the middle of each quintic piece from the path.

    The trajectory has the position, velocity and acceleration of the path at its points; between
    them it strays most about the middle, with the sixth power of the length of the piece.

    Args:
        path: The smooth path.
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
    away = trajectory(times[:-1] + h / 2.0) - path(s)
    tangent = path(s, 1)
    square = (tangent**2).sum(axis=1)
    along = np.where(square > 0.0, (away * tangent).sum(axis=1) / np.where(square > 0.0, square, 1.0), 0.0)
    return np.abs(away - along[:, None] * tangent).max(axis=1)
