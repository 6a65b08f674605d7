"""Executor of a robot whose controller takes a position in each period."""

import time
from collections.abc import Callable
from threading import Event, Lock, Thread
from typing import Protocol, Self

import numpy as np

from trajopt.driving.committed_motion import CommittedMotion
from trajopt.driving.executor import STOPPED, RobotState
from trajopt.values.arrays import Floats, floats, number, positive
from trajopt.values.errors import ProblemError
from trajopt.values.errors.arguments import checked_class
from trajopt.values.trajectory import Trajectory


class PositionController(Protocol):
    """A controller that follows positions; all of n joints, in one order. Its errors are exceptions."""

    def measured(self) -> tuple[Floats, Floats]:
        """Return the present positions [rad | m] and velocities [rad/s | m/s], shape (n,) each."""
        ...

    def command(self, positions: Floats, velocities: Floats) -> None:
        """Follow positions, shape (n,) [rad | m], with these velocities [rad/s | m/s]."""
        ...

    def brake(self) -> None:
        """Bring the robot to rest."""
        ...

    def error(self) -> str:
        """Return why the controller does not follow; empty if it does."""
        ...

    def reset(self) -> None:
        """Follow commands again after an error or a brake."""
        ...


@checked_class
class StreamingExecutor:
    """Drives a robot by a position in each period.

    `tick` reads the state and sends the position of the committed motion; in a `with` block a thread calls
    it. If the loop ends, a controller holds the last position, which lies on a proven motion.
    """

    def __init__(
        self,
        controller: PositionController,
        joint_names: tuple[str, ...],
        *,
        tolerance: float | Floats,
        period: float,
        lag: float = 0.0,
        silence: float = 0.2,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """Take over a robot at rest.

        Args:
            tolerance: Largest tracking error of each joint, one number for all or shape (n,) [rad | m].
                `conformance` reports a tolerance that is too small.
            lag: Time by which the positions are behind the commands, beyond a period [s].
            silence: Longest time without a tick before a fault is reported [s]; a motion does not go on
                after it, because the robot would jump.

        Raises:
            ProblemError: If `period` or `silence` is not positive, or `lag` or `tolerance` negative.
            ShapeError: If a tolerance or position is missing.
        """
        for name, value in (("period", period), ("silence", silence)):
            positive(name, value)
        size = len(joint_names)
        allowed = np.full(size, tolerance) if isinstance(tolerance, float | int) else tolerance
        self.joint_names, self.period, self.latency = joint_names, period, period
        self.tolerance: Floats = floats("tolerance", allowed, (size,))
        if self.tolerance.min(initial=0.0) < 0.0 or number("lag", lag) < 0.0:
            raise ProblemError("tolerance and lag must not be negative")
        self._controller, self._lag, self._silence, self._clock = controller, lag, silence, clock
        # A command may block for a period, during which motions are spliced in.
        self._failure, self._lock, self._calls = "", Lock(), Lock()
        self._ended, self._thread = Event(), None
        self._thread: Thread | None
        self._measured = self._measure()
        self.committed = CommittedMotion(joint_names, self._measured[0])
        self._sent, self._ticked = self._measured[0], clock()
        self._stamp = self._ticked

    def now(self) -> float:
        return self._clock()

    def state(self) -> RobotState:
        with self._lock:
            stamp, (positions, velocities) = self._stamp, self._measured
            commanded, _, accelerations = self.committed(stamp)
        return RobotState(stamp, positions, velocities, accelerations, commanded)

    def splice(self, trajectory: Trajectory, at: float) -> str:
        if refused := self.fault():
            return refused
        with self._lock:
            now = self.now()
            refused = self.committed.refusal(trajectory, at, earliest=now + self.latency)
            if not refused:
                self.committed.splice(trajectory, at, now=now)
            return refused

    def tick(self) -> None:
        """Read the state and send the present position; call it once per period."""
        with self._calls:
            now = self.now()
            try:
                measured = self._measure()
                with self._lock:
                    # The positions show the last command, not the next one.
                    self._measured, self._stamp = measured, self._ticked - self._lag
                    positions, velocities, _ = self.committed(now)
                # After a pause the motion is elsewhere, and the robot would jump.
                if (np.abs(positions - self._sent) > self.tolerance).any():
                    self._failure = self._failure or self._silent(now)
                if not self._failure and not self._controller.error():
                    self._controller.command(positions, velocities)
                    self._sent = positions
            except Exception as error:
                self._failure = _words(error)
            self._ticked = now

    def stop(self) -> None:
        self._failure = self._failure or STOPPED
        with self._calls:
            try:
                self._controller.brake()
            except Exception as error:
                self._failure = _words(error)

    def fault(self) -> str:
        if self._failure:
            return self._failure
        return self._silent(self.now()) or self._controller.error()

    def clear_fault(self) -> None:
        with self._calls, self._lock:
            self._controller.reset()
            self._measured = self._measure()
            self.committed = CommittedMotion(self.joint_names, self._measured[0])
            self._failure, self._sent, self._ticked = "", self._measured[0], self.now()
            self._stamp = self._ticked

    def __enter__(self) -> Self:
        self._ended.clear()
        self._thread = Thread(target=self._run, name="executor", daemon=True)
        self._thread.start()
        return self

    def __exit__(self, *raised: object) -> None:
        self._ended.set()
        if self._thread is not None:
            self._thread.join()
        self.stop()

    def _run(self) -> None:
        due = time.monotonic()
        while not self._ended.wait(max(due - time.monotonic(), 0.0)):
            self.tick()
            due = max(due + self.period, time.monotonic())

    def _silent(self, now: float) -> str:
        silent = now - self._ticked
        return f"the loop of the driver has not run for {silent:.2f} s" if silent > self._silence else ""

    def _measure(self) -> tuple[Floats, Floats]:
        positions, velocities = self._controller.measured()
        size = len(self.joint_names)
        return floats("positions", positions, (size,)), floats("velocities", velocities, (size,))


def _words(error: Exception) -> str:
    return f"{type(error).__name__}: {error}"
