"""Limits on the speed of tools: bounds on the path speed, like the velocity limits of joints."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from trajopt.arrays import Floats
from trajopt.retime.states import at_points, within
from trajopt.trajectory import Trajectory

SpeedOfTools: TypeAlias = Callable[[Floats, Floats], Floats]
"""Positions and velocities of the joints, (S, n) each -> m speeds of tools, (S, m) [m/s | rad/s]."""


@dataclass(frozen=True, eq=False)
class ToolLimits:
    """Limited speeds of tools, and what tells them.

    Attributes:
        speeds: What tells the speeds; they must be proportional to the velocities' size.
        limit: Largest speeds, positive, shape (m,) [m/s | rad/s].
        names: What each is, for sentences.
    """

    speeds: SpeedOfTools
    limit: Floats
    names: tuple[str, ...]


def tool_speed_peaks(tools: ToolLimits, trajectory: Trajectory) -> Floats:
    """Bound the speeds in each piece of a trajectory.

    They are taken at the points and half-way between. A parabola through three even samples rises above
    them by an eighth of the second difference; eight times as much is added.

    Returns:
        Shape (k - 1, m) [m/s | rad/s].
    """
    ends, middle = at_points(trajectory), within(trajectory, 0.5)
    sampled = tools.speeds(np.concatenate((ends.q, middle.q)), np.concatenate((ends.v, middle.v)))
    count = len(middle.q)
    left, right, between = sampled[:count], sampled[1 : count + 1], sampled[count + 1 :]
    return np.maximum.reduce((left, right, between)) + np.abs(left - 2.0 * between + right)
