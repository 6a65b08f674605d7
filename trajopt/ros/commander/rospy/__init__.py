"""Stand-in for the part of `rospy` that MoveIt's scripts use, without a node; time is wall time."""

import logging
import sys
import time
from collections.abc import Callable, Sequence

from trajopt.files.messages import Duration as Duration
from trajopt.files.messages import Time as Time
from trajopt.ros.commander.topics import Publisher as Publisher
from trajopt.ros.commander.world import current_world, world_or_current

DEBUG, INFO, WARN, ERROR, FATAL = 1, 2, 4, 8, 16
"""Log levels for `init_node`."""

_LOG = logging.getLogger("trajopt.ros.commander")


class ROSException(Exception):
    """Never raised; here so that scripts may catch it."""


class ROSInterruptException(ROSException):
    """Never raised; here so that scripts may catch it."""


class Rate:
    """Runs a loop at a fixed rate."""

    def __init__(self, hz: float, reset: bool = False) -> None:
        """Start the first period now.

        Args:
            hz: Rate [1/s], > 0.
            reset: As in ROS, for clocks that jump back; this clock does not.
        """
        self.sleep_dur = Duration(1.0 / hz)
        self._begun = time.monotonic()

    def remaining(self) -> Duration:
        """Return the rest of the period; 0 if it is over."""
        left = self._begun + self.sleep_dur.to_sec() - time.monotonic()
        return Duration(max(left, 0.0))

    def sleep(self) -> None:
        """Sleep until the period ends, and start the next."""
        left = self.remaining().to_sec()
        time.sleep(left)
        round_length = self.sleep_dur.to_sec()
        self._begun = self._begun + round_length if left > 0.0 else time.monotonic()


def init_node(
    name: str, argv: Sequence[str] | None = None, anonymous: bool = False, log_level: int = INFO, **_: object
) -> None:
    """Record the script's name.

    Args:
        name: The script's name.
        argv: As in ROS; ignored, names are not remapped.
        anonymous: As in ROS; ignored, there is only one script.
        log_level: As in ROS; ignored, the logger `trajopt.ros.commander` has its own.
    """
    world = current_world()
    if world is not None:
        world.node.name = name


def get_name() -> str:
    """Return the script's name, with a slash."""
    return f"/{world_or_current(None).node.name}"


def myargv(argv: Sequence[str] | None = None) -> list[str]:
    """Return the arguments of the script without those that map names (`a:=b`)."""
    return [word for word in (sys.argv if argv is None else argv) if ":=" not in word]


def is_shutdown() -> bool:
    """Return whether `signal_shutdown` was called; the script itself decides when to end."""
    world = current_world()
    return world is not None and world.node.shut_down


def signal_shutdown(reason: str) -> None:
    """Call the `on_shutdown` hooks, and make `is_shutdown` return True."""
    _LOG.info("shutdown: %s", reason)
    world_or_current(None).node.end()


def on_shutdown(h: Callable[[], object]) -> None:
    """Call a function when the script ends."""
    world_or_current(None).node.hooks.append(h)


def spin() -> None:
    """Return immediately; no messages arrive."""
    _LOG.info("rospy.spin() returns: nothing is received in a simulated world")


def has_param(param_name: str) -> bool:
    """Return whether a parameter of that name exists."""
    return world_or_current(None).node.has(param_name)


def search_param(param_name: str) -> str | None:
    """Return the full name of a parameter; None if it does not exist."""
    return f"/{param_name.removeprefix('/')}" if has_param(param_name) else None


def get_param(param_name: str, *default: object) -> object:
    """Return the value of a parameter, or the default if it is not set.

    Raises:
        KeyError: If it is not set and no default is given.
        MoveItCommanderException: If it is the text of a robot file, which is not kept.
    """
    node = world_or_current(None).node
    return default[0] if default and not node.has(param_name) else node.parameter(param_name)


def set_param(param_name: str, param_value: object) -> None:
    """Set a parameter."""
    world_or_current(None).node.parameters[param_name.removeprefix("/")] = param_value


def get_time() -> float:
    """Return the time [s]."""
    return time.time()


def get_rostime() -> Time:
    """Return the present moment."""
    return Time.now()


def sleep(duration: float | Duration) -> None:
    """Sleep for a duration [s]; a motion started with `wait=False` continues."""
    time.sleep(duration if isinstance(duration, int | float) else duration.to_sec())


def logdebug(msg: str, *args: object) -> None:
    """Log a debug message to the logger `trajopt.ros.commander`."""
    _LOG.debug(msg, *args)


def loginfo(msg: str, *args: object) -> None:
    """Log to the logger `trajopt.ros.commander`."""
    _LOG.info(msg, *args)


def logwarn(msg: str, *args: object) -> None:
    """Log a warning to the logger `trajopt.ros.commander`."""
    _LOG.warning(msg, *args)


def logerr(msg: str, *args: object) -> None:
    """Log an error to the logger `trajopt.ros.commander`."""
    _LOG.error(msg, *args)


def logfatal(msg: str, *args: object) -> None:
    """Log a fatal error to the logger `trajopt.ros.commander`."""
    _LOG.critical(msg, *args)
