"""State: what a mirror is told, again and again: where a robot is, and what has changed."""

from dataclasses import dataclass
from typing import Any, cast

from trajopt.driving import Event, Kind
from trajopt.values.arrays import Floats, Value, floats
from trajopt.values.documents.document import Node


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
    if name not in {each.value for each in Kind}:
        raise node["kind"].error(f"{name!r} is no kind of event")
    return Event(node["time"].number(), Kind(name), node["words"].text(""))
