"""An executor in another process, so that a planner that dies does not affect the robot."""

from multiprocessing.connection import Connection
from typing import Any

from trajopt.driving.executor import Executor, RobotState
from trajopt.values.arrays import Floats
from trajopt.values.errors import ExecutionError
from trajopt.values.trajectory import Trajectory

PROPERTIES, METHODS = "names", ("now", "state", "splice", "stop", "fault", "clear_fault")
DELAY = 5e-3
"""Longest time of a message between two processes [s]: a motion that arrives later is refused."""


def attend(executor: Executor, connection: "Connection[Any, Any]", *, wait: float = 0.0) -> bool:
    """Answer all pending requests; return whether the other end of the connection is still open."""
    try:
        while connection.poll(wait):
            number, name, arguments = connection.recv()
            connection.send((number, *_answer(executor, name, arguments)))
            wait = 0.0
    except (EOFError, OSError):
        return False
    return True


def _answer(executor: Executor, name: str, arguments: tuple[Any, ...]) -> tuple[object, str]:
    try:
        if name not in (PROPERTIES, *METHODS):
            raise ExecutionError(f"request {name!r} does not exist")
        if name == PROPERTIES:
            return (executor.joint_names, executor.period, executor.latency, executor.tolerance), ""
        return getattr(executor, name)(*arguments), ""
    except Exception as error:
        return None, str(error) or type(error).__name__


class RemoteExecutor:
    """An executor in another process; its latency includes the time of messages [s]."""

    def __init__(self, connection: "Connection[Any, Any]", *, delay: float = DELAY) -> None:
        """Read the properties of the executor from the process that calls `attend`.

        Raises:
            ExecutionError: By this and all methods, if the request fails or the other process has ended.
        """
        self._connection, self._number = connection, 0
        self.joint_names, self.period, latency, self.tolerance = self._request(PROPERTIES)
        self.joint_names: tuple[str, ...]
        self.period: float
        self.tolerance: Floats
        self.latency: float = latency + delay

    def now(self) -> float:
        return self._request("now")

    def state(self) -> RobotState:
        return self._request("state")

    def splice(self, trajectory: Trajectory, at: float) -> str:
        return self._request("splice", trajectory, at)

    def stop(self) -> None:
        self._request("stop")

    def fault(self) -> str:
        return self._request("fault")

    def clear_fault(self) -> None:
        self._request("clear_fault")

    def _request(self, name: str, *arguments: object) -> Any:
        self._number += 1
        try:
            self._connection.send((self._number, name, arguments))
            number, answer, failed = self._connection.recv()
            while number != self._number:  # the answer to an interrupted request
                number, answer, failed = self._connection.recv()
        except (EOFError, OSError) as error:
            raise ExecutionError("the process of the robot no longer answers") from error
        if failed:
            raise ExecutionError(f"{name} failed in the process of the robot: {failed}")
        return answer
