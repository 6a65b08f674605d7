"""Joints of a Pinocchio model: configurations, units, limits, and attached frames and bodies."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from enum import Enum

import numpy as np
import pinocchio as pin

from trajopt.values.arrays import Floats, Ints, Value, readonly
from trajopt.values.placement import IDENTITY, Placement
from trajopt.values.shapes.shapes import Shape


def configuration(model: pin.Model, positions: Floats) -> Floats:
    """Return pinocchio's configuration for positions of joints with one degree of freedom, (nv,) -> (nq,)."""
    if model.nq == model.nv:
        return positions
    q = np.empty(model.nq)
    for joint, position in zip(list(model.joints)[1:], positions, strict=True):
        if joint.nq == 1:
            q[joint.idx_q] = position
        else:
            q[joint.idx_q : joint.idx_q + 2] = np.cos(position), np.sin(position)
    return q


_PER_SECOND = ("", "/s", "/s^2", "/s^3")


def joint_unit(model: pin.Model, joint: str, *, order: int = 0) -> str:
    """Return the unit of a joint's position (order 0), velocity, acceleration or jerk."""
    kind = str(model.joints[model.getJointId(joint)].shortname())
    return ("m" if kind.startswith("JointModelP") else "rad") + _PER_SECOND[order]


def joint_units(model: pin.Model) -> dict[str, str]:
    return {name: joint_unit(model, name) for name in list(model.names)[1:]}


def effort_unit(model: pin.Model, joint: str) -> str:
    """Return the unit of a movable joint's effort: Nm, or N for a prismatic joint."""
    return "Nm" if joint_unit(model, joint) == "rad" else "N"


@dataclass(frozen=True, eq=False)
class Anchor:
    """A frame that moves with a joint.

    Attributes:
        placement: Of the frame in that joint's frame.
    """

    joint: int
    placement: Placement


WORLD_ANCHOR = Anchor(0, IDENTITY)


@dataclass(frozen=True, eq=False)
class FixedBody:
    """A collision body and the joint that carries it.

    Attributes:
        owner: The link or object that it is part of.
        placement: Of the shape in that joint's frame.
    """

    name: str
    owner: str
    joint: int
    placement: Placement
    shape: Shape


class LimitKind(Enum):
    """The limited quantity of a joint."""

    LOWER = "lower"
    UPPER = "upper"
    VELOCITY = "velocity"
    ACCELERATION = "acceleration"
    JERK = "jerk"


PER_SECOND = {LimitKind.VELOCITY: "/s", LimitKind.ACCELERATION: "/s^2", LimitKind.JERK: "/s^3"}


@dataclass(frozen=True, eq=False)
class JointLimits(Value):
    """Limits of some joints, one entry per joint, in the order of `joint_names`.

    Attributes:
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
    """Draw positions within limits, shape (count, n) [rad | m]; unlimited joints within half a turn."""
    lower, upper = drawing_range(limits)
    return rng.uniform(lower, upper, (count, len(lower)))


def drawing_range(limits: JointLimits) -> tuple[Floats, Floats]:
    """Return finite limits, shape (n,) [rad | m]: [-pi, pi] without limits, a turn from one limit."""
    low = np.where(np.isfinite(limits.upper), limits.upper - 2.0 * np.pi, -np.pi)
    lower = np.where(np.isfinite(limits.lower), limits.lower, low)
    return lower, np.where(np.isfinite(limits.upper), limits.upper, lower + 2.0 * np.pi)


EXCESS = 1e-6
"""Accepted numerical excess over a limit or tolerance: relative for velocity and acceleration, absolute for
positions and requirements [rad | m].
"""
