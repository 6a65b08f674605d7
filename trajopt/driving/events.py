"""What happened while a robot was driven, in the order of its clock."""

from dataclasses import dataclass
from enum import Enum

from trajopt.values.arrays import Value


class Kind(Enum):
    """Kinds of events."""

    OUTSIDE_LIMITS = "outside limits"
    STARTED = "started"
    REPLANNED = "replanned"
    GOAL_CHANGED = "goal changed"
    WORLD_CHANGED = "world changed"
    STILL_CLEAR = "still clear"
    SLOWING = "slowing"
    STOPPING = "stopping"
    STOPPED = "stopped"
    NO_PLAN = "no plan"
    MISSED_DEADLINE = "missed deadline"
    REJECTED = "rejected"
    OFF_TRACK = "off track"
    STALE = "stale prediction"
    FAULT = "fault"
    UNPROVEN_STOP = "unproven stop"
    RESUMED = "resumed"
    RECOVERING = "recovering"
    PASSED = "passed"
    REACHED = "reached"


@dataclass(frozen=True)
class Event(Value):
    """Something that happened.

    Attributes:
        time: On the executor's clock [s].
        kind: What kind of event it is.
        words: The particulars, in a sentence.
    """

    time: float
    kind: Kind
    words: str = ""

    def __str__(self) -> str:
        """Say it in a line."""
        return f"{self.time:9.3f} s  {self.kind.value}" + (f": {self.words}" if self.words else "")
