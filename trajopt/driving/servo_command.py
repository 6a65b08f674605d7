"""Velocities and poses for one moment, and the options that shape them."""

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
    several,
)
from trajopt.values.errors import ProblemError
from trajopt.values.errors.arguments import checked
from trajopt.values.placement import WORLD, Placement, PlacementLike, as_placement

REDUCED_SPEED = 0.25
"""Largest speed of a tool under manual control by ISO 10218-1 [m/s]."""
FASTEST, SLOWEST = 0.002, 0.01
"""Least and largest time between ticks: 500 to 100 per second [s]."""


class Axis(Enum):
    """Axes of translation and rotation of a tool."""

    X = 0
    Y = 1
    Z = 2
    ABOUT_X = 3
    ABOUT_Y = 4
    ABOUT_Z = 5


@checked
@dataclass(frozen=True, eq=False)
class Twist(Value):
    """Velocity of the tool [m/s] and [rad/s], along the axes of a frame."""

    linear: Floats = field(default_factory=lambda: np.zeros(3))
    angular: Floats = field(default_factory=lambda: np.zeros(3))
    frame: str = WORLD

    def __post_init__(self) -> None:
        for name in ("linear", "angular"):
            object.__setattr__(self, name, floats(name, getattr(self, name), (3,)))


@checked
@dataclass(frozen=True, eq=False)
class Pose(Value):
    """Placement of the tool in the world, to which it moves."""

    placement: PlacementLike
    target: Placement = field(init=False, repr=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "target", as_placement("placement", self.placement))


@checked
@dataclass(frozen=True, eq=False)
class JointVelocities(Value):
    """Velocities by joint of the group [rad/s | m/s]; 0 for the others."""

    velocities: Mapping[str, float]

    def __post_init__(self) -> None:
        for name, value in mapping("velocities", self.velocities).items():
            number(f"velocity of {name}", value)


Command = Twist | Pose | JointVelocities


@checked
@dataclass(frozen=True, kw_only=True)
class ServoOptions:
    """Options of a servo.

    Attributes:
        timeout: The robot stops if its last command is older than this [s].
        clearance: Distance kept beyond the required clearances, for the stop, which is not straight [m].
        linear: Largest speed of a tool on its way to a pose [m/s].
        dead_zone: Subtracted from the size of each number of a command, in its units: sticks are inexact.
        scaling: Factor on commands, after the dead zone: for a stick from -1 to 1, the speed at its end.
        turning: Additional factor on the angular part of twists.
        smoothing: Time constant of a low-pass filter on commands; no filter if 0 [s].
        locked: Axes, of the command's frame, on which commands of the tool have no effect.
        clock_tolerance: Stamps ahead of the clock by up to this count as now [s].
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
        if not FASTEST <= number("period", self.period) <= SLOWEST:
            raise ProblemError(f"period must be from {FASTEST:g} to {SLOWEST:g} s, is {self.period:g} s")
        above_zero(self, "timeout", "linear", "angular", "scaling", "turning")
        at_least(self, 0.0, "clearance", "dead_zone", "smoothing", "clock_tolerance")
        object.__setattr__(self, "locked", several("locked", self.locked, Axis))

    @property
    def filter_gain(self) -> float:
        """Gain of the low-pass filter in a tick, in (0, 1]."""
        return 1.0 - exp(-self.period / self.smoothing) if self.smoothing else 1.0
