"""A world that a server answers: it plans there, and its simulated robot is driven there."""

from collections.abc import Callable
from dataclasses import dataclass, field
from threading import Event, Thread
from typing import Any, ParamSpec, TypeVar, cast

from trajopt.driving import Executor
from trajopt.driving.soonest_stop import StopTaken
from trajopt.files.bundle.containers import message_of, value_of_message
from trajopt.robot.robot import Robot
from trajopt.scene.scene import Scene
from trajopt.server.client import Client, ServerError
from trajopt.server.move_group.functions import Settings
from trajopt.server.move_group.outcome import Execution, MoveItCommanderException
from trajopt.values.arrays import Floats
from trajopt.values.documents.document import Node
from trajopt.values.errors import ModelError, TrajoptError, shown

P = ParamSpec("P")
R = TypeVar("R")
SILENCE = 600.0
"""Timeout for a silent server [s]: longer than any request takes."""


@dataclass(eq=False)
class _Motion:
    """A motion in progress: `begun` is set once the robot moves, or will not move."""

    begun: Event = field(default_factory=Event)
    thread: Thread | None = None
    answer: dict[str, Any] = field(default_factory=dict[str, Any])
    error: str = ""


class ServerBackend:
    """Backend of a world whose robot is planned and moved by a session of a server.

    Motions of the server are verified here.

    Attributes:
        positions: Last joint positions reported by the server [rad | m].
    """

    def __init__(self, url: str, robot: str, *, token: str) -> None:
        self._client = Client(url, token=token, timeout=SILENCE)
        try:
            self._session = self._client.session(robot)
            whole = self._session.ask("robot")
            self.robot: Robot = value_of_message(Node(whole, url), {}, Robot)
            self.scene = Scene(self.robot)
            self.positions: Floats = self.robot.positions(self._session.read()["positions"])
        except TrajoptError:
            self._client.close()
            raise
        self._motion: _Motion | None = None

    @property
    def moving(self) -> bool:
        motion = self._motion
        return motion is not None and motion.thread is not None and motion.thread.is_alive()

    @property
    def executor(self) -> Executor:
        raise MoveItCommanderException("the server drives the robot; there is no executor in this process")

    @property
    def _known(self) -> dict[str, object]:
        return {"robot": self.robot, "scene": self.scene}

    def stand(self, positions: Floats) -> None:
        self._session.edit([{"stand": positions.tolist()}])
        self.positions = positions

    def take(self, scene: Scene) -> None:
        """Send the scene to the server; the robot's links must be the server's."""
        if scene.robot is not self.robot:
            name = shown(self.robot.name)
            raise ModelError(f"the scene is of another robot than the server's {name}, which keeps its size")
        self._session.ask("hold", {"scene": message_of(scene, {"robot": self.robot})})
        self.scene = scene

    def ask(self, function: Callable[P, R], *args: P.args, **kwargs: P.kwargs) -> R:
        """Have the server call a function of `trajopt.server.move_group.functions`; return its result."""
        names = cast(Any, function).__code__.co_varnames
        stated = {**dict(zip(names, args, strict=False)), **kwargs}
        settings = cast(Settings, stated.pop("settings"))
        document = {
            "function": cast(Any, function).__name__,
            "arguments": message_of(stated, self._known),
            "settings": message_of(vars(settings), {}),
        }
        answer = self._session.ask("call", document)
        return cast(R, value_of_message(Node(answer, "answer"), self._known, object))

    def begin(self, execution: Execution, *, paced: bool) -> str:
        """Start a motion on the server; return the reason if it cannot start, else empty."""
        motion = _Motion()
        document = {
            "scene": message_of(execution.reduced.scene, self._known),
            "group": execution.reduced.group,
            "trajectory": message_of(execution.trajectory, {}),
            "speed": 1.0 if paced else 0.0,
        }

        def heard(told: dict[str, Any]) -> None:
            self.positions = self.robot.positions(told["positions"])
            motion.begun.set()

        def drive() -> None:
            try:
                motion.answer = self._session.ask("drive", document, listener=heard)
                self.positions = self.robot.positions(motion.answer["positions"])
            except ServerError as error:
                motion.error = error.reason
            finally:
                motion.begun.set()

        motion.thread = Thread(target=drive, name="drive", daemon=True)
        motion.thread.start()
        motion.begun.wait()
        self._motion = motion
        return motion.error or str(motion.answer.get("refused", ""))

    def wait(self) -> str:
        motion = self._motion
        if motion is None or motion.thread is None:
            return ""
        motion.thread.join()
        return motion.error or str(motion.answer.get("remark", ""))

    def stop(self) -> StopTaken | None:
        motion = self._motion
        if motion is None or motion.thread is None or not motion.thread.is_alive():
            return None
        self._session.stop()
        motion.thread.join()
        taken = motion.answer.get("stop")
        return None if taken is None else StopTaken(**taken)

    def close(self) -> None:
        try:
            self._session.close()
        finally:
            self._client.close()
