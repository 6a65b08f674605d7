"""Events of a driven robot, and the journal that keeps them with the CPU time of each stage."""

import time
from collections.abc import Callable, Generator
from contextlib import contextmanager
from dataclasses import dataclass
from enum import Enum

from trajopt.values.arrays import Printed, Value


class EventKind(Enum):
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
    kind: EventKind
    words: str = ""

    def __str__(self) -> str:
        """Say it in a line."""
        return f"{self.time:9.3f} s  {self.kind.value}" + (f": {self.words}" if self.words else "")


KEPT = 100_000
"""So many times of a stage are kept, the last: half an hour of cycles, enough for one in ten thousand."""


class Journal(Printed):
    """What happened while a robot was driven, and the CPU time that each stage took.

    Attributes:
        events: What happened, in order.
        seconds: CPU time that each stage took, the last times [s].
    """

    def __init__(self, now: Callable[[], float]) -> None:
        """Begin.

        Args:
            now: Tells the time on the executor's clock [s].
        """
        self.events = list[Event]()
        self.seconds = dict[str, list[float]]()
        self._now, self._said = now, dict[EventKind, str]()

    def note(self, kind: EventKind, words: str = "") -> None:
        """Note what happened now."""
        self.events.append(Event(self._now(), kind, words))

    def note_once(self, kind: EventKind, words: str) -> None:
        """Note what may last only when it begins; empty words say that it is over."""
        if words and words != self._said.get(kind):
            self.note(kind, words)
        self._said[kind] = words

    @contextmanager
    def stage(self, name: str) -> Generator[None]:
        """Count the CPU time of the thread in what is done inside."""
        begun = time.thread_time()
        try:
            yield
        finally:
            times = self.seconds.setdefault(name, [])
            times.append(time.thread_time() - begun)
            if len(times) > KEPT:
                del times[: KEPT // 2]
