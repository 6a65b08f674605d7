"""The state that a trajectory has at one moment: what loops ask for, cycle after cycle."""

import numpy as np

from trajopt.values.arrays import Floats
from trajopt.values.trajectory import Trajectory


def state_of(trajectory: Trajectory, t: float) -> Floats:
    """Return positions, velocities and accelerations at a time, which is clipped to the duration.

    As from `trajectory(t, order)`, in one step, and as they are stated at the ends of a trajectory that
    states them all.

    Args:
        trajectory: Of n joints.
        t: Time [s].

    Returns:
        Shape (3, n).
    """
    times, duration = trajectory.times, trajectory.duration
    velocities, accelerations = trajectory.velocities, trajectory.accelerations
    if velocities is not None and accelerations is not None and not 0.0 < t < duration:
        end = 0 if t <= 0.0 else -1
        return np.array((trajectory.positions[end], velocities[end], accelerations[end]))
    moment = min(max(t, 0.0), duration)
    segment = min(max(int(times.searchsorted(moment, side="right")) - 1, 0), len(times) - 2)
    since, rows = moment - float(times[segment]), trajectory.coefficients[:, segment]
    degrees = range(len(rows) - 1, -1, -1)
    taken = (
        [since**power for power in degrees],
        [power * since ** (power - 1) if power > 0 else 0.0 for power in degrees],
        [power * (power - 1) * since ** (power - 2) if power > 1 else 0.0 for power in degrees],
    )
    return np.array(taken) @ rows
