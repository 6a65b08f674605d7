"""Operation: a function of the server that runs in a worker."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import Enum, auto
from importlib import import_module
from typing import TypeAlias, cast

from trajopt.server.state import SessionState
from trajopt.server.watch import Watch
from trajopt.values.arrays import Value
from trajopt.values.documents.document import Node
from trajopt.values.errors.arguments import checked


class Lane(Enum):
    """Group of processes: planning, fast operations, driving, 3-D pages, storage.

    Each open 3-D page has its own process. The process that stores sessions runs no requests of clients.
    """

    PLANNING = auto()
    QUICK = auto()
    DRIVING = auto()
    VIEWING = auto()
    KEEPING = auto()

    @property
    def takes_robot(self) -> bool:
        """Whether the robot of the session belongs to the request while it lasts."""
        return self in (Lane.DRIVING, Lane.VIEWING)


@checked
@dataclass(frozen=True)
class Answer(Value):
    """Result of an operation.

    Attributes:
        document: The answer, plain data for JSON.
        state: The new content of the session; None if unchanged.
    """

    document: object
    state: SessionState | None = None


Run: TypeAlias = Callable[[SessionState, Node, Watch], Answer]
"""Content of the session, arguments, and the watch -> the answer.

It raises a `TrajoptError` for invalid arguments, whose message is sent to the client.
"""


@checked
@dataclass(frozen=True)
class Operation(Value):
    """An operation of the server.

    Attributes:
        run: The function.
        lane: Its group of processes.
        edits: Whether it may change the session: such requests are serialised.
        attached: Whether it accepts bytes in addition to its arguments.
    """

    run: Run
    lane: Lane = Lane.PLANNING
    edits: bool = False
    attached: bool = False


def operations_of(modules: tuple[str, ...]) -> Mapping[str, Operation]:
    """Return the operations of modules by name, from their `OPERATIONS`."""
    found: dict[str, Operation] = {}
    for module in modules:
        found.update(cast("Mapping[str, Operation]", import_module(module).OPERATIONS))
    return found
