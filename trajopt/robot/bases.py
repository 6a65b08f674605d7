"""What a robot's base can do beside standing still: move in the plane, or along a rail."""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import ArrayLike

from trajopt.values.arrays import direction_of, floats, number, one_of, positive, sequence
from trajopt.values.errors import ModelError
from trajopt.values.errors.arguments import checked


class Drive(Enum):
    """How a base in the plane is driven."""

    HOLONOMIC = "holonomic"
    """In every direction at any time: by omnidirectional or steered wheels."""
    DIFFERENTIAL = "differential"
    """Forwards, backwards and about its own middle: by two wheels that roll and do not slide sideways."""


DRIFT = 0.01
"""How far a base whose wheels roll may stray from the planned motion, unless told otherwise [m]: as much as
the optimiser's margin."""


@dataclass(frozen=True)
class BaseJoint:
    """One joint of a base that moves.

    Attributes:
        suffix: What its name has after that of the base, such as "/x".
        kind: URDF's name of its type.
        axis: Its axis in the frame of the joint before it, shape (3,).
        lower: Its lower limit [rad | m]; not read of a continuous joint.
        upper: Its upper limit [rad | m].
        velocity: Its largest speed [rad/s | m/s].
        acceleration: Its largest acceleration [rad/s^2 | m/s^2].
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
    """A base that moves, for `load` and `Robot.from_urdf`; made by `planar_base` and `rail`.

    Attributes:
        joints: Its joints, from the world to the robot.
        name: What their names begin with; empty for that of the joint that they stand for.
        groups: Groups that move it besides those that the SRDF says so of.
        drive: How it is driven.
        drift: How far a base whose wheels roll may stray from the planned motion [m].
    """

    joints: tuple[BaseJoint, ...]
    name: str
    groups: tuple[str, ...]
    drive: Drive = Drive.HOLONOMIC
    drift: float = DRIFT


@dataclass(frozen=True)
class RobotBase:
    """How a robot stands in the world.

    Attributes:
        name: The joint between the two in MoveIt's files; empty where nobody named it.
        frame: What MoveIt's files call the world; empty where nobody named it.
        joints: Names of the joints that move the base, from the world to the robot; none where it is fixed.
        drive: How it is driven.
        drift: How far a base whose wheels roll may stray from the planned motion [m].
    """

    name: str = ""
    frame: str = ""
    joints: tuple[str, ...] = ()
    drive: Drive = Drive.HOLONOMIC
    drift: float = DRIFT

    @checked
    def rolling(self, moved: Sequence[str]) -> tuple[int, int, int] | None:
        """Return where x, y and yaw are among joints that move; None where no wheels have to roll."""
        if self.drive is not Drive.DIFFERENTIAL or not set(self.joints) <= set(moved):
            return None
        x, y, yaw = (moved.index(joint) for joint in self.joints)
        return x, y, yaw


PLANAR = ("/x", "/y", "/theta")
"""What MoveIt calls the variables of a planar joint, after the joint's name."""


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
    """Let a robot's base move in the plane: joints `NAME/x` and `NAME/y` [m], then `NAME/theta` [rad].

    They stand for a planar or floating joint of the SRDF (`virtual_joint`) or of the URDF, and are in the
    groups that it is in. Where there is none they carry the whole robot.

    The speeds of x and y are limited apart, as in MoveIt: along a diagonal of the world the base may be
    faster by the square root of 2. `tool_speed` on a link of the base limits the speed itself.

    A base of `Drive.DIFFERENTIAL` cannot move sideways: the middle between its wheels, which is the origin of
    its link, moves along the link's x axis only. Motions are planned and judged so: were the wheels to turn
    as planned, forward speed and yaw rate, and nobody to correct, then the base would stray from the planned
    motion by at most `drift` at any time. Bodies are judged where they are planned.

    Args:
        lower: Least x and y, shape (2,) [m].
        upper: Largest x and y, shape (2,) [m].
        velocity: Largest speed along x and along y [m/s], and of yaw [rad/s], shape (2,).
        acceleration: Largest acceleration along x and along y [m/s^2], and of yaw [rad/s^2], shape (2,).
        yaw: Least and largest yaw, shape (2,) [rad]; the base turns without end when None.
        name: The joint that they stand for; may be left out where there is one only. Where there is none,
            what their names begin with: "base" when left out.
        groups: Groups that move the base besides those that the SRDF says so of.
        drive: How it is driven.
        drift: How far a base whose wheels roll may stray from the planned motion, > 0 [m].
        degrees: Whether yaw, its velocity and its acceleration are in degrees.

    Raises:
        ShapeError: If a number is not usable.
        ModelError: If limits leave no room.
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
    """Put a robot on a rail: one prismatic joint between the world and the robot.

    A rail that the URDF has already is a joint like any other and needs nothing.

    Args:
        axis: Its direction in the world, shape (3,); scaled to length one.
        lower: Least travel; the robot stands at the origin at zero [m].
        upper: Largest travel [m].
        velocity: Largest speed [m/s].
        acceleration: Largest acceleration [m/s^2].
        name: Name of the joint; that of the SRDF's virtual joint when left out, "rail" where there is none.
        groups: Groups that move the robot along it besides those that the SRDF says so of.

    Raises:
        ShapeError: If a number is not usable, or the axis has no length.
        ModelError: If limits leave no room.
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
