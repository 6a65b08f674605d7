"""Operation: a thing that clients can ask for; a function that runs in a worker."""

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
    """Which processes do it: those that plan, the one for what takes milliseconds, those that drive.

    Each 3-D page has one while it is open. Where sessions are kept on disk one process does that, and nothing
    that clients ask.
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
    """What an operation returns.

    Attributes:
        document: The answer, plain data that JSON can hold.
        state: What the session holds from now on; None where it stays as it was.
    """

    document: object
    state: SessionState | None = None


Run: TypeAlias = Callable[[SessionState, Node, Watch], Answer]
"""What the session holds, the arguments, and how to tell of it -> the answer.

It raises a `TrajoptError` where the arguments are wrong: the client is told what it says.
"""


@checked
@dataclass(frozen=True)
class Operation(Value):
    """A thing that clients can ask for.

    Attributes:
        run: Does it.
        lane: Which processes do it.
        edits: Whether it may change what the session holds: such requests wait for each other.
        attached: Whether it takes bytes beside its arguments.
    """

    run: Run
    lane: Lane = Lane.PLANNING
    edits: bool = False
    attached: bool = False


def operations_of(modules: tuple[str, ...]) -> Mapping[str, Operation]:
    """Return the operations of some modules by name: what each of them calls `OPERATIONS`."""
    found: dict[str, Operation] = {}
    for module in modules:
        found.update(cast("Mapping[str, Operation]", import_module(module).OPERATIONS))
    return found
