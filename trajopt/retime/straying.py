"""How far a trajectory leaves its path between its points."""

import numpy as np

from trajopt.arrays import Floats
from trajopt.model.trajectory import Trajectory
from trajopt.retime.profile import Profile
from trajopt.retime.ramp import RampedPath
from trajopt.retime.smooth import SmoothPath
from trajopt.retime.states import within

AHEAD = 0.01
"""How far a piece may run ahead of its profile or behind, as a part of its length on the path."""


def straying(path: SmoothPath | RampedPath, profile: Profile, trajectory: Trajectory) -> Floats:
    """Distance of the middle of each quintic piece from the path.

    The trajectory has the position, velocity and acceleration of the path at its points; between
    them it strays most about the middle, with the sixth power of the length of the piece.

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
    # Running a little ahead or behind is no straying; at a reversal there is nothing ahead.
    most = AHEAD * np.diff(profile.s)
    return np.abs(reached - path(s + np.clip(along, -most, most))).max(axis=1)
