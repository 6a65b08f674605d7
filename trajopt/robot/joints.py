"""The joints of a Pinocchio model: configurations, units, and the frames and bodies that they carry."""

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from trajopt.values.arrays import Floats
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
    """Return the unit of a joint's position or its derivative.

    Args:
        model: The robot's model.
        joint: Name of one of its movable joints.
        order: 0 position, 1 velocity, 2 acceleration, 3 jerk.
    """
    kind = str(model.joints[model.getJointId(joint)].shortname())
    return ("m" if kind.startswith("JointModelP") else "rad") + _PER_SECOND[order]


def joint_units(model: pin.Model) -> dict[str, str]:
    """Return the unit of each movable joint's position, "rad" or "m", by its name."""
    return {name: joint_unit(model, name) for name in list(model.names)[1:]}


def effort_unit(model: pin.Model, joint: str) -> str:
    """Return the unit of a movable joint's effort: Nm, or N for a prismatic joint."""
    return "Nm" if joint_unit(model, joint) == "rad" else "N"


@dataclass(frozen=True, eq=False)
class Anchor:
    """A frame that moves with a joint.

    Attributes:
        joint: Joint of the reduced model that carries it; 0 is the world.
        placement: Of the frame in that joint's frame.
    """

    joint: int
    placement: Placement


WORLD_ANCHOR = Anchor(0, IDENTITY)
"""The world itself."""


@dataclass(frozen=True, eq=False)
class FixedBody:
    """A collision body and the joint that carries it.

    Attributes:
        name: The body's name.
        owner: The link or object that it is part of.
        joint: Joint of the reduced model that carries it; 0 is the world.
        placement: Of the shape in that joint's frame.
        shape: The shape.
    """

    name: str
    owner: str
    joint: int
    placement: Placement
    shape: Shape
