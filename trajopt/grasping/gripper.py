"""Gripper: two fingers that close on an object, and where its joints are at each opening."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from trajopt.arrays import Floats, Value, floats
from trajopt.errors import ShapeError
from trajopt.model.placement import Placement
from trajopt.model.requirements.requirement import direction_of, positive
from trajopt.model.robot import Robot


@dataclass(frozen=True, eq=False, kw_only=True)
class Gripper(Value):
    """A gripper with two fingers whose pads stay parallel.

    Attributes:
        group: Planning group of the fingers' joints.
        tool: Link or tool frame between the pads, fixed to the hand.
        links: Links of hand and fingers: they may touch what is held.
        fingers: Those of them that press.
        joint_names: The joints that drive the fingers.
        openings: Distances between the pads, increasing, shape (k,) [m].
        positions: Of those joints at each opening, shape (k, m) [rad | m].
        force: Largest force that each finger presses with [N].
        approach: Direction from the hand to the pads in the tool frame, shape (3,), a unit vector.
        closing: Direction from one pad to the other in the tool frame, shape (3,), a unit vector.
    """

    group: str
    tool: str
    links: tuple[str, ...]
    fingers: tuple[str, str]
    joint_names: tuple[str, ...]
    openings: Floats
    positions: Floats
    force: float
    approach: Floats
    closing: Floats

    def __post_init__(self) -> None:
        """Check shapes, that openings increase, and that the directions are at right angles."""
        openings = floats("openings", self.openings, (None,))
        if len(openings) < 2 or (np.diff(openings) <= 0.0).any() or openings[0] < 0.0:
            raise ShapeError("openings", "need two or more, not negative and increasing")
        positions = floats("positions", self.positions, (len(openings), len(self.joint_names)))
        approach, closing = (direction_of(name, getattr(self, name)) for name in ("approach", "closing"))
        if abs(float(approach @ closing)) > 1e-3:
            raise ShapeError("closing", "is not at a right angle to the approach direction")
        positive("force", self.force)
        for name, value in (
            ("openings", openings),
            ("positions", positions),
            ("approach", approach),
            ("closing", closing),
        ):
            object.__setattr__(self, name, value)

    @property
    def narrowest(self) -> float:
        """Smallest distance between the pads [m]."""
        return float(self.openings[0])

    @property
    def widest(self) -> float:
        """Largest distance between the pads [m]."""
        return float(self.openings[-1])

    @property
    def axes(self) -> Placement:
        """Placement in the tool frame of a frame whose z axis is the approach and whose y the closing."""
        x = np.cross(self.closing, self.approach)
        return Placement(floats("axes", np.stack((x, self.closing, self.approach), axis=1), (3, 3)))

    def joints_at(self, opening: float) -> Mapping[str, float]:
        """Return where the driven joints are at an opening, joint -> position [rad | m].

        Args:
            opening: Distance between the pads [m].

        Raises:
            ShapeError: If the gripper cannot open or close so far.
        """
        if not self.narrowest <= opening <= self.widest:
            raise ShapeError(
                "opening",
                f"{opening:g} m is not between {self.narrowest:g} and {self.widest:g} m, "
                "which is how far the fingers open",
            )
        columns = zip(self.joint_names, self.positions.T, strict=True)
        return {
            name: float(np.interp(opening, self.openings, np.asarray(column))) for name, column in columns
        }

    def opening_at(self, robot: Robot, positions: Floats) -> float:
        """Return how far the fingers are open at positions of all joints, by the first driven joint [m]."""
        joint = float(positions[robot.index(self.joint_names[:1])][0])
        column = self.positions[:, 0]
        order = np.argsort(column)
        return float(np.interp(joint, column[order], self.openings[order]))

    def pressing(self, width: float, force: float) -> Mapping[str, float]:
        """Return what the driven joints give so that each finger presses, joint -> force or torque [N | Nm].

        By virtual work: the pads come nearer by the sum of what each of the m joints contributes, which is
        as much for each: tau_i = -F d(opening)/dq_i, with d(opening)/dq_i = 1 / (m dq_i/d(opening)).

        Args:
            width: Between the pads [m].
            force: That each finger presses with [N].
        """
        return dict(zip(self.joint_names, (-force / self._yield(width)).tolist(), strict=True))

    def _yield(self, width: float) -> Floats:
        """Return m dq_i/d(opening) at an opening, shape (m,)."""
        place = int(np.clip(np.searchsorted(self.openings, width), 1, len(self.openings) - 1))
        rise = self.positions[place] - self.positions[place - 1]
        return len(self.joint_names) * rise / (self.openings[place] - self.openings[place - 1])

    def opened(self, robot: Robot, positions: Floats, opening: float) -> Floats:
        """Return positions of all joints with the fingers at an opening [rad | m].

        Args:
            robot: The robot.
            positions: Of all joints, shape (number of joints,) [rad | m].
            opening: Distance between the pads [m].
        """
        moved = np.array(positions)
        for joint, value in self.joints_at(opening).items():
            moved[robot.index([joint])] = value
        return robot.followed(moved)
