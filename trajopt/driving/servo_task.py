"""Servo task: what a command asks of the joints' velocities, and how near to a singularity it may lead."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from trajopt.driving.servo_command import Command, Pose, ServoOptions, Twist
from trajopt.driving.servo_program import ApproachLimits, Braking, VelocityTask
from trajopt.geometry import JointPlacements, Query
from trajopt.problem.requirements.joints import LENGTH
from trajopt.scene.reduced import ReducedModel
from trajopt.values.arrays import Floats, Ints, Value
from trajopt.values.errors import JointNotFound
from trajopt.values.placement import Placement, as_rotation_vector

SLOWEST = 1e-2
"""Commands slower than this count as much as if they were as fast, so that noise is not followed at all cost
[m/s]."""

ENDING = 0.5
"""A reach ends where more than this part of the slope of a singular value is along its own singular vector:
nearly all of it where an arm is stretched, nearly nothing where axes of a wrist line up."""
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

    Its Jacobian is that of `terms.frame_jacobian`, for one configuration and the group's own joints, and the
    slopes of its singular values follow without the derivative of the whole.

    Attributes:
        reduced: The robot and its surroundings.
        placed: Where its joints are.
        linear: Velocity of the tool by each joint that carries it, from the base on, shape (k, 3).
        angular: How it turns by each, shape (k, 3).
        mimic: How fast each is at unit speed of the group's n joints, shape (k, n).
    """

    reduced: ReducedModel
    placed: JointPlacements
    linear: Floats
    angular: Floats
    mimic: Floats

    @staticmethod
    def at(query: Query, positions: Floats, frame: str, joints: int) -> "Tool":
        """Look at a tool frame for positions of the query's joints, of which the first are the group's."""
        reduced, placed = query.reduced, query.kinematics(positions[None])
        joint, held = reduced.attachment(frame)
        chain = reduced.derived_of_robot(_chains)[joint]
        point = placed.rotation[0, joint] @ held.translation + placed.translation[0, joint]
        moved = placed.jacobian[0][:, chain].T
        angular = moved[:, 3:]
        linear = moved[:, :3] + angular @ _across(point)
        return Tool(reduced, placed, linear, angular, reduced.mimic_matrix[chain, :joints])

    def placement(self, frame: str) -> Placement:
        """Return where a frame is in the world."""
        joint, held = self.reduced.attachment(frame)
        return Placement(self.placed.rotation[0, joint], self.placed.translation[0, joint]) * held

    @cached_property
    def jacobian(self) -> Floats:
        """Velocity and turning by the group's joints, a radian counting as `LENGTH`, shape (6, n)."""
        return np.concatenate((self.linear, LENGTH * self.angular), axis=1).T @ self.mimic

    def task(self, twist: Floats) -> VelocityTask:
        """Return the task of a twist in the world, (velocity, rate of turning), shape (6,)."""
        asked = _as_lengths(twist)
        scale = max(float(np.linalg.norm(asked)), SLOWEST)
        return VelocityTask(self.jacobian / scale, asked / scale)

    def approach(self, twist: Floats, braking: Braking, velocities: Floats) -> ApproachLimits:
        """Return how fast the tool may come nearer to singularities on a twist.

        What the twist has along the k-th left singular vector, c, asks for joint velocities of c / s along
        the right one, where s is the singular value. So s is kept from getting smaller than what asks a joint
        for its velocity limit, and never asked to grow. Where the reach ends, that counts which the twist has
        along this vector now. Elsewhere, as where axes of a wrist line up, the vector turns with the joints,
        and the whole twist counts.
        """
        left, values, right, slopes = self.singular_values()
        asked = _as_lengths(twist)
        along = np.abs((slopes * right).sum(axis=1))
        ends = along > ENDING * np.sqrt((slopes**2).sum(axis=1))
        size = np.where(ends, np.abs(left.T @ asked), np.sqrt(asked @ asked))
        smallest = size * (np.abs(right) / braking.limits.velocity).max(axis=1)
        room = np.maximum(values - smallest, 0.0)
        return ApproachLimits(slopes, -room / braking.time(velocities))

    def singular_values(self) -> tuple[Floats, Floats, Floats, Floats]:
        """Return the singular values of the Jacobian, the largest first, and their slopes.

        With singular vectors u and v, the slope by joint i is u . dJ/dq_i v, and what joint a turns of what
        joint b does is w_a x l_b and w_a x w_b, where a is the nearer to the base.

        Returns:
            Left singular vectors as columns (6, m), values (m,), right singular vectors as rows (m, n), and
            slopes by the group's joints (m, n).
        """
        left, values, right = np.linalg.svd(self.jacobian, full_matrices=False)
        rates, farther = right @ self.mimic.T, np.tri(len(self.mimic)).T
        moving, turning = left[:3].T @ _ACROSS, left[3:].T @ _ACROSS
        moved = farther * (self.angular @ _turned(self.linear @ moving.reshape(-1, 3, 3)))
        spun = farther * (self.angular @ _turned(LENGTH * self.angular @ turning.reshape(-1, 3, 3)))
        by_nearer = ((moved + spun) @ rates[:, :, None])[:, :, 0]
        by_farther = (rates[:, None] @ moved)[:, 0]
        slopes = by_nearer + by_farther - np.diagonal(moved, axis1=1, axis2=2) * rates
        return left, values, right, slopes @ self.mimic


