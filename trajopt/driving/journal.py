"""Journal: what happened while a robot was driven, and the CPU time that each stage took."""

import time
from collections.abc import Callable, Generator
from contextlib import contextmanager

from trajopt.driving.events import Event, Kind
from trajopt.values.arrays import Printed

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
        self._now, self._said = now, dict[Kind, str]()

    def note(self, kind: Kind, words: str = "") -> None:
        """Note what happened now."""
        self.events.append(Event(self._now(), kind, words))

    def note_once(self, kind: Kind, words: str) -> None:
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
