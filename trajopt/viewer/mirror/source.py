"""Source: what a mirror asks at an address: the robot once, where it is often, the scene when it changed."""

from trajopt.files.bundle.message import value_of_message
from trajopt.robot.robot import Robot
from trajopt.scene.scene import Scene
from trajopt.values.documents.document import Node
from trajopt.values.errors import MissingExtra
from trajopt.viewer.mirror.state import State, state_of

PATIENCE = 5.0
"""Whoever says nothing for so long is asked again [s]."""


class Source:
    """What is at an address.

    Attributes:
        url: The address.
        robot: The robot there.
    """

    def __init__(self, url: str, *, token: str = "") -> None:
        """Ask for the robot.

        Args:
            url: Of a session of a server ("http://127.0.0.1:8080/sessions/ID"), or of a run.
            token: What a server lets in with.

        Raises:
            MissingExtra: If httpx is not installed.
            ServerError: If nobody answers there, or refuses.
            FileFormatError: If what answers is none that can be mirrored.
        """
        try:
            from trajopt.server.client import Client
            from trajopt.server.client.calls import Call
        except ImportError as error:
            raise MissingExtra("httpx", "server") from error
        self.url = url.rstrip("/")
        self._client, self._call = Client(self.url, token=token, patience=0.0, timeout=PATIENCE), Call
        try:
            self.robot = value_of_message(self._asked("POST", "robot"), {}, Robot)
        except BaseException:
            self._client.close()
            raise

    def state(self) -> State:
        """Return where the robot is.

        Raises:
            ServerError: If nobody answers.
            FileFormatError: If it does not say what it must.
        """
        return state_of(self._asked("GET", "state"), len(self.robot.joint_names))

    def scene(self) -> Scene:
        """Return what is around it, as it stands now.

        Raises:
            ServerError: If nobody answers.
            FileFormatError: If it does not say what it must.
        """
        known = {"robot": self.robot}
        return value_of_message(self._asked("POST", "scene"), known, Scene).still_at(0.0)

    def close(self) -> None:
        """Close the connection."""
        self._client.close()

    def _asked(self, method: str, path: str) -> Node:
        body: dict[str, object] | None = {} if method == "POST" else None
        answer: object = self._client.send(self._call(method, f"/{path}", body))
        return Node(answer, f"{self.url}/{path}")
