"""Stands for what MoveIt's scripts call of `rospy`: there is no node, and time is the machine's clock."""

import logging
import sys
import time
from collections.abc import Callable, Sequence

from trajopt.files.messages import Duration as Duration
from trajopt.files.messages import Time as Time
from trajopt.ros.commander.topics import Publisher as Publisher
from trajopt.ros.commander.world import current_world, world_or_current

DEBUG, INFO, WARN, ERROR, FATAL = 1, 2, 4, 8, 16
"""Levels of the log, as `init_node` takes them."""

_LOG = logging.getLogger("trajopt.ros.commander")


class ROSException(Exception):
    """Never raised; here so that scripts may catch it."""


class ROSInterruptException(ROSException):
    """Never raised; here so that scripts may catch it."""


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


def init_node(
    name: str, argv: Sequence[str] | None = None, anonymous: bool = False, log_level: int = INFO, **_: object
) -> None:
    """Note the script's name: a script is a plain process here.

    Args:
        name: What the script calls itself.
        argv: As in ROS; names are not mapped to others.
        anonymous: As in ROS; there is one script only.
        log_level: As in ROS; the logger `trajopt.ros.commander` has its own.
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
    """Say whether `signal_shutdown` was called; a script ends when it ends."""
    world = current_world()
    return world is not None and world.node.shut_down


def signal_shutdown(reason: str) -> None:
    """Call what `on_shutdown` was given, and let `is_shutdown` be true."""
    _LOG.info("shutdown: %s", reason)
    world_or_current(None).node.end()


def on_shutdown(h: Callable[[], object]) -> None:
    """Call a function when the script ends."""
    world_or_current(None).node.hooks.append(h)


def spin() -> None:
    """Return at once: nothing would ever come in."""
    _LOG.info("rospy.spin() returns: nothing is received in a simulated world")


def has_param(param_name: str) -> bool:
    """Say whether there is a parameter of that name."""
    return world_or_current(None).node.has(param_name)


def search_param(param_name: str) -> str | None:
    """Return the full name of a parameter; None if there is none."""
    return f"/{param_name.removeprefix('/')}" if has_param(param_name) else None


def get_param(param_name: str, *default: object) -> object:
    """Return the value of a parameter, or the default where it is not set.

    Raises:
        KeyError: If it is not set and there is no default.
        MoveItCommanderException: If it is a text of the robot's files, which are not kept.
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
    """Sleep for so many seconds; a motion that was begun with `wait=False` goes on meanwhile."""
    time.sleep(duration if isinstance(duration, int | float) else duration.to_sec())


def logdebug(msg: str, *args: object) -> None:
    """Log what matters to programmers only to the logger `trajopt.ros.commander`."""
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
    """Log what ends a script to the logger `trajopt.ros.commander`."""
    _LOG.critical(msg, *args)
