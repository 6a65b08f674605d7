"""The torque that a trajectory needs."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from trajopt.arrays import Floats, Ints
from trajopt.model.trajectory import Trajectory
from trajopt.retime.states import at_points, joined, within

InverseDynamics: TypeAlias = Callable[[Floats, Floats, Floats], Floats]
"""Positions, velocities and accelerations of the joints, (S, n) each -> their torques (S, n) [Nm | N]."""

PARTS = (0.2, 0.4, 0.6, 0.8)
"""Where within a piece of a trajectory the torque is evaluated, beside its ends, if it is near a limit."""
CLEAR = 0.8
"""Part of a limit below which three samples of a piece are enough."""


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
        return self.inverse_dynamics(q, v, a)[:, self.joints]


def torque_range(torque: TorqueLimits, trajectory: Trajectory) -> tuple[Floats, Floats]:
    """Bound the torque in each piece of a trajectory.

    It is evaluated at the points and half-way between. Parabolas through three even samples rise
    above them by an eighth of the second difference; where eight times as much stays clear of the
    limits, that is the bound. Else four samples between the points and twice what a parabola can add.

    Returns:
        Least and largest torque, shape (k - 1, m) each [Nm | N].
    """
    ends, middle = at_points(trajectory), within(trajectory, 0.5)
    sampled = torque.at(*joined((ends, middle)))
    count = len(middle.q)
    left, right = sampled[:count], sampled[1 : count + 1]
    low, high = _bounded(np.stack((left, sampled[count + 1 :], right)), supplement=1.0)
    near = np.nonzero((np.maximum(high, -low) > CLEAR * torque.limit).any(axis=1))[0]
    if len(near):
        inner = torque.at(*joined([within(trajectory, part, near) for part in PARTS]))
        values = (left[near], *np.split(inner, len(PARTS)), right[near])
        low[near], high[near] = _bounded(np.stack(values), supplement=0.25)
    return low, high


def _bounded(values: Floats, *, supplement: float) -> tuple[Floats, Floats]:
    """Bound what has these even samples (first axis): beyond them by a part of the second difference."""
    crest = supplement * np.abs(np.diff(values, 2, axis=0)).max(axis=0)
    return values.min(axis=0) - crest, values.max(axis=0) + crest
