"""Executor: the interface of a robot driver, and an ideal one without a simulation."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np

from trajopt.driving.committed_motion import CommittedMotion
from trajopt.values.arrays import Floats, Value, floats
from trajopt.values.errors.arguments import checked
from trajopt.values.trajectory import Trajectory


@dataclass(frozen=True, eq=False)
class RobotState(Value):
    """Where a robot was measured to be, and when.

    Attributes:
        stamp: When it was measured, on the executor's clock [s].
        positions: Of the executor's joints, shape (n,) [rad | m].
        velocities: Shape (n,) [rad/s | m/s].
        accelerations: Shape (n,) [rad/s^2 | m/s^2]; those that are commanded, where none are measured.
        commanded: Where the joints had to be at that time, shape (n,) [rad | m]. What is spliced in begins
            there: a robot stands a little off the place to which it is driven.
    """

    stamp: float
    positions: Floats
    velocities: Floats
    accelerations: Floats
    commanded: Floats


@runtime_checkable
class Executor(Protocol):
    """Drives a robot along motions on one clock.

    Whatever it is given ends at rest. So if nothing more comes, because whoever plans is slow, stuck or dead,
    the robot ends at rest as well, where it was proven that it may. `CommittedMotion` keeps what is to be
    driven, checks what is spliced in, and says where the robot has to be at a time: a driver asks it in each
    period.
    """

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Joints that it drives; states are in this order."""
        ...

    @property
    def period(self) -> float:
        """Time from one command to the next [s]."""
        ...

    @property
    def latency(self) -> float:
        """A motion given now can begin so much later, no sooner [s]."""
        ...

    @property
    def tolerance(self) -> Floats:
        """How far each joint may be from where it has to be, shape (n,) [rad | m]."""
        ...

    def now(self) -> float:
        """Return the time on its clock, which starts at any number and goes on evenly [s]."""
        ...

    def state(self) -> RobotState:
        """Return the last measured state."""
        ...

    def splice(self, trajectory: Trajectory, at: float) -> str:
        """Drive a motion from a time on, in place of what would have been driven then.

        Args:
            trajectory: Of some or all of its joints; from the time `at` on the others stand still. It begins
                as the motion is at that time, in position, velocity and acceleration, and ends at rest.
            at: When it begins, on the clock [s].

        Returns:
            Why it is refused: it is late, or begins or ends elsewhere; empty if it will be driven. What is
            refused changes nothing.
        """
        ...

    def stop(self) -> None:
        """Bring the robot to rest at once, in the driver's own way: nobody proves where that ends.

        For when there is no time to ask, or nobody who plans. It is a fault afterwards.
        """
        ...

    def fault(self) -> str:
        """Say why the robot does not follow, in words; empty if it does."""
        ...

    def clear_fault(self) -> None:
        """Go on where the robot stands now: what it has to do begins anew, at rest there.

        Raises:
            ExecutionError: If it cannot.
        """
        ...


class IdealExecutor:
    """Follows without an error; its clock goes on when it is told to, or is one that it is given.

    Attributes:
        committed: What it has to do.
    """

    @checked
    def __init__(
        self,
        joint_names: tuple[str, ...],
        positions: Floats,
        *,
        period: float = 1e-3,
        latency: float = 5e-3,
        clock: Callable[[], float] | None = None,
    ) -> None:
        """Stand still.

        Args:
            joint_names: Joints that it drives.
            positions: Where they stand, shape (n,) [rad | m].
            period: Time from one command to the next [s].
            latency: A motion given now can begin so much later [s].
            clock: Tells the time [s]; when None, `advance` makes it.
        """
        self.joint_names, self.period, self.latency = joint_names, period, latency
        self.tolerance: Floats = np.full(len(joint_names), 1e-6)
        self.committed = CommittedMotion(joint_names, positions)
        self._clock, self._now, self._fault = clock, 0.0, ""
        self._displaced: Floats = np.zeros(len(joint_names))

    def now(self) -> float:
        """Return the time on its clock [s]."""
        return self._now if self._clock is None else self._clock()

    @checked
    def advance(self, seconds: float) -> None:
        """Let time pass [s]."""
        self._now += seconds

    def state(self) -> RobotState:
        """Return the state now."""
        now = self.now()
        positions, velocities, accelerations = self.committed(now)
        return RobotState(now, positions + self._displaced, velocities, accelerations, positions)

    @checked
    def displace(self, positions: Floats) -> None:
        """Let it be off where it has to be by so much from now on, shape (n,) [rad | m]."""
        self._displaced = floats("positions", positions, (len(self.joint_names),))

    @checked
    def splice(self, trajectory: Trajectory, at: float) -> str:
        """Drive a motion from a time on; say why not."""
        now = self.now()
        if self._fault:
            return self._fault
        refused = self.committed.refusal(trajectory, at, earliest=now + self.latency)
        if not refused:
            self.committed.splice(trajectory, at, now=now)
        return refused

    def stop(self) -> None:
        """Stand still at once, as only a robot without mass can."""
        self.committed = CommittedMotion(self.joint_names, self.state().positions)
        self._displaced = np.zeros(len(self.joint_names))
        self._fault = "it was stopped at once"

    def fault(self) -> str:
        """Say why it does not follow."""
        return self._fault

    def clear_fault(self) -> None:
        """Go on from where it stands."""
        self._fault = ""
