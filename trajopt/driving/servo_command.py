"""Servo commands: what a robot is to do this very moment, and how what a hand gives is shaped."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum
from math import exp

import numpy as np

from trajopt.driving.options import CLOCK_TOLERANCE
from trajopt.problem.requirements.joints import LENGTH
from trajopt.values.arrays import (
    Floats,
    Value,
    above_zero,
    at_least,
    floats,
    mapping,
    number,
    one_of,
    several,
)
from trajopt.values.errors import ProblemError
from trajopt.values.errors.arguments import checked
from trajopt.values.placement import WORLD, Placement, PlacementLike, as_placement

REDUCED_SPEED = 0.25
"""Largest speed of a tool while a person guides it by hand, by ISO 10218-1 [m/s]."""
FASTEST, SLOWEST = 0.002, 0.01
"""Time from one tick to the next, at most 500 and at least 100 a second [s]."""


class Axis(Enum):
    """Axes along which, and about which, a tool moves."""

    X = 0
    Y = 1
    Z = 2
    ABOUT_X = 3
    ABOUT_Y = 4
    ABOUT_Z = 5


@checked
@dataclass(frozen=True, eq=False)
class Twist(Value):
    """Velocity of the tool.

    Attributes:
        linear: Of the tool's origin, shape (3,) [m/s].
        angular: Shape (3,) [rad/s].
        frame: Frame whose axes both are given in.
    """

    linear: Floats = field(default_factory=lambda: np.zeros(3))
    angular: Floats = field(default_factory=lambda: np.zeros(3))
    frame: str = WORLD

    def __post_init__(self) -> None:
        """Check the shapes."""
        for name in ("linear", "angular"):
            object.__setattr__(self, name, floats(name, getattr(self, name), (3,)))
        one_of("frame", self.frame, str)


@checked
@dataclass(frozen=True, eq=False)
class Pose(Value):
    """A placement in the world that the tool is drawn to.

    Attributes:
        placement: Of the tool.
    """

    placement: PlacementLike
    target: Placement = field(init=False, repr=False)

    def __post_init__(self) -> None:
        """Check the placement."""
        object.__setattr__(self, "target", as_placement("placement", self.placement))


@checked
@dataclass(frozen=True, eq=False)
class JointVelocities(Value):
    """Velocities of joints.

    Attributes:
        velocities: Joint of the group -> its velocity [rad/s | m/s]; those not named stand still.
    """

    velocities: Mapping[str, float]

    def __post_init__(self) -> None:
        """Check the numbers."""
        for name, value in mapping("velocities", self.velocities).items():
            number(f"velocity of {name}", value)


Command = Twist | Pose | JointVelocities
"""What the robot is to do."""


@checked
@dataclass(frozen=True, kw_only=True)
class ServoOptions:
    """Numbers of a servo.

    Attributes:
        period: Time from one tick to the next, 2 to 10 ms [s].
        timeout: A command older than this counts no more, and the robot stops [s].
        clearance: It keeps so much farther from everything than is required: room for the stop, which is
            not straight, and for its proof [m].
        linear: Largest speed at which the tool is drawn to a pose [m/s].
        angular: Largest rate at which it turns towards one [rad/s].
        dead_zone: What a command has beyond this counts, in each of its numbers: a stick is never quite in
            the middle. In the command's units.
        scaling: Factor on commands, after the dead zone: of a stick from -1 to 1, the speed at its end.
        turning: Another factor on what a twist turns, besides that: a stick that is at its end at 0.25 m/s
            may turn faster than at 0.25 rad/s.
        smoothing: Time constant of a low-pass filter on commands; none when 0 [s].
        locked: Axes, of the command's frame, on which a tool's commands do not count.
        clock_tolerance: A stamp ahead of the executor's clock by at most so much counts as now [s]; one that
            is farther ahead is refused.
    """

    period: float = 0.004
    timeout: float = 0.1
    clearance: float = 0.005
    linear: float = REDUCED_SPEED
    angular: float = REDUCED_SPEED / LENGTH
    dead_zone: float = 0.0
    scaling: float = 1.0
    turning: float = 1.0
    smoothing: float = 0.0
    locked: Sequence[Axis] = ()
    clock_tolerance: float = CLOCK_TOLERANCE

    def __post_init__(self) -> None:
        """Check the numbers.

        Raises:
            ProblemError: If one is out of its range.
        """
        if not FASTEST <= number("period", self.period) <= SLOWEST:
            raise ProblemError(f"period is from {FASTEST:g} to {SLOWEST:g} s, is {self.period:g} s")
        above_zero(self, "timeout", "linear", "angular", "scaling", "turning")
        at_least(self, 0.0, "clearance", "dead_zone", "smoothing", "clock_tolerance")
        object.__setattr__(self, "locked", several("locked", self.locked, Axis))

    @property
    def taken(self) -> float:
        """The share of the way to a command that the filter goes in a tick."""
        return 1.0 - exp(-self.period / self.smoothing) if self.smoothing else 1.0
