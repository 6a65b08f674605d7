"""State of a remote robot, and its source."""

from dataclasses import dataclass
from typing import Any, cast

from trajopt.driving import Event, EventKind
from trajopt.files.bundle.message import value_of_message
from trajopt.robot.robot import Robot
from trajopt.scene.scene import Scene
from trajopt.values.arrays import Floats, Value, floats
from trajopt.values.documents.document import Node
from trajopt.values.errors import MissingExtra


@dataclass(frozen=True, eq=False, kw_only=True)
class State(Value):
    """State of a remote robot.

    Attributes:
        revision: Changes whenever the surroundings change.
        positions: Of all joints, shape (number of joints,) [rad | m].
        driven: Whether it is being driven.
        ahead: Positions of all joints along the rest of its motion, shape (k, number of joints); None
            if unknown.
        events: Published events, in order.
    """

    revision: int
    positions: Floats
    driven: bool
    ahead: Floats | None = None
    events: tuple[Event, ...] = ()

    def as_dict(self) -> dict[str, Any]:
        """Return plain data that JSON can hold."""
        return {
            "revision": self.revision,
            "positions": self.positions.tolist(),
            "driven": self.driven,
            "ahead": None if self.ahead is None else self.ahead.tolist(),
            "events": [
                {"time": each.time, "kind": each.kind.value, "words": each.words} for each in self.events
            ],
        }


def state_of(node: Node, joints: int) -> State:
    """Return the state in a document.

    Args:
        node: The document.
        joints: Number of the robot's joints.

    Raises:
        FileFormatError: If its content is invalid.
        ShapeError: If the positions are not one finite number for each joint.
    """
    ahead = node["ahead"]
    return State(
        revision=int(node["revision"].number()),
        positions=floats("positions", cast("Any", node["positions"].value), (joints,)),
        driven=node["driven"].flag(),
        ahead=None if ahead.missing else floats("ahead", cast("Any", ahead.value), (None, joints)),
        events=tuple(_event(each) for each in node["events"].elements()),
    )


def _event(node: Node) -> Event:
    name = node["kind"].text()
    if name not in {each.value for each in EventKind}:
        raise node["kind"].error(f"{name!r} is not a kind of event")
    return Event(node["time"].number(), EventKind(name), node["words"].text(""))


PATIENCE = 5.0
"""Time-out of a request [s]."""


class Source:
    """A mirrored address.

    Attributes:
        url: The address.
        robot: The robot there.
    """

    def __init__(self, url: str, *, token: str = "") -> None:
        """Request the robot.

        Args:
            url: Of a session of a server ("http://127.0.0.1:8080/sessions/ID"), or of a run.
            token: Access token of the server.

        Raises:
            MissingExtra: If httpx is not installed.
            ServerError: If the address does not answer, or refuses.
            FileFormatError: If the answer cannot be mirrored.
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
        """Return the present state of the robot.

        Raises:
            ServerError: If the address does not answer.
            FileFormatError: If the answer is invalid.
        """
        return state_of(self._asked("GET", "state"), len(self.robot.joint_names))

    def scene(self) -> Scene:
        """Return the present surroundings.

        Raises:
            ServerError: If the address does not answer.
            FileFormatError: If the answer is invalid.
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
