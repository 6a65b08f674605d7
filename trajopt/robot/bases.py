"""Moving bases: in the plane, or along a rail."""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import ArrayLike

from trajopt.values.arrays import direction_of, floats, number, one_of, positive, sequence
from trajopt.values.errors import ModelError
from trajopt.values.errors.arguments import checked


class Drive(Enum):
    """Drive of a base in the plane."""

    HOLONOMIC = "holonomic"
    """Moves in every direction: omnidirectional or steered wheels."""
    DIFFERENTIAL = "differential"
    """Moves forwards, backwards and about its own centre: two wheels that roll without sliding sideways."""


DRIFT = 0.01
"""Default deviation of a rolling base from the planned motion [m]: the optimiser's margin."""


@dataclass(frozen=True)
class BaseJoint:
    """One joint of a moving base.

    Attributes:
        suffix: Suffix of its name after that of the base, such as "/x".
        axis: Its axis in the frame of the previous joint, shape (3,).
    """

    suffix: str
    kind: str
    axis: tuple[float, float, float]
    lower: float
    upper: float
    velocity: float
    acceleration: float


@dataclass(frozen=True)
class MovingBase:
    """A moving base, for `load` and `Robot.from_urdf`; made by `planar_base` and `rail`.

    Attributes:
        joints: From the world to the robot.
        name: Prefix of their names; empty for the name of the joint that they replace.
        groups: Groups that move it, beyond those of the SRDF.
        drift: Largest deviation of a rolling base from the planned motion [m].
    """

    joints: tuple[BaseJoint, ...]
    name: str
    groups: tuple[str, ...]
    drive: Drive = Drive.HOLONOMIC
    drift: float = DRIFT


@dataclass(frozen=True)
class RobotBase:
    """The connection of a robot to the world.

    Attributes:
        name: The joint between the two in MoveIt's files; may be empty.
        frame: The world frame in MoveIt's files; may be empty.
        drift: Largest deviation of a rolling base from the planned motion [m].
    """

    name: str = ""
    frame: str = ""
    joints: tuple[str, ...] = ()
    drive: Drive = Drive.HOLONOMIC
    drift: float = DRIFT

    @property
    def rolls(self) -> bool:
        return self.drive is Drive.DIFFERENTIAL

    @checked
    def rolling(self, moved: Sequence[str]) -> tuple[int, int, int] | None:
        """Return the indices of x, y and yaw among the moving joints; None unless the base rolls."""
        if not self.rolls or not set(self.joints) <= set(moved):
            return None
        x, y, yaw = (moved.index(joint) for joint in self.joints)
        return x, y, yaw


PLANAR = ("/x", "/y", "/theta")
"""MoveIt's variables of a planar joint, as suffixes of its name."""


@checked
def planar_base(
    lower: ArrayLike,
    upper: ArrayLike,
    *,
    velocity: ArrayLike,
    acceleration: ArrayLike,
    yaw: ArrayLike | None = None,
    name: str = "",
    groups: Sequence[str] = (),
    drive: Drive = Drive.HOLONOMIC,
    drift: float = DRIFT,
    degrees: bool = False,
) -> MovingBase:
    """Make a base that moves in the plane: joints `NAME/x` and `NAME/y` [m], then `NAME/theta` [rad].

    They replace a planar or floating joint of the SRDF (`virtual_joint`) or of the URDF, and belong to its
    groups. Without such a joint they carry the whole robot. The speeds of x and y are limited separately, as
    in MoveIt.

    A base of `Drive.DIFFERENTIAL` cannot move sideways: the origin of its link moves along the link's x axis
    only. The judge proves that wheels driven at the planned forward speed and yaw rate, without feedback,
    would deviate from the planned motion by at most `drift`. Bodies are judged at their planned places.

    Args:
        lower: Least x and y, shape (2,) [m]; `upper` the largest.
        velocity: Largest speed along x and along y [m/s], and of yaw [rad/s], shape (2,).
        acceleration: Largest acceleration along x and along y [m/s^2], and of yaw [rad/s^2], shape (2,).
        yaw: Least and largest yaw, shape (2,) [rad]; unlimited if None.
        name: The joint that they replace; needed if there are several. Without such a joint, the prefix of
            their names ("base" by default).
        groups: Groups that move the base, beyond those of the SRDF.
        drift: As above, > 0 [m].
        degrees: Whether yaw, its velocity and its acceleration are in degrees.

    Raises:
        ShapeError: If a number is invalid.
        ModelError: If a lower limit is not below its upper limit.
        ProblemError: If a speed or the drift is not positive.
    """
    (left, near), (right, far) = (_pair("lower", lower), _pair("upper", upper))
    speed, turn = (positive("velocity", value) for value in _pair("velocity", velocity))
    rise, turn_rise = (positive("acceleration", value) for value in _pair("acceleration", acceleration))
    least, most = (0.0, 0.0) if yaw is None else _pair("yaw", yaw)
    if one_of("degrees", degrees, bool):
        turn, turn_rise, least, most = np.deg2rad((turn, turn_rise, least, most)).tolist()
    turning = "continuous" if yaw is None else "revolute"
    x, y, theta = PLANAR
    return MovingBase(
        (
            _joint(x, "prismatic", (1.0, 0.0, 0.0), (left, right), (speed, rise)),
            _joint(y, "prismatic", (0.0, 1.0, 0.0), (near, far), (speed, rise)),
            _joint(theta, turning, (0.0, 0.0, 1.0), (least, most), (turn, turn_rise)),
        ),
        one_of("name", name, str),
        tuple(sequence("groups", groups)),
        one_of("drive", drive, Drive),
        positive("drift", drift),
    )


@checked
def rail(
    axis: ArrayLike,
    lower: float,
    upper: float,
    *,
    velocity: float,
    acceleration: float,
    name: str = "",
    groups: Sequence[str] = (),
) -> MovingBase:
    """Make a rail: one prismatic joint between the world and the robot.

    Args:
        axis: Its direction in the world, shape (3,); scaled to length one.
        lower: Least travel [m], as `upper`; at zero the robot is at the origin.
        name: Name of the joint; by default that of the SRDF's virtual joint, or else "rail".
        groups: Groups that move the robot along it, beyond those of the SRDF.

    Raises:
        ShapeError: If a number is invalid, or the axis is zero.
        ModelError: If the lower limit is not below the upper one.
        ProblemError: If a speed is not positive.
    """
    x, y, z = direction_of("axis", axis).tolist()
    limits = (number("lower", lower), number("upper", upper))
    speeds = (positive("velocity", velocity), positive("acceleration", acceleration))
    joints = (_joint("", "prismatic", (x, y, z), limits, speeds),)
    return MovingBase(joints, one_of("name", name, str), tuple(sequence("groups", groups)))


def _pair(name: str, value: ArrayLike) -> tuple[float, float]:
    first, second = floats(name, value, (2,)).tolist()
    return first, second


def _joint(
    suffix: str,
    kind: str,
    axis: tuple[float, float, float],
    limits: tuple[float, float],
    speeds: tuple[float, float],
) -> BaseJoint:
    lower, upper = limits
    if lower > upper:
        name = suffix.strip("/") or "the rail"
        raise ModelError(f"base: the limits of {name}, {lower:g} and {upper:g}, leave it no position")
    return BaseJoint(suffix, kind, axis, lower, upper, *speeds)
