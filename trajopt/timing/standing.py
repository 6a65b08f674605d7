"""Standing between motions: a motion begun later, and motions in turn that each begin and end at rest."""

import numpy as np

from trajopt.values.trajectory import MEETING, Trajectory

JOLT = 1e-3
"""A motion may begin or end with an acceleration: it is reached from rest, or lost, in so long, while nothing
gets on [s]."""


def begun_later(trajectory: Trajectory, wait: float) -> Trajectory:
    """Return a motion that rests at its start for a time and then goes on as it was.

    If it begins with an acceleration, that is reached at the end of the wait: by a quintic from rest to
    rest with this acceleration at its end, inside which it is nowhere larger.

    Args:
        trajectory: With no velocity at its start.
        wait: How long [s].
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
    """Return a motion, a time of standing, and another that begins where the first ends.

    Args:
        first: With no velocity at its end.
        gap: How long the robot stands between them, more than `JOLT` [s].
        second: With no velocity at its start, of the same joints.
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
    """Return two motions from rest to rest as one, which stands between them only if accelerations jump.

    Where jerks have no limit, the first may end braking and the second begin speeding up: those are two
    instants, `2 * JOLT` apart.

    Args:
        first: With no velocity at its end.
        second: With no velocity at its start, of the same joints; begins where the first ends.
    """
    ends, begins = first.accelerations, second.accelerations
    if ends is None or begins is None or np.abs(begins[0] - ends[-1]).max() <= MEETING:
        return first.followed_by(second)
    return after_standing(first, 2.0 * JOLT, second)
