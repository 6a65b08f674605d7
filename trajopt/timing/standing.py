"""Waits between motions: a delayed start, and consecutive motions from rest to rest."""

import numpy as np

from trajopt.values.trajectory import MEETING, Trajectory

JOLT = 1e-3
"""Time in which an acceleration at the start or end of a motion builds up or decays at rest [s]."""


def begun_later(trajectory: Trajectory, wait: float) -> Trajectory:
    """Return a motion that waits at its start.

    A start acceleration is reached at the end of the wait by a quintic from rest; it is the largest
    acceleration of the quintic.

    Args:
        trajectory: Motion with zero velocity at its start.
        wait: Duration of the wait [s].
    """
    positions, velocities, accelerations = (
        trajectory.positions, trajectory.velocities, trajectory.accelerations
    )  # fmt: skip
    before = [0.0]
    if accelerations is not None and accelerations[0].any():
        before.append(wait - min(JOLT, wait / 2.0))
    still = np.zeros((len(before), positions.shape[1]))
    return Trajectory(
        trajectory.joint_names,
        np.concatenate((before, trajectory.times + wait)),
        np.concatenate((still + positions[0], positions)),
        None if velocities is None else np.concatenate((still, velocities)),
        None if accelerations is None else np.concatenate((still, accelerations)),
    )


def after_standing(first: Trajectory, gap: float, second: Trajectory) -> Trajectory:
    """Concatenate two motions with a wait between them.

    Args:
        first: Motion with zero velocity at its end.
        gap: Duration of the wait, more than `JOLT` [s].
        second: Motion of the same joints with zero velocity at its start.
    """
    rest = np.zeros((1, first.positions.shape[1]))
    stood = Trajectory(
        first.joint_names,
        np.append(first.times, first.duration + JOLT),
        np.concatenate((first.positions, first.positions[-1:])),
        None if first.velocities is None else np.concatenate((first.velocities, rest)),
        None if first.accelerations is None else np.concatenate((first.accelerations, rest)),
    )
    return stood.followed_by(begun_later(second, gap - JOLT))


def in_turn(first: Trajectory, second: Trajectory) -> Trajectory:
    """Concatenate two motions from rest to rest; insert a wait only if the acceleration jumps.

    Without jerk limits the first motion may end braking and the second begin accelerating: these are two
    instants, `2 * JOLT` apart.

    Args:
        first: Motion with zero velocity at its end.
        second: Motion of the same joints with zero velocity at its start, which begins where the first ends.
    """
    ends, begins = first.accelerations, second.accelerations
    if ends is None or begins is None or np.abs(begins[0] - ends[-1]).max() <= MEETING:
        return first.followed_by(second)
    return after_standing(first, 2.0 * JOLT, second)
