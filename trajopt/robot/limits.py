"""Limits of joints."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from enum import Enum

import numpy as np

from trajopt.values.arrays import Floats, Ints, Value, readonly


class LimitKind(Enum):
    """The limited quantity of a joint."""

    LOWER = "lower"
    UPPER = "upper"
    VELOCITY = "velocity"
    ACCELERATION = "acceleration"
    JERK = "jerk"


PER_SECOND = {LimitKind.VELOCITY: "/s", LimitKind.ACCELERATION: "/s^2", LimitKind.JERK: "/s^3"}
"""Suffix of a unit for a rate."""


@dataclass(frozen=True, eq=False)
class JointLimits(Value):
    """Limits of some joints, one entry per joint, in the order of `joint_names`.

    Attributes:
        joint_names: Names of the joints.
        lower: Lower position limits, shape (n,) [rad | m]; -inf for continuous joints.
        upper: Upper position limits, shape (n,) [rad | m].
        velocity: Largest speeds, shape (n,) [rad/s | m/s].
        acceleration: Largest accelerations, shape (n,) [rad/s^2 | m/s^2].
        jerk: Largest jerks, shape (n,) [rad/s^3 | m/s^3]; inf if unknown.
        effort: Largest torques or forces, shape (n,) [Nm | N]; inf if unknown.
        defaulted: Sentences that name every limit chosen by trajopt, because no file states it.
        binding: The mimic joint that a limit comes from, by joint and kind, if it is tighter.
    """

    joint_names: tuple[str, ...]
    lower: Floats
    upper: Floats
    velocity: Floats
    acceleration: Floats
    jerk: Floats
    effort: Floats
    defaulted: tuple[str, ...] = ()
    binding: Mapping[tuple[str, LimitKind], str] = field(default_factory=dict[tuple[str, LimitKind], str])

    def because(self, joint: str, *kinds: LimitKind) -> str:
        """Return, in brackets, the mimic joint that a limit comes from; empty if it is the joint's own."""
        found = dict.fromkeys(self.binding[joint, kind] for kind in kinds if (joint, kind) in self.binding)
        return "".join(f" (the limit of {mimic}, which follows {joint})" for mimic in found)

    def take(self, index: Ints) -> "JointLimits":
        """Return the limits of the joints with these indices, in this order."""
        names = tuple(self.joint_names[int(i)] for i in index)
        kept = tuple(note for note in self.defaulted if note.split(" ", 1)[0] in names)
        return JointLimits(
            names,
            *(
                readonly(array[index])
                for array in (
                    self.lower,
                    self.upper,
                    self.velocity,
                    self.acceleration,
                    self.jerk,
                    self.effort,
                )
            ),
            defaulted=kept,
        )

    def scaled(self, *, velocity: float, acceleration: float) -> "JointLimits":
        """Return the limits with velocity and acceleration multiplied by factors in (0, 1]."""
        return replace(
            self,
            velocity=readonly(self.velocity * velocity),
            acceleration=readonly(self.acceleration * acceleration),
        )


def draw_positions(limits: JointLimits, count: int, *, rng: np.random.Generator) -> Floats:
    """Draw positions uniformly within limits; joints without limits within half a turn of zero.

    Args:
        limits: Of n joints.
        count: Number of configurations.
        rng: Random generator.

    Returns:
        Shape (count, n) [rad | m].
    """
    lower = np.where(np.isfinite(limits.lower), limits.lower, -np.pi)
    upper = np.where(np.isfinite(limits.upper), limits.upper, np.pi)
    return rng.uniform(lower, upper, (count, len(lower)))


EXCESS = 1e-6
"""Accepted numerical excess over a limit or tolerance: relative for velocity and acceleration, absolute for
positions and requirements [rad | m].
"""
