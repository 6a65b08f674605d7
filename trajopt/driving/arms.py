"""Arms of Universal Robots and Franka as controllers for `StreamingExecutor`."""

import time
from collections.abc import Sequence
from contextlib import suppress
from importlib import import_module
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike

from trajopt.values.arrays import Floats, floats, number, positive
from trajopt.values.errors import ExecutionError, MissingExtra, ProblemError
from trajopt.values.errors.arguments import checked_class

LOOKAHEAD, GAIN = (0.03, 0.2), (100.0, 2000.0)
"""Ranges of the arguments of servoj in the URScript manual."""
STARTING = 2.0
"""Longest time in which a control script starts [s]."""
STIFFNESS = (600.0, 600.0, 600.0, 600.0, 250.0, 150.0, 50.0)
"""Stiffness of the joints in libfranka's example `joint_impedance_control.cpp` [Nm/rad]."""
STOPPING = 2.0
"""Longest time in which the arm stops [s]."""


class RtdeControl(Protocol):
    """The methods of `RTDEControlInterface` that drive the arm."""

    def servoJ(
        self,
        q: list[float],
        speed: float,
        acceleration: float,
        time: float,
        lookahead_time: float,
        gain: float,
        /,
    ) -> bool:
        """Servo to joint positions."""
        ...

    def servoStop(self, a: float = 10.0) -> bool:
        """Leave servo mode and decelerate."""
        ...

    def isConnected(self) -> bool:
        """Return whether the connection works."""
        ...

    def isProgramRunning(self) -> bool:
        """Return whether its script runs on the controller."""
        ...

    def reuploadScript(self) -> bool:
        """Start its script again."""
        ...

    def stopScript(self) -> None:
        """End its script."""
        ...

    def disconnect(self) -> None:
        """Close the connection."""
        ...


class RtdeReceive(Protocol):
    """The methods of `RTDEReceiveInterface` that return the state of the arm."""

    def getActualQ(self) -> Sequence[float]:
        """Return joint positions [rad]."""
        ...

    def getActualQd(self) -> Sequence[float]:
        """Return joint velocities [rad/s]."""
        ...

    def isConnected(self) -> bool:
        """Return whether the connection works."""
        ...

    def isProtectiveStopped(self) -> bool:
        """Return whether the arm is in a protective stop."""
        ...

    def isEmergencyStopped(self) -> bool:
        """Return whether the arm is in an emergency stop."""
        ...

    def disconnect(self) -> None:
        """Close the connection."""
        ...


@checked_class
class UrController:
    """An arm of Universal Robots that follows positions by `servoJ` of ur_rtde.

    Its joints are the arm's, from the base on.
    """

    def __init__(
        self,
        control: RtdeControl,
        receive: RtdeReceive,
        *,
        period: float = 0.002,
        lookahead: float = 0.03,
        gain: float = 500.0,
        deceleration: float = 10.0,
    ) -> None:
        """Take over two connections; https://sdurobotics.gitlab.io/ur_rtde describes them.

        Args:
            control: `rtde_control.RTDEControlInterface`.
            receive: `rtde_receive.RTDEReceiveInterface`.
            period: Time between commands [s]: 0.002 for e-Series, 0.008 for CB3.
            lookahead: Time over which the controller smooths the positions, 0.03 to 0.2 [s]; about the delay
                of the arm.
            gain: Proportional gain of the controller, 100 to 2000.
            deceleration: Of the tool in a stop [m/s^2].

        Raises:
            ProblemError: If a number is out of its range.
        """
        for name, value, (least, most) in (("lookahead", lookahead, LOOKAHEAD), ("gain", gain, GAIN)):
            if not least <= number(name, value) <= most:
                raise ProblemError(f"{name} must be from {least:g} to {most:g}, is {value:g}")
        for name, value in (("period", period), ("deceleration", deceleration)):
            positive(name, value)
        self._control, self._receive, self._deceleration = control, receive, deceleration
        self._timing = period, lookahead, gain

    @staticmethod
    def connect(
        host: str, *, period: float = 0.002, lookahead: float = 0.03, gain: float = 500.0
    ) -> "UrController":
        """Connect to an arm in remote control; arguments as for the constructor.

        Raises:
            MissingExtra: Without ur_rtde.
            ExecutionError: If the arm does not answer.
        """
        try:
            rtde_control, rtde_receive = import_module("rtde_control"), import_module("rtde_receive")
        except ImportError as error:
            raise MissingExtra("ur_rtde", "ur") from error
        try:
            control = rtde_control.RTDEControlInterface(host, 1.0 / period)
            receive = rtde_receive.RTDEReceiveInterface(host, 1.0 / period)
        except RuntimeError as error:
            raise ExecutionError(f"cannot connect to the arm at {host}: {error}") from error
        return UrController(control, receive, period=period, lookahead=lookahead, gain=gain)

    def measured(self) -> tuple[Floats, Floats]:
        return np.array(self._receive.getActualQ()), np.array(self._receive.getActualQd())

    def command(self, positions: Floats, velocities: Floats) -> None:
        del velocities
        # The second and third argument, speed and acceleration, have no effect.
        if not self._connected() or not self._control.servoJ(positions.tolist(), 0.0, 0.0, *self._timing):
            raise ExecutionError(f"the arm does not take servoJ: {self.error() or 'no reason is known'}")

    def brake(self) -> None:
        if self._connected():
            self._control.servoStop(self._deceleration)

    def close(self) -> None:
        if self._connected():
            self._control.stopScript()
        self._control.disconnect()
        self._receive.disconnect()

    def error(self) -> str:
        return self._stopped() or (
            "" if self._control.isProgramRunning() else "the control script does not run on the arm"
        )

    def _connected(self) -> bool:
        # Without a connection ur_rtde 1.6.5 blocks a command for 4 s, or ends the process.
        return self._receive.isConnected() and self._control.isConnected()

    def _stopped(self) -> str:
        if not self._connected():
            return "the connection to the arm is lost"
        if self._receive.isEmergencyStopped():
            return "the arm is in an emergency stop"
        return "the arm is in a protective stop" if self._receive.isProtectiveStopped() else ""

    def reset(self) -> None:
        """Start the control script again if it has ended; raises if the arm is stopped on its pendant."""
        if not self._stopped() and not self._control.isProgramRunning():
            self._control.reuploadScript()
            deadline = time.monotonic() + STARTING
            while self.error() and time.monotonic() < deadline:
                time.sleep(0.01)
        if fault := self.error():
            raise ExecutionError(f"the fault stays: {fault}")


