"""Limits on the speed of tools: bounds on the path speed, like the velocity limits of joints."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from trajopt.arrays import Floats, Value
from trajopt.model.trajectory import Trajectory
from trajopt.retime.states import at_points, within

SpeedOfTools: TypeAlias = Callable[[Floats, Floats], Floats]
"""Positions and velocities of the joints, (S, n) each -> m speeds of tools, (S, m) [m/s | rad/s]."""


QUARTERS = (0.25, 0.5, 0.75)
"""Where in each piece speeds are looked at besides its ends."""


@dataclass(frozen=True, eq=False)
class ToolLimits(Value):
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

    They are taken at the points and at quarters between. A parabola through three even samples rises above
    them by an eighth of the second difference; eight times as much is added.

    Returns:
        Shape (k - 1, m) [m/s | rad/s].
    """
    ends, inner = at_points(trajectory), [within(trajectory, share) for share in QUARTERS]
    states = (ends, *inner)
    sampled = tools.speeds(
        np.concatenate([state.q for state in states]), np.concatenate([state.v for state in states])
    )
    count = len(ends.q) - 1
    between = sampled[count + 1 :].reshape(len(QUARTERS), count, -1)
    speeds = np.concatenate((sampled[None, :count], between, sampled[None, 1 : count + 1]))
    rise = np.abs(np.diff(speeds, n=2, axis=0)).max(axis=0)
    return speeds.max(axis=0) + rise
