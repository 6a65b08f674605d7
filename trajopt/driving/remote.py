"""An executor in another process: whoever plans may die, and takes nothing with it.

The process of the robot calls `attend` again and again, beside driving the robot. The one that plans makes a
`RemoteExecutor` of its end of the connection (`multiprocessing.Pipe`), and uses it as any other. A request is
its number, the name of a method and its arguments; an answer is that number, what the method returns, and why
it could not be done. Each is one message of the connection.
"""

from multiprocessing.connection import Connection
from typing import Any

import numpy as np

from trajopt.driving.executor import Executor, RobotState
from trajopt.values.arrays import Floats
from trajopt.values.errors import ExecutionError
from trajopt.values.trajectory import Trajectory

DELAY = 5e-3
"""What a message between two processes takes at most [s]: a motion that comes later is refused."""


def attend(executor: Executor, connection: "Connection[Any, Any]", *, wait: float = 0.0) -> bool:
    """Answer all requests that are there; what goes wrong with one is told to who asked.

    Args:
        executor: What is asked.
        connection: To the process that asks.
        wait: Time in which a request may come [s].

    Returns:
        Whether there is still somebody at the other end.
    """
    try:
        while connection.poll(wait):
            number, name, arguments = connection.recv()
            connection.send((number, *_answer(executor, name, arguments)))
            wait = 0.0
    except (EOFError, OSError):
        return False
    return True


def _answer(executor: Executor, name: str, arguments: tuple[Any, ...]) -> tuple[object, str]:
    """Return what a method returns, or why it cannot be done: the robot's process goes on either way."""
    try:
        return _answered(executor, name, arguments), ""
    except Exception as error:
        return None, str(error) or type(error).__name__


def _answered(executor: Executor, name: str, arguments: tuple[Any, ...]) -> object:
    match name:
        case "names":
            return executor.joint_names, executor.period, executor.latency, executor.tolerance
        case "now":
            return executor.now()
        case "state":
            state = executor.state()
            return state.stamp, state.positions, state.velocities, state.accelerations, state.commanded
        case "splice":
            rows, at = arguments
            return executor.splice(Trajectory(*rows), at)
        case "stop":
            return executor.stop()
        case "fault":
            return executor.fault()
        case "clear_fault":
            return executor.clear_fault()
        case _:
            raise ExecutionError(f"no request is called {name!r}")


class RemoteExecutor:
    """An executor that another process has.

    Attributes:
        joint_names: Joints that it drives.
        period: Time from one command to the next [s].
        latency: A motion given now can begin so much later, with the time that messages take [s].
        tolerance: How far each joint may be from where it has to be, shape (n,) [rad | m].
    """

    def __init__(self, connection: "Connection[Any, Any]", *, delay: float = DELAY) -> None:
        """Ask what is driven.

        Args:
            connection: To the process that attends.
            delay: What messages take at most [s].

        Raises:
            ExecutionError: If it cannot be done, or nobody answers any more; so do all methods.
        """
        self._connection, self._number = connection, 0
        self.joint_names, self.period, latency, self.tolerance = self._asked("names")
        self.joint_names: tuple[str, ...]
        self.period: float
        self.tolerance: Floats
        self.latency: float = latency + delay

    def now(self) -> float:
        """Return the time on the robot's clock [s]."""
        return self._asked("now")

    def state(self) -> RobotState:
        """Return the last measured state."""
        return RobotState(*self._asked("state"))

    def splice(self, trajectory: Trajectory, at: float) -> str:
        """Drive a motion from a time on; say why not."""
        rows = (
            trajectory.joint_names,
            *(
                None if each is None else np.asarray(each)
                for each in (
                    trajectory.times, trajectory.positions, trajectory.velocities, trajectory.accelerations,
                )
            ),
        )  # fmt: skip
        return self._asked("splice", rows, at)

    def stop(self) -> None:
        """Bring the robot to rest at once, in the driver's own way."""
        self._asked("stop")

    def fault(self) -> str:
        """Say why the robot does not follow."""
        return self._asked("fault")

    def clear_fault(self) -> None:
        """Go on where the robot stands now."""
        self._asked("clear_fault")

    def _asked(self, name: str, *arguments: object) -> Any:
        self._number += 1
        try:
            self._connection.send((self._number, name, arguments))
            number, answer, failed = self._connection.recv()
            while number != self._number:  # of a request that was interrupted before it was answered
                number, answer, failed = self._connection.recv()
        except (EOFError, OSError) as error:
            raise ExecutionError("the process of the robot does not answer any more") from error
        if failed:
            raise ExecutionError(f"the process of the robot could not do {name}: {failed}")
        return answer