class FrankyRobot(Protocol):
    """The members of `franky.Robot` that drive the arm."""

    @property
    def current_joint_state(self) -> Any:
        """Joint positions [rad] and velocities [rad/s]."""
        ...

    @property
    def has_errors(self) -> bool:
        """Whether the arm reports errors."""
        ...

    @property
    def is_in_control(self) -> bool:
        """Whether a motion is executed."""
        ...

    def move(self, motion: Any, asynchronous: bool = False) -> None:
        """Execute a motion after the present one."""
        ...

    def poll_motion(self) -> bool:
        """Raise the exception that ended the motion, if any."""
        ...

    def join_motion(self, timeout: float | None = None) -> bool:
        """Wait for the end of the motion; raise the exception that ended it."""
        ...

    def recover_from_errors(self) -> bool:
        """Clear the errors of the arm; return whether it worked."""
        ...


@checked_class
class FrankaController:
    """An arm of Franka that follows positions by the joint impedance control of franky.

    Its joints are the arm's, from the base on.
    """

    def __init__(self, robot: FrankyRobot, *, stiffness: ArrayLike = STIFFNESS) -> None:
        """Take over an arm at rest, and hold it; see https://timschneider42.github.io/franky.

        Args:
            robot: `franky.Robot`.
            stiffness: Of each joint, shape (7,) [Nm/rad]; the damping is critical.

        Raises:
            MissingExtra: Without franky.
            ProblemError: If a stiffness is not positive.
        """
        self._stiffness = _stiffness(stiffness)
        self._franky, self._robot = _franky(), robot
        self._start()

    @staticmethod
    def connect(host: str, *, realtime: bool = True, stiffness: ArrayLike = STIFFNESS) -> "FrankaController":
        """Connect to an arm with the Franka control interface activated.

        Args:
            realtime: Whether this computer must have a real-time kernel.

        Raises:
            MissingExtra: Without franky.
            ExecutionError: If the arm does not answer.
        """
        stiffness, franky = _stiffness(stiffness), _franky()
        kernel = franky.RealtimeConfig.Enforce if realtime else franky.RealtimeConfig.Ignore
        try:
            robot = franky.Robot(host, realtime_config=kernel)
        except Exception as error:
            raise ExecutionError(f"cannot connect to the arm at {host}: {error}") from error
        return FrankaController(robot, stiffness=stiffness)

    def measured(self) -> tuple[Floats, Floats]:
        state = self._robot.current_joint_state
        return np.array(state.position), np.array(state.velocity)

    def command(self, positions: Floats, velocities: Floats) -> None:
        self._motion.set_reference(self._franky.JointReference(q=positions, dq=velocities))

    def brake(self) -> None:
        if self._robot.is_in_control:
            self._robot.move(self._franky.TorqueStopMotion(), asynchronous=True)

    def error(self) -> str:
        try:
            self._robot.poll_motion()
            self._reason = self._reason or ("the arm reports errors" if self._robot.has_errors else "")
        except Exception as error:  # of the control loop; it is raised once
            self._reason = self._reason or f"{type(error).__name__}: {error}"
        return self._reason or ("" if self._robot.is_in_control else "the arm is not under control")

    def reset(self) -> None:
        """Clear the errors of the arm, and hold it; raises if they stay."""
        with suppress(Exception):  # the one that ended the motion
            self._robot.join_motion(STOPPING)
        if self._robot.has_errors and not self._robot.recover_from_errors():
            raise ExecutionError("the fault stays: the arm does not recover from its errors")
        self._start()

    def _start(self) -> None:
        self._motion = self._franky.JointImpedanceTrackingMotion(stiffness=self._stiffness)
        here, _ = self.measured()
        self.command(here, np.zeros(7))
        self._reason = ""
        self._robot.move(self._motion, asynchronous=True)


def _stiffness(given: ArrayLike) -> Floats:
    found = floats("stiffness", given, (7,))
    if not found.min() > 0.0:
        raise ProblemError(f"stiffness must be positive, is {found.min():g}")
    return found


def _franky() -> Any:
    try:
        return import_module("franky")
    except ImportError as error:
        raise MissingExtra("franky", "franka") from error
