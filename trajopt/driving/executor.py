"""Interfaces of robot drivers, and an executor without a simulation."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np

from trajopt.driving.committed_motion import CommittedMotion
from trajopt.values.arrays import Floats, Value, floats
from trajopt.values.errors.arguments import checked, checked_class
from trajopt.values.trajectory import Trajectory

STOPPED = "the driver stopped the robot"


@dataclass(frozen=True, eq=False)
class RobotState(Value):
    """A measured state of a robot.

    Attributes:
        stamp: Time of the measurement, on the executor's clock [s].
        positions: Of the executor's joints, shape (n,) [rad | m].
        accelerations: Shape (n,) [rad/s^2 | m/s^2]; the commanded ones if none are measured.
        commanded: Commanded positions at that time, shape (n,) [rad | m], at which spliced motions begin.
    """

    stamp: float
    positions: Floats
    velocities: Floats
    accelerations: Floats
    commanded: Floats


@runtime_checkable
class Executor(Protocol):
    """Drives a robot along motions on one clock.

    Every motion ends at rest, so the robot comes to rest as proven if no further one comes. `CommittedMotion`
    holds the motion, checks splices, and returns the commanded positions.
    """

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Driven joints, in the order of states."""
        ...

    @property
    def period(self) -> float:
        """Time between commands [s]."""
        ...

    @property
    def latency(self) -> float:
        """Least time from giving a motion to its beginning [s]."""
        ...

    @property
    def tolerance(self) -> Floats:
        """Largest tracking error of each joint, shape (n,) [rad | m]."""
        ...

    def now(self) -> float:
        """Return the time on its clock, which starts at any number and never jumps [s]."""
        ...

    def state(self) -> RobotState:
        """Return the last measured state."""
        ...

    def splice(self, trajectory: Trajectory, at: float) -> str:
        """Drive a motion from a time on, instead of the present one; return the reason of a refusal.

        It is refused if it is late, or begins or ends in another state; a refused motion changes nothing.

        Args:
            trajectory: Of some or all of its joints; the others are at rest from the time `at`. It begins in
                the commanded position, velocity and acceleration of that time, and ends at rest.
        """
        ...

    def stop(self) -> None:
        """Bring the robot to rest as fast as the driver can, without a proof; a fault afterwards."""
        ...

    def fault(self) -> str:
        """Return why the robot does not follow; empty if it does."""
        ...

    def clear_fault(self) -> None:
        """Clear a fault: the robot is then committed to rest at its present position.

        Raises:
            ExecutionError: If this is impossible.
        """
        ...


@checked
@dataclass(frozen=True)
class GripperState(Value):
    """A measured state of a gripper.

    Attributes:
        opening: Distance between the pads [m]; 0 for a suction cup.
        moving: Whether the last command is not finished.
    """

    opening: float
    moving: bool
    holding: bool


@runtime_checkable
class GripperDriver(Protocol):
    """Drives a gripper, as in libfranka.

    Commands return immediately; a new one replaces the last. A suction cup switches on to grasp and off to
    move, and ignores the numbers.
    """

    def state(self) -> GripperState:
        """Return the last measured state."""
        ...

    def move(self, opening: float) -> None:
        """Move the fingers to a distance between the pads [m], which lets an object go."""
        ...

    def grasp(self, width: float, force: float) -> None:
        """Close the fingers on an object, and press on it.

        Args:
            width: Of the object between the pads [m]; if the fingers stop elsewhere, they hold nothing.
            force: Of each finger [N].
        """
        ...


@checked_class
class IdealExecutor:
    """Executor without tracking error or simulation, on a given clock or one that the caller advances."""

    def __init__(
        self,
        joint_names: tuple[str, ...],
        positions: Floats,
        *,
        period: float = 1e-3,
        latency: float = 5e-3,
        clock: Callable[[], float] | None = None,
    ) -> None:
        self.joint_names, self.period, self.latency = joint_names, period, latency
        self.tolerance: Floats = np.full(len(joint_names), 1e-6)
        self.committed = CommittedMotion(joint_names, positions)
        self._clock, self._now, self._fault = clock, 0.0, ""
        self._displaced: Floats = np.zeros(len(joint_names))

    def now(self) -> float:
        return self._now if self._clock is None else self._clock()

    def advance(self, seconds: float) -> None:
        """Advance the clock [s]."""
        self._now += seconds

    def state(self) -> RobotState:
        now = self.now()
        positions, velocities, accelerations = self.committed(now)
        return RobotState(now, positions + self._displaced, velocities, accelerations, positions)

    def displace(self, positions: Floats) -> None:
        """Add a tracking error from now on, shape (n,) [rad | m]."""
        self._displaced = floats("positions", positions, (len(self.joint_names),))

    def splice(self, trajectory: Trajectory, at: float) -> str:
        now = self.now()
        if self._fault:
            return self._fault
        refused = self.committed.refusal(trajectory, at, earliest=now + self.latency)
        if not refused:
            self.committed.splice(trajectory, at, now=now)
        return refused

    def stop(self) -> None:
        self.committed = CommittedMotion(self.joint_names, self.state().positions)
        self._displaced = np.zeros(len(self.joint_names))
        self._fault = STOPPED

    def fault(self) -> str:
        return self._fault

    def clear_fault(self) -> None:
        self._fault = ""
