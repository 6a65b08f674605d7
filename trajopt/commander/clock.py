"""Moments and spans of time as ROS counts them: whole seconds and nanoseconds of the machine's clock."""

import time
from dataclasses import dataclass
from typing import Self

NANOSECONDS = 10**9


@dataclass(slots=True, order=True)
class Stamp:
    """Whole seconds and nanoseconds, as in every message of ROS; compared within one kind."""

    secs: float = 0
    nsecs: int = 0

    def __post_init__(self) -> None:
        """Carry fractions of seconds over to nanoseconds, as in `Duration(0.5)`."""
        total = round(self.secs * NANOSECONDS) + self.nsecs
        self.secs, self.nsecs = divmod(total, NANOSECONDS)

    def to_sec(self) -> float:
        """Return the seconds, of a moment since the epoch [s]."""
        return self.secs + self.nsecs / NANOSECONDS

    def to_nsec(self) -> int:
        """Return the nanoseconds, of a moment since the epoch [ns]."""
        return int(self.secs) * NANOSECONDS + self.nsecs

    @classmethod
    def from_sec(cls, seconds: float) -> Self:
        """Return a span of so many seconds, or the moment so many seconds after the epoch."""
        return cls(seconds)


class Duration(Stamp):
    """A span of time."""

    __slots__ = ()

    def __add__(self, other: "Duration") -> "Duration":
        """Return both spans one after the other."""
        return Duration(0, self.to_nsec() + other.to_nsec())

    def __sub__(self, other: "Duration") -> "Duration":
        """Return by how much this span is longer."""
        return Duration(0, self.to_nsec() - other.to_nsec())


class Time(Stamp):
    """A moment."""

    __slots__ = ()

    @classmethod
    def now(cls) -> "Time":
        """Return the present moment."""
        return cls(*divmod(time.time_ns(), NANOSECONDS))

    def __add__(self, span: Duration) -> "Time":
        """Return the moment a span later."""
        return Time(0, self.to_nsec() + span.to_nsec())

    def __sub__(self, other: "Time | Duration") -> "Duration | Time":
        """Return the span since another moment, or the moment a span earlier."""
        kind = Duration if isinstance(other, Time) else Time
        return kind(0, self.to_nsec() - other.to_nsec())


class Rate:
    """Keeps a loop to so many rounds in a second."""

    def __init__(self, hz: float, reset: bool = False) -> None:
        """Begin the first round now.

        Args:
            hz: Rounds in a second, > 0.
            reset: As in ROS, for clocks that jump back; this one does not.
        """
        self.sleep_dur = Duration(1.0 / hz)
        self._begun = time.monotonic()

    def remaining(self) -> Duration:
        """Return what is left of the round; nothing if it took too long."""
        left = self._begun + self.sleep_dur.to_sec() - time.monotonic()
        return Duration(max(left, 0.0))

    def sleep(self) -> None:
        """Sleep until the round ends, and begin the next."""
        left = self.remaining().to_sec()
        time.sleep(left)
        round_length = self.sleep_dur.to_sec()
        self._begun = self._begun + round_length if left > 0.0 else time.monotonic()
