"""Ideal executor: a robot that is where it has to be, without a simulation; the shortest driver there is."""

from collections.abc import Callable

import numpy as np

from trajopt.driving.committed_motion import CommittedMotion
from trajopt.driving.executor import RobotState
from trajopt.values.arrays import Floats, floats
from trajopt.values.errors.arguments import checked
from trajopt.values.trajectory import Trajectory


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
