"""Torques of joints by inverse dynamics, judged at samples."""

import numpy as np

from trajopt.arrays import Floats
from trajopt.model.description.pinocchio_model import effort_unit
from trajopt.model.limits import JointLimits
from trajopt.verify.certificate import Check, CheckKind, Evidence
from trajopt.verify.kernel.intervals import counting, steps_in_pieces
from trajopt.verify.kernel.motion import Motion
from trajopt.verify.kernel.payload import payload_torques

SAMPLES_PER_SEGMENT = 4
"""Fewest samples of a segment, both its ends included: accelerations may jump in between."""


def torque_checks(motion: Motion, limits: JointLimits) -> tuple[Check, ...]:
    """Judge the torques of joints that have an effort limit, where the trajectory implies any.

    Args:
        motion: The motion.
        limits: Limits of the group's joints.
    """
    limited = np.isfinite(limits.effort)
    if not limited.any() or not motion.differentiable:
        return ()
    times, torques = inverse_dynamics(motion)
    share = np.where(limited, np.abs(torques) / limits.effort, -np.inf)
    worst = share.max(axis=0)
    checks: list[Check] = []
    for joint in (int(place) for place in np.argsort(-worst)):
        holds = bool(worst[joint] <= 1.0 + motion.options.excess)
        if checks and holds:
            break
        name = motion.reduced.joint_names[joint]
        row = int(share[:, joint].argmax())
        value, bound = float(torques[row, joint]), float(limits.effort[joint])
        unit = effort_unit(motion.reduced.scene.robot.model, name)
        checks.append(
            Check(
                kind=CheckKind.TORQUE,
                name="torque",
                subject=name,
                value=value,
                bound=bound,
                unit=unit,
                time=float(times[row]),
                slack=bound - abs(value),
                evidence=Evidence.SAMPLED,
                holds=holds,
                detail=f"{name} needs {abs(value):.4g} {unit}, its limit is {bound:.4g} {unit}",
            )
        )
    return tuple(checks)


def inverse_dynamics(motion: Motion) -> tuple[Floats, Floats]:
    """Sample the torques that the motion needs.

    Returns:
        Times, shape (s,) [s], and torques of the group's joints, shape (s, n) [Nm | N]; those of
        mimicking joints are borne by the joint they follow.
    """
    reduced = motion.reduced
    times, states = _samples(motion)
    configurations = motion.kinematics.configurations(states[0])
    velocities, accelerations = (
        states[1] @ reduced.mimic_matrix.T,
        states[2] @ reduced.mimic_matrix.T,
    )
    torques = motion.kinematics.torques(configurations, velocities, accelerations)
    torques = torques + payload_torques(motion, states[0], velocities, accelerations)
    return times, torques @ reduced.mimic_matrix


def _samples(motion: Motion) -> tuple[Floats, list[Floats]]:
    """Sample each segment from its own polynomial: times (s,), and orders 0 to 2, each (s, n)."""
    knots = motion.trajectory.times
    lengths = np.diff(knots)
    counts = np.maximum(steps_in_pieces(motion) + 1, SAMPLES_PER_SEGMENT)
    segment = np.repeat(np.arange(len(lengths)), counts)
    local = lengths[segment] * counting(counts) / (counts[segment] - 1)
    states: list[Floats] = []
    for order in (0, 1, 2):
        value = np.zeros((len(segment), len(motion.reduced.joint_names)))
        for coefficient in motion.group[order].coefficients:
            value = value * local[:, None] + coefficient[segment]
        states.append(value)
    return knots[segment] + local, states
