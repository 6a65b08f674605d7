"""Messages of `builtin_interfaces` (in ROS 1 built-in types): times and durations.

They count whole seconds and nanoseconds; ROS 1 names the fields `secs` and `nsecs` instead of `sec` and
`nanosec`.
"""

import time
from dataclasses import dataclass
from typing import Self

NANOSECONDS = 10**9


@dataclass(slots=True, order=True)
class Stamp:
    """Whole seconds and nanoseconds, as in every ROS message; comparable within one class."""

    secs: float = 0
    nsecs: int = 0

    def __post_init__(self) -> None:
        """Carry fractions of seconds over to nanoseconds, as in `Duration(0.5)`."""
        total = round(self.secs * NANOSECONDS) + self.nsecs
        self.secs, self.nsecs = divmod(total, NANOSECONDS)

    def to_sec(self) -> float:
        """Return the duration, or the time since the epoch [s]."""
        return self.secs + self.nsecs / NANOSECONDS

    def to_nsec(self) -> int:
        """Return the duration, or the time since the epoch [ns]."""
        return int(self.secs) * NANOSECONDS + self.nsecs

    @classmethod
    def from_sec(cls, seconds: float) -> Self:
        """Return the duration of `seconds`, or the time at `seconds` after the epoch."""
        return cls(seconds)


class Duration(Stamp):
    """A span of time."""

    __slots__ = ()

    def __add__(self, other: "Duration") -> "Duration":
        """Return the sum of both durations."""
        return Duration(0, self.to_nsec() + other.to_nsec())

    def __sub__(self, other: "Duration") -> "Duration":
        """Return the difference of both durations."""
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
        """Return the duration since another time, or the time earlier by a duration."""
        kind = Duration if isinstance(other, Time) else Time
        return kind(0, self.to_nsec() - other.to_nsec())
