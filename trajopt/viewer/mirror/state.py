"""State: what a mirror is told, again and again: where a robot is, and what has changed."""

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
    """Where a robot is.

    Attributes:
        revision: Another number whenever what is around the robot has changed.
        positions: Of all joints, shape (number of joints,) [rad | m].
        driven: Whether it is being driven.
        ahead: Positions of all joints along what is left of its motion, shape (k, number of joints); None
            where nobody says.
        events: What happened, in order; as far as is told.
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
    """Return the state that a document says, whoever sent it.

    Args:
        node: The document.
        joints: How many joints the robot has.

    Raises:
        FileFormatError: If it does not say what it must.
        ShapeError: If there is not one finite position for each joint.
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
        raise node["kind"].error(f"{name!r} is no kind of event")
    return Event(node["time"].number(), EventKind(name), node["words"].text(""))


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
