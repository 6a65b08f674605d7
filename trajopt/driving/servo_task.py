"""The joint velocities of a command, and the approach of a tool to singularities."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from trajopt.driving.servo_command import Command, Pose, ServoOptions, Twist
from trajopt.driving.servo_program import ApproachLimits, Braking, VelocityTask
from trajopt.geometry import Evaluator, JointPlacements
from trajopt.native import servo
from trajopt.problem.requirements.joints import LENGTH
from trajopt.scene.reduced import ReducedModel
from trajopt.values.arrays import Floats, Ints, Value
from trajopt.values.errors import JointNotFound
from trajopt.values.placement import Placement, as_rotation_vector

SLOWEST = 1e-2
"""Slower commands have the weight of this speed, so that noise is not followed at any cost [m/s]."""

ENDING = 0.5
"""A singularity is at the end of the reach if more than this share of the slope of the singular value is
along its singular vector: nearly all of it for a stretched arm, nearly none for aligned axes of a wrist.
"""
_ACROSS: Floats = np.array(
    (
        (0.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0, 1.0, 0.0),
        (0.0, 0.0, 1.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0),
        (0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0),
    )
)
"""The matrix X of a vector x with a @ X = a x x, row by row, is x @ this."""


@dataclass(frozen=True, eq=False)
class Tool(Value):
    """The tool of a group in a configuration.

    Its Jacobian equals `terms.frame_jacobian`.

    Attributes:
        linear: Linear velocity of the tool by each joint that carries it, from the base on, shape (k, 3).
        angular: Angular velocity by each, shape (k, 3).
        mimic: Speed of each at unit speed of the group's n joints, shape (k, n).
    """

    reduced: ReducedModel
    placed: JointPlacements
    linear: Floats
    angular: Floats
    mimic: Floats

    @staticmethod
    def at(query: Evaluator, positions: Floats, frame: str, joints: int) -> "Tool":
        reduced, placed = query.reduced, query.kinematics(positions[None])
        joint, held = reduced.attachment(frame)
        chain = reduced.derived_of_robot(_chains)[joint]
        point = placed.rotation[0, joint] @ held.translation + placed.translation[0, joint]
        moved = placed.jacobian[0][:, chain].T
        angular = np.ascontiguousarray(moved[:, 3:])
        linear = moved[:, :3] + angular @ (point @ _ACROSS).reshape(3, 3)
        mimic = np.ascontiguousarray(reduced.mimic_matrix[chain, :joints])
        return Tool(reduced, placed, linear, angular, mimic)

    def placement(self, frame: str) -> Placement:
        joint, held = self.reduced.attachment(frame)
        return Placement(self.placed.rotation[0, joint], self.placed.translation[0, joint]) * held

    @cached_property
    def jacobian(self) -> Floats:
        return np.concatenate((self.linear, LENGTH * self.angular), axis=1).T @ self.mimic

    def task(self, twist: Floats) -> VelocityTask:
        lengths = _as_lengths(twist)
        scale = max(float(np.linalg.norm(lengths)), SLOWEST)
        return VelocityTask(self.jacobian / scale, lengths / scale)

    def approach(self, twist: Floats, braking: Braking, velocities: Floats) -> ApproachLimits:
        """Return how fast the tool may approach singularities on a twist.

        The component c of the twist along the k-th left singular vector requires joint velocities c / s along
        the right one, with the singular value s (Nakamura and Hanafusa, "Inverse kinematic solutions with
        singularity robustness for robot manipulator control", 1986). So s may not fall below the value at
        which a joint reaches its velocity limit. At the end of the reach c is the present component. At other
        singularities, such as aligned axes of a wrist, the vector turns with the joints, and c is the size of
        the whole twist.
        """
        slopes, room = servo.approach(*self._chain, _as_lengths(twist), braking.limits.velocity, ENDING)
        return ApproachLimits(slopes, -room / braking.time(velocities))

    def singular_values(self) -> tuple[Floats, Floats, Floats, Floats]:
        """Return the singular values of the Jacobian, the largest first, and their slopes.

        With singular vectors u and v, the slope by joint i is u . dJ/dq_i v (Stewart, "Perturbation theory
        for the singular value decomposition", 1990). Joint a turns the columns of joint b, which is farther
        from the base, by w_a x l_b and w_a x w_b.

        Returns:
            Left singular vectors as columns (6, m), values (m,), right ones as rows (m, n), and slopes (m,
            n).
        """
        return servo.singular_values(*self._chain)

    @property
    def _chain(self) -> tuple[Floats, Floats, Floats, float]:
        return self.linear, self.angular, self.mimic, LENGTH


def _as_lengths(twist: Floats) -> Floats:
    return np.concatenate((twist[:3], LENGTH * twist[3:]))


def _chains(reduced: ReducedModel) -> tuple[Ints, ...]:
    model = reduced.model
    return tuple(
        np.array([int(model.joints[number].idx_v) for number in list(each)[1:]], dtype=np.int64)
        for each in model.supports
    )


def values_of(command: Command, reduced: ReducedModel, options: ServoOptions) -> Floats:
    """Return the shaped numbers of a command: (6,) of a twist, (n,) of joints, (0,) of a pose."""
    if isinstance(command, Twist):
        shaped = _shaped(np.concatenate((command.linear, command.angular)), options)
        shaped[3:] *= options.turning
        return _unlocked(shaped, options)
    if isinstance(command, Pose):
        return np.zeros(0)
    for name in command.velocities:
        if name not in reduced.joint_names:
            raise JointNotFound("joint of the group", name, reduced.joint_names)
    velocities = [command.velocities.get(name, 0.0) for name in reduced.joint_names]
    return _shaped(np.array(velocities, dtype=np.float64), options)


def joint_task(velocities: Floats, braking: Braking) -> VelocityTask:
    most = braking.limits.velocity
    return VelocityTask(np.diag(1.0 / most), velocities / most)


def twist_to(target: Placement, here: Placement, options: ServoOptions, delay: float) -> Floats:
    """Return the twist that moves a tool to a placement; joints follow after a delay [s].

    It is proportional to the distance, with the rate k = 1 / (4 T), where T is the delay: the characteristic
    polynomial T s^2 + s + k of the loop then has a double real root, so the tool does not overshoot.
    """
    away = target.translation - here.translation
    turn = here.rotation @ as_rotation_vector(here.rotation.T @ target.rotation)
    rate = 1.0 / (4.0 * delay)
    parts = ((away, options.linear), (turn, options.angular))
    scaled = [
        rate * each * min(1.0, most / max(rate * float(np.linalg.norm(each)), 1e-12)) for each, most in parts
    ]
    return _unlocked(np.concatenate(scaled), options)


def in_world(twist: Floats, frame: Placement) -> Floats:
    return np.concatenate((frame.rotation @ twist[:3], frame.rotation @ twist[3:]))


def _shaped(values: Floats, options: ServoOptions) -> Floats:
    beyond = np.maximum(np.abs(values) - options.dead_zone, 0.0)
    return options.scaling * np.sign(values) * beyond


def _unlocked(twist: Floats, options: ServoOptions) -> Floats:
    twist = twist.copy()
    twist[[axis.value for axis in options.locked]] = 0.0
    return twist
