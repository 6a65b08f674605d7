"""Grasp and place: how a gripper takes hold of an object, and where it puts it down."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

from trajopt.arrays import Floats, Value, floats, number, one_of
from trajopt.errors import ShapeError
from trajopt.model.placement import Placement
from trajopt.model.requirements import (
    POSITION_TOLERANCE,
    ROTATION_TOLERANCE,
    WORLD,
    FramePlacement,
    frame_placement,
)
from trajopt.model.requirements.requirement import direction_of, positive

FORCE = 30.0
"""Force that each finger presses with unless told otherwise [N]."""


@dataclass(frozen=True, eq=False)
class Straight(Value):
    """A straight motion of the gripper that does not turn it.

    Attributes:
        distance: Its length [m].
        direction: In which the gripper moves, in `frame`, shape (3,), a unit vector. None for the
            usual: an approach goes along the gripper's approach axis and a retreat against it, a lift
            goes against gravity and a lowering along it.
        frame: What `direction` is seen from: "world", a link, a tool frame or an object, where it is
            when the straight motion touches the object.
    """

    distance: float = 0.1
    direction: ArrayLike | None = None
    frame: str = WORLD

    def __post_init__(self) -> None:
        """Check the length and make the direction a unit vector."""
        positive("distance", self.distance)
        one_of("frame", self.frame, str)
        if self.direction is not None:
            object.__setattr__(self, "direction", direction_of("direction", self.direction))

    @property
    def unit(self) -> Floats | None:
        """The direction as an array, shape (3,); None for the usual one."""
        return None if self.direction is None else np.asarray(self.direction, dtype=np.float64)


@dataclass(frozen=True, eq=False, kw_only=True)
class Grasp:
    """A way to take hold of an object with a parallel gripper.

    Attributes:
        placement: Of the gripper's tool frame in the object's frame.
        width: Of the object between the pads: where the fingers stop [m].
        opening: Between the pads on the way there [m].
        force: That each finger presses with [N].
        approach: The way to the object with open fingers, ending in the grasp.
        lift: The way off what the object stands on.
        name: For reports.
    """

    placement: Placement
    width: float
    opening: float
    force: float = FORCE
    approach: Straight = field(default_factory=Straight)
    lift: Straight = field(default_factory=Straight)
    name: str = "grasp"

    def __post_init__(self) -> None:
        """Check the numbers."""
        one_of("placement", self.placement, Placement)
        for way in ("approach", "lift"):
            one_of(way, getattr(self, way), Straight)
        positive("force", self.force)
        if number("width", self.width) < 0.0:
            raise ShapeError("width", f"is negative: {self.width:g} m")
        if number("opening", self.opening) < self.width:
            raise ShapeError(
                "opening",
                f"of grasp {self.name!r} is {self.opening:g} m, less than the object is wide: "
                f"{self.width:g} m",
            )


@dataclass(frozen=True, eq=False, kw_only=True)
class Place(Value):
    """Where an object is put down.

    Attributes:
        placement: Of the object in `frame`.
        frame: "world", or an object that stands still.
        position_tolerance: Along the axes of `placement`, one or shape (3,) [m]; inf leaves an axis free.
        rotation_tolerance: About them, one or shape (3,) [rad]; inf leaves an axis free.
        lower: The way down to what it will stand on.
        retreat: The way of the opened gripper off the object.
        name: For reports.
    """

    placement: Placement
    frame: str = WORLD
    position_tolerance: ArrayLike = POSITION_TOLERANCE
    rotation_tolerance: ArrayLike = ROTATION_TOLERANCE
    lower: Straight = field(default_factory=Straight)
    retreat: Straight = field(default_factory=Straight)
    name: str = "place"

    def __post_init__(self) -> None:
        """Check the tolerances, and that everything is of its kind."""
        one_of("placement", self.placement, Placement)
        one_of("frame", self.frame, str)
        for way in ("lower", "retreat"):
            one_of(way, getattr(self, way), Straight)
        self.requirement(WORLD)

    def requirement(self, name: str) -> FramePlacement:
        """Return what must hold of the object of that name."""
        return frame_placement(
            name,
            self.placement,
            reference=self.frame,
            position_tolerance=self.position_tolerance,
            rotation_tolerance=self.rotation_tolerance,
        )

    def error(self, placed: Placement, frame: Placement) -> Floats:
        """Return how far a placed object is from here.

        Args:
            placed: Where the object is in the world.
            frame: Where `frame` is in the world.

        Returns:
            Position [m] and rotation vector [rad] in the axes of `placement`, shape (6,): zero along
            axes that are free.
        """
        asked = self.requirement(WORLD)
        between = (frame * self.placement).inverse() * placed
        off = np.concatenate((between.translation, Rotation.from_matrix(between.rotation).as_rotvec()))
        free = np.isinf(np.concatenate((asked.position_tolerance, asked.rotation_tolerance)))
        return floats("error", np.where(free, 0.0, off), (6,))
