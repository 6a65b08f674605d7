"""The judge's own model of what is carried: the torque that point masses need, by d'Alembert.

A point of mass m that must accelerate by a needs the force m (a - g), and joint k bears l_k . m (a - g),
where l_k is the velocity that the joint gives the point at unit speed. From joint to joint outwards, the
acceleration of the point as if fixed to the next link grows by 2 w x (l v) + v^2 z x l + a l for a turning
joint of axis z, speed v and acceleration a behind a link of angular velocity w; a sliding one has no
second term.
"""

import numpy as np

from trajopt.arrays import Floats
from trajopt.model.payload import Payload, payloads
from trajopt.verify.kernel.kinematics import Kinematics, Poses


def payload_torques(
    kinematics: Kinematics, positions: Floats, velocities: Floats, accelerations: Floats
) -> Floats:
    """Return the torques that the carried masses need.

    Args:
        kinematics: Of the arm; its model says what is carried.
        positions: Of the group's joints, shape (s, n) [rad | m].
        velocities: Of the model's joints, shape (s, joints) [rad/s | m/s].
        accelerations: Of the model's joints, shape (s, joints) [rad/s^2 | m/s^2].

    Returns:
        Of the model's joints, shape (s, joints) [Nm | N].
    """
    total = np.zeros(velocities.shape)
    carried = payloads(kinematics.reduced)
    if carried:
        poses = kinematics.poses(positions)
        for item in carried:
            total += _torques(kinematics, item, poses, velocities, accelerations)
    return total


def _torques(
    kinematics: Kinematics, item: Payload, poses: Poses, velocities: Floats, accelerations: Floats
) -> Floats:
    point = poses.rotation[:, item.joint] @ item.point + poses.translation[:, item.joint]
    spin: Floats = np.zeros(point.shape)
    acceleration: Floats = np.zeros(point.shape)
    levers: dict[int, Floats] = {}
    for joint in reversed(kinematics.chain(item.joint)):
        axis: Floats = poses.rotation[:, joint] @ kinematics.axes[joint]
        speed: Floats = velocities[:, joint - 1, None]
        increase: Floats = accelerations[:, joint - 1, None]
        if kinematics.revolute[joint]:
            lever = _cross(axis, point - poses.translation[:, joint])
            acceleration = acceleration + speed**2 * _cross(axis, lever)
        else:
            lever = axis
        acceleration = acceleration + 2.0 * _cross(spin, speed * lever) + increase * lever
        if kinematics.revolute[joint]:
            spin = spin + speed * axis
        levers[joint] = lever
    gravity = np.array(kinematics.reduced.model.gravity.linear)
    force = item.mass * (acceleration - gravity)
    torques = np.zeros(velocities.shape)
    for joint, lever in levers.items():
        torques[:, joint - 1] = np.einsum("si,si->s", lever, force)
    return torques


def _cross(first: Floats, second: Floats) -> Floats:
    return np.asarray(np.cross(first, second), dtype=np.float64)
