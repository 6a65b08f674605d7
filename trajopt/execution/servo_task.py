"""Servo task: what a command asks of the joints' velocities, and how near to a singularity it may lead."""

from dataclasses import dataclass

import numpy as np

from trajopt.arrays import Floats, Value
from trajopt.errors import JointNotFound
from trajopt.execution.servo_command import Command, Pose, ServoOptions, Twist
from trajopt.execution.servo_program import Approach, Braking, Task
from trajopt.model.placement import Placement
from trajopt.model.reduced import ReducedModel
from trajopt.model.requirements.singularity_distance import LENGTH
from trajopt.model.rotations import as_rotation_vector
from trajopt.query import Query
from trajopt.terms.frame_jacobian import FrameJacobian, frame_jacobian
from trajopt.terms.motion import Motion
from trajopt.terms.singularity_distance import singular_values

SLOWEST = 1e-2
"""Commands slower than this count as much as if they were as fast, so that noise is not followed at all cost
[m/s]."""


@dataclass(frozen=True, eq=False)
class Tool(Value):
    """The tool of a group in a configuration.

    Attributes:
        motion: The configuration.
        jacobian: Of the tool, a radian counting as `LENGTH`, with its derivative.
        joints: How many joints the group has.
    """

    motion: Motion
    jacobian: FrameJacobian
    joints: int

    @staticmethod
    def at(query: Query, positions: Floats, frame: str, joints: int) -> "Tool":
        """Look at a tool frame for positions of the query's joints."""
        motion = Motion.single(positions, query)
        found = frame_jacobian(query.reduced, motion, frame, length=LENGTH, offset=np.zeros(3))
        return Tool(motion, found, joints)

    def placement(self, frame: str) -> Placement:
        """Return where a frame is in the world."""
        joint, held = self.motion.query.reduced.attachment(frame)
        placed = self.motion.kinematics
        return Placement(placed.rotation[0, joint], placed.translation[0, joint]) * held

    def task(self, twist: Floats) -> Task:
        """Return the task of a twist in the world, (velocity, rate of turning), shape (6,)."""
        asked = np.concatenate((twist[:3], LENGTH * twist[3:]))
        scale = max(float(np.linalg.norm(asked)), SLOWEST)
        return Task(self.jacobian.matrix[0, :, : self.joints] / scale, asked / scale)

    def approach(self, twist: Floats, braking: Braking, velocities: Floats) -> Approach:
        """Return how fast the tool may come nearer to a singularity on a twist.

        Where its smallest singular value is s, a twist of size c asks for joint velocities of c / s. So it is
        kept from getting smaller than c by the slowest joint's velocity limit, and never asked to grow.
        """
        values, slopes = singular_values(self.jacobian)
        size = float(np.linalg.norm(np.concatenate((twist[:3], LENGTH * twist[3:]))))
        smallest = size / float(braking.limits.velocity.min())
        room = max(float(values[0, -1]) - smallest, 0.0)
        lower = np.array((-room / braking.time(velocities),))
        return Approach(slopes[0, -1:, : self.joints], lower)


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


def joint_task(velocities: Floats, braking: Braking) -> Task:
    """Return the task of joint velocities, each counting by its limit."""
    most = braking.limits.velocity
    return Task(np.diag(1.0 / most), velocities / most)


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
