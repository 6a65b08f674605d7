"""Stands for what MoveIt's scripts call of `rospy`: there is no node, and time is the machine's clock."""

import logging
import time
from dataclasses import dataclass

NANOSECONDS = 10**9
_LOG = logging.getLogger("trajopt.commander")


class ROSInterruptException(Exception):
    """Never raised; here so that scripts may catch it."""


@dataclass(slots=True)
class Duration:
    """A span of time in whole seconds and nanoseconds."""

    secs: float = 0
    nsecs: int = 0

    def __post_init__(self) -> None:
        """Carry fractions of seconds over to nanoseconds, as in `Duration(0.5)`."""
        total = round(self.secs * NANOSECONDS) + self.nsecs
        self.secs, self.nsecs = divmod(total, NANOSECONDS)

    def to_sec(self) -> float:
        """Return the seconds [s]."""
        return self.secs + self.nsecs / NANOSECONDS

    @classmethod
    def from_sec(cls, seconds: float) -> "Duration":
        """Return a span of so many seconds."""
        return cls(seconds)


@dataclass(slots=True)
class Time:
    """A moment in whole seconds and nanoseconds."""

    secs: int = 0
    nsecs: int = 0

    def to_sec(self) -> float:
        """Return the seconds since the epoch [s]."""
        return self.secs + self.nsecs / NANOSECONDS

    @classmethod
    def now(cls) -> "Time":
        """Return the present moment."""
        return cls(*divmod(time.time_ns(), NANOSECONDS))


def init_node(name: str, anonymous: bool = False, disable_signals: bool = False) -> None:
    """Do nothing: a script is a plain process here."""


def is_shutdown() -> bool:
    """Say that nothing has been shut down: a script ends when it ends."""
    return False


def get_time() -> float:
    """Return the time [s]."""
    return time.time()


def sleep(duration: float | Duration) -> None:
    """Sleep for so many seconds; a motion that was begun with `wait=False` goes on meanwhile."""
    time.sleep(duration if isinstance(duration, int | float) else duration.to_sec())


def loginfo(msg: str, *args: object) -> None:
    """Log to the logger `trajopt.commander`."""
    _LOG.info(msg, *args)


def logwarn(msg: str, *args: object) -> None:
    """Log a warning to the logger `trajopt.commander`."""
    _LOG.warning(msg, *args)


def logerr(msg: str, *args: object) -> None:
    """Log an error to the logger `trajopt.commander`."""
    _LOG.error(msg, *args)
