"""Bodies placed in the world at many configurations, and how far they reach there."""

from dataclasses import dataclass

import numpy as np

from trajopt.arrays import Floats, Ints
from trajopt.model.placement import Placement
from trajopt.model.shapes import Shape
from trajopt.verify.kernel.kinematics import Poses
from trajopt.verify.kernel.support import support


@dataclass(frozen=True, eq=False)
class Solid:
    """A shape fixed to a joint.

    Attributes:
        owner: The link or object that it is part of.
        joint: The joint.
        placement: Of the shape in the joint's frame.
        shape: The shape.
    """

    owner: str
    joint: int
    placement: Placement
    shape: Shape

    def in_world(self, poses: Poses, cell: Ints) -> tuple[Floats, Floats]:
        """Return rotation (i, 3, 3) and origin (i, 3) [m] at configurations `cell`, shape (i,)."""
        rotation = poses.rotation[cell, self.joint]
        origin = rotation @ self.placement.translation + poses.translation[cell, self.joint]
        return rotation @ self.placement.rotation, origin

    def at(self, poses: Poses, cell: int) -> Placement:
        """Return the placement in the world at one configuration."""
        joint = Placement(poses.rotation[cell, self.joint], poses.translation[cell, self.joint])
        return joint * self.placement

    def reach(self, poses: Poses, cell: Ints, directions: Floats) -> Floats:
        """Return the largest `direction @ point` over the solid's points.

        Args:
            poses: Of the robot.
            cell: Configurations, shape (i,).
            directions: Unit vectors in the world, shape (i, 3).

        Returns:
            Shape (i,) [m].
        """
        rotation, origin = self.in_world(poses, cell)
        local = np.einsum("iab,ia->ib", rotation, directions)
        return np.einsum("ij,ij->i", origin, directions) + support(self.shape, local)


def gaps(
    solids: tuple[Solid, ...], poses: Poses, cell: Ints, *, first: Ints, second: Ints, directions: Floats
) -> Floats:
    """Return gaps between solids along directions from the first to the second.

    Args:
        solids: The solids.
        poses: Of the robot.
        cell: Configurations, shape (i,).
        first: Index of the first solid, shape (i,).
        second: Index of the second solid, shape (i,).
        directions: Unit vectors in the world, shape (i, 3).

    Returns:
        Shape (i,) [m].
    """
    result = np.zeros(len(cell))
    for chosen, along in ((first, directions), (second, -directions)):
        order = np.argsort(chosen, kind="stable")
        for some in np.split(order, np.flatnonzero(np.diff(chosen[order])) + 1):
            if len(some):
                result[some] -= solids[int(chosen[some[0]])].reach(poses, cell[some], along[some])
    return result
