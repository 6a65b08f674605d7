"""What a joint carries: frames and collision bodies that never move against it."""

from dataclasses import dataclass

from trajopt.model.placement import IDENTITY, Placement
from trajopt.model.shapes import Shape


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
    """A collision body, by the joint that carries it.

    Attributes:
        name: The body's name.
        owner: The link or object it is part of.
        joint: Joint of the reduced model that carries it; 0 is the world.
        placement: Of the shape in that joint's frame.
        shape: The shape.
    """

    name: str
    owner: str
    joint: int
    placement: Placement
    shape: Shape
