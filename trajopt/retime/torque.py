"""The torque that a motion needs, along the path and along a trajectory."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from trajopt.arrays import Floats, Ints
from trajopt.retime.stages import Rows
from trajopt.trajectory import Trajectory

InverseDynamics: TypeAlias = Callable[[Floats, Floats, Floats], Floats]
"""Position, velocity and acceleration of the joints, (n,) each -> their torques (n,) [Nm | N]."""

PARTS = np.array([0.2, 0.4, 0.6, 0.8])
"""Where within each piece of a trajectory the torque is evaluated, beside its ends."""


@dataclass(frozen=True, eq=False)
class TorqueLimits:
    """Joints with a torque limit, and what tells their torque.

    Attributes:
        inverse_dynamics: Torques of all joints.
        joints: Places of the limited joints, shape (m,).
        limit: Their limits, shape (m,) [Nm | N].
    """

    inverse_dynamics: InverseDynamics
    joints: Ints
    limit: Floats

    def at(self, q: Floats, v: Floats, a: Floats) -> Floats:
        """Torques of the limited joints at some points, (k, n) each -> (k, m) [Nm | N]."""
        torque = np.empty((len(q), len(self.joints)))
        for row in range(len(q)):
            torque[row] = self.inverse_dynamics(q[row], v[row], a[row])[self.joints]
        return torque


def torque_rows(torque: TorqueLimits, q: Floats, dq: Floats, ddq: Floats) -> Rows:
    """Write the torque along a path as a u + b x + c, u and x the acceleration and squared speed.

    With v = q' ds/dt and a = q' u + q'' x the equation of motion M(q) a + C(q, v) v + g(q) gives
    a = M q', b = M q'' + C(q, q') q', c = g. Torque that is not of this form (friction) is not seen
    here, but is when the trajectory is checked.

    Args:
        torque: The limited joints.
        q: Positions at the grid points, shape (k, n).
        dq: dq/ds there.
        ddq: d²q/ds² there.
    """
    still = np.zeros_like(q)
    c = torque.at(q, still, still)
    return Rows(torque.at(q, still, dq) - c, torque.at(q, dq, ddq) - c, c)


def torque_range(torque: TorqueLimits, trajectory: Trajectory) -> tuple[Floats, Floats]:
    """Least and largest torque in each piece of a trajectory.

    It is evaluated at the points and four times between. The parabola through three samples rises
    above them by at most an eighth of their second difference; twice as much is added.

    Returns:
        Two arrays (k - 1, m) [Nm | N].
    """
    times, count = trajectory.times, len(trajectory.times) - 1
    between = (times[:-1, None] + np.diff(times)[:, None] * PARTS).ravel()
    moments = np.concatenate((times, between))
    sampled = torque.at(trajectory(moments), trajectory(moments, 1), trajectory(moments, 2))
    ends, inner = sampled[: count + 1], sampled[count + 1 :].reshape(count, len(PARTS), -1)
    values = np.concatenate((ends[:-1, None], inner, ends[1:, None]), axis=1)
    crest = np.abs(np.diff(values, 2, axis=1)).max(axis=1) / 4.0
    return values.min(axis=1) - crest, values.max(axis=1) + crest
