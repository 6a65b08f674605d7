"""Events of a driven robot, and their journal with CPU times."""

import time
from collections.abc import Callable, Generator
from contextlib import contextmanager
from dataclasses import dataclass
from enum import Enum

from trajopt.values.arrays import Printed, Value

KEPT_TIMES = 100_000
"""CPU times kept for each stage: half an hour of cycles."""


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
    PLANNED = "planned"
    GRASPED = "grasped"
    NOT_GRASPED = "not grasped"
    RELEASED = "released"
    LOST = "lost"
    SKIPPED = "skipped"
    COMPLETED = "completed"


@dataclass(frozen=True)
class Event(Value):
    """An event.

    Attributes:
        time: On the executor's clock [s].
        words: Particulars, in a sentence.
        stage: Stages of the task, with their steps; empty without a task.
    """

    time: float
    kind: EventKind
    words: str = ""
    stage: str = ""

    @property
    def message(self) -> str:
        """Stage and particulars."""
        return ": ".join(filter(None, (self.stage, self.words)))

    def as_dict(self) -> dict[str, object]:
        """Return plain data for JSON."""
        return {"time": self.time, "kind": self.kind.value, "words": self.message}

    def __str__(self) -> str:
        return f"{self.time:9.3f} s  {': '.join(filter(None, (self.kind.value, self.message)))}"


class Journal(Printed):
    """Events, and the CPU time of each stage."""

    def __init__(self, now: Callable[[], float]) -> None:
        """`now` returns the time on the executor's clock [s]."""
        self.events = list[Event]()
        self.seconds = dict[str, list[float]]()
        self.task_stage = ""
        self._now, self._lasting = now, dict[EventKind, str]()

    def note(self, kind: EventKind, words: str = "") -> None:
        self.events.append(Event(self._now(), kind, words, self.task_stage))

    def note_once(self, kind: EventKind, words: str) -> None:
        if words and words != self._lasting.get(kind):
            self.note(kind, words)
        self._lasting[kind] = words

    def note_unless_latest(self, kind: EventKind, words: str) -> None:
        if not self.latest_is(kind):
            self.note(kind, words)

    def latest_is(self, kind: EventKind) -> bool:
        return bool(self.events) and self.events[-1].kind is kind

    @contextmanager
    def stage(self, name: str) -> Generator[None]:
        begun = time.thread_time()
        try:
            yield
        finally:
            times = self.seconds.setdefault(name, [])
            times.append(time.thread_time() - begun)
            if len(times) > KEPT_TIMES:
                del times[: KEPT_TIMES // 2]
