"""Arms of Franka through franky, as a controller for `StreamingExecutor`."""

from contextlib import suppress
from importlib import import_module
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike

from trajopt.values.arrays import Floats, floats
from trajopt.values.errors import ExecutionError, MissingExtra, ProblemError
from trajopt.values.errors.arguments import checked

STIFFNESS = (600.0, 600.0, 600.0, 600.0, 250.0, 150.0, 50.0)
"""Stiffness of the joints in libfranka's example `joint_impedance_control.cpp` [Nm/rad]."""
STOPPING = 2.0
"""Longest time in which the arm stops [s]."""


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


class FrankaController:
    """An arm of Franka that follows positions by the joint impedance control of franky.

    The control loop of 1 kHz is franky's. Its joints are those of the arm, from the base on.
    """

    @checked
    def __init__(self, robot: FrankyRobot, *, stiffness: ArrayLike = STIFFNESS) -> None:
        """Take over an arm at rest, and hold it; see https://timschneider42.github.io/franky.

        Args:
            robot: `franky.Robot`.
            stiffness: Stiffness of each joint, shape (7,) [Nm/rad]; the damping is critical. A stiffer arm
                is nearer to its commands.

        Raises:
            MissingExtra: If franky is not installed.
            ProblemError: If a stiffness is not positive.
        """
        self._stiffness = _stiffness(stiffness)
        self._franky, self._robot = _franky(), robot
        self._start()

    @staticmethod
    @checked
    def connect(host: str, *, realtime: bool = True, stiffness: ArrayLike = STIFFNESS) -> "FrankaController":
        """Connect to an arm with the Franka control interface activated.

        Args:
            realtime: Whether this computer must have a real-time kernel.
            stiffness: As for the constructor.

        Raises:
            MissingExtra: If franky is not installed.
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

    @checked
    def command(self, positions: Floats, velocities: Floats) -> None:
        """Set the reference of the control loop."""
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