def _as_lengths(twist: Floats) -> Floats:
    """Return a twist, shape (6,), with a radian counting as `LENGTH`."""
    return np.concatenate((twist[:3], LENGTH * twist[3:]))


def _across(vector: Floats) -> Floats:
    """Return the matrix X with a @ X = a x vector."""
    return (vector @ _ACROSS).reshape(3, 3)


def _turned(matrices: Floats) -> Floats:
    return matrices.transpose(0, 2, 1)


def _chains(reduced: ReducedModel) -> tuple[Ints, ...]:
    """Return the places of the joints that carry each joint, and of itself, from the base on."""
    model = reduced.model
    return tuple(
        np.array([int(model.joints[number].idx_v) for number in list(each)[1:]], dtype=np.int64)
        for each in model.supports
    )


def values_of(command: Command, reduced: ReducedModel, options: ServoOptions) -> Floats:
    """Return what counts of a command's numbers: (6,) of a twist, (n,) of joints, none of a pose.

    Raises:
        JointNotFound: If a joint is not the group's.
    """
    if isinstance(command, Twist):
        shaped = _shaped(np.concatenate((command.linear, command.angular)), options)
        shaped[3:] *= options.turning
        return _unlocked(shaped, options)
    if isinstance(command, Pose):
        return np.zeros(0)
    for name in command.velocities:
        if name not in reduced.joint_names:
            raise JointNotFound("joint of the group", name, reduced.joint_names)
    asked = [command.velocities.get(name, 0.0) for name in reduced.joint_names]
    return _shaped(np.array(asked, dtype=np.float64), options)


def joint_task(velocities: Floats, braking: Braking) -> VelocityTask:
    """Return the task of joint velocities, each counting by its limit."""
    most = braking.limits.velocity
    return VelocityTask(np.diag(1.0 / most), velocities / most)


def twist_to(target: Placement, here: Placement, options: ServoOptions, delay: float) -> Floats:
    """Return the twist that draws a tool to a placement.

    It goes down with the distance, at a quarter of the rate at which the joints follow: two lags one after
    the other do not overshoot then.

    Args:
        target: Where the tool is to be.
        here: Where it is.
        options: Its largest speeds, and axes that are locked.
        delay: How long joints take to follow [s].
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
    """Return a twist, shape (6,), that is given in the axes of a frame in those of the world."""
    return np.concatenate((frame.rotation @ twist[:3], frame.rotation @ twist[3:]))


def _shaped(values: Floats, options: ServoOptions) -> Floats:
    """Return what counts of the numbers of a command: beyond the dead zone, scaled."""
    beyond = np.maximum(np.abs(values) - options.dead_zone, 0.0)
    return options.scaling * np.sign(values) * beyond


def _unlocked(twist: Floats, options: ServoOptions) -> Floats:
    """Return a twist, shape (6,), without what is along and about locked axes."""
    twist = twist.copy()
    twist[[axis.value for axis in options.locked]] = 0.0
    return twist
