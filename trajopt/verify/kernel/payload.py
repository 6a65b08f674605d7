"""The judge's own model of what is carried: the torque that its mass needs, by d'Alembert.

A centre of mass m that must accelerate by a needs the force m (a - g), and joint k bears l_k . m (a - g),
where l_k is the velocity that the joint gives the point at unit speed. From joint to joint outwards, the
acceleration of the point as if fixed to the next link grows by 2 w x (l v) + v^2 z x l + a l for a turning
joint of axis z, speed v and acceleration a behind a link of angular velocity w; a sliding one has no
second term.

To turn with angular velocity w and acceleration u the load of moments I needs the moment I u + w x I w
(Euler), and a turning joint bears its part along z. From joint to joint u grows by w x (v z) + a z.
"""

import numpy as np

from trajopt.scene.payload import Payload, payloads
from trajopt.values.arrays import Floats
from trajopt.verify.kernel.kinematics import Kinematics, Poses


def payload_torques(
    kinematics: Kinematics, positions: Floats, velocities: Floats, accelerations: Floats
) -> Floats:
    """Return the torques that what is carried needs.

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
    turning: Floats = np.zeros(point.shape)
    levers: dict[int, Floats] = {}
    axes: dict[int, Floats] = {}
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
            turning = turning + _cross(spin, speed * axis) + increase * axis
            spin = spin + speed * axis
            axes[joint] = axis
        levers[joint] = lever
    gravity = np.array(kinematics.reduced.model.gravity.linear)
    force = item.mass * (acceleration - gravity)
    rotation = poses.rotation[:, item.joint]
    inertia = rotation @ item.inertia @ rotation.transpose(0, 2, 1)
    moment = np.einsum("sij,sj->si", inertia, turning)
    moment += _cross(spin, np.einsum("sij,sj->si", inertia, spin))
    torques = np.zeros(velocities.shape)
    for joint, lever in levers.items():
        torques[:, joint - 1] = np.einsum("si,si->s", lever, force)
    for joint, axis in axes.items():
        torques[:, joint - 1] += np.einsum("si,si->s", axis, moment)
    return torques


def _cross(first: Floats, second: Floats) -> Floats:
    return np.asarray(np.cross(first, second), dtype=np.float64)
