"""The tree of a robot's links, with their joints and reach."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from trajopt.robot.robot import Robot


@dataclass(frozen=True)
class TreeLink:
    """A link and the joint above it.

    Attributes:
        name: The link.
        parent: The link above; empty for the root.
        joint: The joint between them; empty for the root.
        moving: Whether the joint moves.
        driven: Whether it moves and mimics no other.
        length: Distance between the origins of both links at zero [m].
    """

    name: str
    parent: str
    joint: str
    moving: bool
    driven: bool
    length: float


@dataclass(frozen=True, eq=False)
class LinkTree:
    """All links of a robot.

    Attributes:
        links: By name, each after its parent.
        below: Names of the links joined below each, in the file's order.
    """

    links: Mapping[str, TreeLink]
    below: Mapping[str, tuple[str, ...]]

    @staticmethod
    def of(robot: Robot) -> "LinkTree":
        """Read the tree of a robot."""
        model, data = robot.model, robot.model.createData()
        pin.framesForwardKinematics(model, data, robot.configuration(np.zeros(len(robot.joint_names))))
        links: dict[str, TreeLink] = {}
        below: dict[str, list[str]] = {}
        for place, frame in enumerate(model.frames):
            if frame.type != pin.FrameType.BODY:
                continue
            joint = model.frames[frame.parentFrame]
            above = model.frames[joint.parentFrame]
            below[frame.name] = []
            if above.name not in links:
                links[frame.name] = TreeLink(frame.name, "", "", False, False, 0.0)
                continue
            apart = data.oMf[place].translation - data.oMf[joint.parentFrame].translation
            moving = joint.name in robot.joint_names
            driven = moving and joint.name not in robot.mimics
            length = float(np.linalg.norm(apart))
            links[frame.name] = TreeLink(frame.name, above.name, joint.name, moving, driven, length)
            below[above.name].append(frame.name)
        return LinkTree(links, {name: tuple(children) for name, children in below.items()})

    def subtree(self, name: str) -> tuple[TreeLink, ...]:
        """Return a link and all below it."""
        found = [self.links[name]]
        for child in self.below[name]:
            found.extend(self.subtree(child))
        return tuple(found)

    def moving_below(self, name: str) -> tuple[str, ...]:
        """Return the links joined below that move, or have something below that does."""
        return tuple(child for child in self.below[name] if any(link.moving for link in self.subtree(child)))

    def extent(self, name: str) -> float:
        """Return the length of the longest path from the link above down to a leaf [m]."""
        return self.links[name].length + max((self.extent(child) for child in self.below[name]), default=0.0)

    def joined(self, one: str, other: str, solid: frozenset[str]) -> bool:
        """Return whether two links are joined by a joint, or by joints with only body-less links between.

        Args:
            one: A link.
            other: Another.
            solid: Links that have collision bodies.
        """
        return other in self._neighbours_above(one, solid) or one in self._neighbours_above(other, solid)

    def _neighbours_above(self, name: str, solid: frozenset[str]) -> tuple[str, ...]:
        """Return the links above up to the first that has bodies."""
        found: list[str] = []
        above = self.links[name].parent
        while above:
            found.append(above)
            if above in solid:
                break
            above = self.links[above].parent
        return tuple(found)
